"""The plant in place of the robot: sensors out, the flight controller's inner loop inside."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping

import numpy as np

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.body import Bodies
from skylimb.analysis.exchange.frames import felt_by
from skylimb.analysis.exchange.lab_messages import floats, vector
from skylimb.analysis.exchange.lab_ticks import TickView
from skylimb.analysis.exchange.lab_topics import is_due
from skylimb.analysis.exchange.messages import (
    Desire,
    FourAxes,
    Gains,
    Joints,
    MotorInfo,
    PMatrix,
    ServoStates,
    ServoTargets,
    ServoTorques,
    TorqueInverse,
    UavInfo,
)
from skylimb.apps.ros.attitude_filter import AttitudeFilter
from skylimb.apps.ros.attitude_loop import attitude_loop, forced_by
from skylimb.apps.ros.grounded import GroundedPlant
from skylimb.apps.ros.messages import Arrived, Outgoing, published
from skylimb.apps.ros.profile import LAB, Dialect, PendingRun
from skylimb.apps.ros.servos import Servos
from skylimb.apps.ros.spinal import Spinal
from skylimb.apps.ros.states import Arming
from skylimb.apps.ros.tick import Tick
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.control.records import Command
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.takeoff import Takeoff

VOLTS = 4.1
"""Of a cell of the simulated battery."""


MAGNETIC_FIELD = np.array([0.3, 0.0, -0.35])
"""Of the earth, W, gauss: x points north."""


class Simulated:
    """A tick of the robot that the lab's stack flies: the plant's own ticks are those of the inner loop.

    Args:
        takeoff: plant and robot, at the inner loop's rate.
        link: whose pose is on the lab's topics.
        pacer: of the node's ticks; a whole number of the plant's.
        cells: of the battery.
        servos: by whose counts it speaks of joints; None for angles by name.
        start: angles by the lab's names of joints and gimbals with which it stands, rad; others are the
            mission's first ones.
        slows: whether others live by its time, which `/clock` tells: it goes on by a period a tick, however
            long that took, so that a busy computer loses nothing.
        dialect: how it speaks.
    """

    def __init__(
        self,
        takeoff: Takeoff,
        link: str,
        pacer: Pacer,
        cells: int = 6,
        servos: Servos | None = None,
        start: Mapping[str, float] | None = None,
        slows: bool = False,
        dialect: Dialect = LAB,
    ) -> None:
        self.slows = slows
        self.caught_up = 1 if slows else math.inf
        robot = takeoff.robot
        self._period, self._pacer, self._cells = takeoff.period, pacer, cells
        self._inner = round(pacer.period / takeoff.period)
        self._bodies, self._names, self._servos = Bodies(robot, link), dialect.named(robot, ""), servos
        offered = dialect.topics("simulator", servos is not None).published
        self._topics = tuple(topic for topic in offered if slows or topic is not topics.CLOCK)
        self._robot, self._link, self._forces = robot, link, list[np.ndarray]()
        self._spinal, self._limits = Spinal(robot.n_rotors), robot.thrust_limits()
        for message in dialect.known(robot.n_rotors):
            self._spinal = self._spinal.received(message, 0.0)
        self._bounds = np.concatenate([robot.joint_limits(), robot.vectoring_limits()], axis=1)
        first = takeoff.mission.first
        self._angles = np.concatenate([first.joint_angles, first.vectoring_angles])
        self._start(start or {})
        self.plant, self._on = GroundedPlant(takeoff, self._angles), np.ones(len(self._angles))
        self._n_joints, self._k = robot.n_joints, 0
        self._begun: float | None = None
        self._attitude: AttitudeFilter | None = None
        self.faults: Counter[str] = Counter()
        self.last: Tick | None = None
        self.kept: list[PendingRun] = []

    @property
    def over(self) -> str:
        """Why it cannot go on; empty while it can."""
        return self.plant.over

    def tick(self, arrived: Iterable[Arrived], stamp: float) -> list[Outgoing]:
        """One tick; `stamp` is the middleware's time, s: where it `slows` only that of the first one."""
        now, landing = self._pacer.time(), self._spinal.force_landing
        if self.slows:
            self._begun = stamp if self._begun is None else self._begun
            now = self._k * self._pacer.period
            stamp = self._begun + now
        out = [answer for one in arrived for answer in self._take(one, now)]
        measured = self.plant.measure()
        felt = newest = felt_by(self._robot, self._link, measured.imu)
        if felt is not None:  # the force is the mean since the last message
            felt = felt[0], np.mean([*self._forces, felt[1]], axis=0)
        self._forces.clear()
        for inner in range(self._inner):
            if inner:
                newest = felt_by(self._robot, self._link, self.plant.measure().imu)
                self._forces += [] if newest is None else [newest[1]]
            self._step(now + inner * self._period, newest)
        if self._spinal.force_landing and not landing:
            # A forced landing of its own is acknowledged like one that was commanded.
            out.append(Outgoing(topics.ACK, int(Arming.FORCE_LANDING)))
            self.faults[f"forced landing: {forced_by(self._spinal, now + self._pacer.period)}"] += 1
        body, angles = self._bodies.of(measured), np.concatenate(measured[4:6])
        field = vector(body.R_W_link.T @ MAGNETIC_FIELD)
        believed = None if self._attitude is None else self._attitude.R
        view = TickView(stamp, self._names, body, angles, felt=felt, magnetic_field=field, attitude=believed)
        out += published(self._topics, view, self._k, self._pacer.period)
        if self._servos is not None and is_due(topics.SERVO_STATES, self._k, self._pacer.period):
            counts = self._servos.counts(dict(zip(self._all_names, floats(angles), strict=True)))
            out.append(Outgoing(topics.SERVO_STATES, ServoStates(stamp, tuple(counts.items()))))
        if is_due(topics.BATTERY, self._k, self._pacer.period):
            out.append(Outgoing(topics.BATTERY, VOLTS * self._cells))
            out.append(Outgoing(topics.PWMS, self._spinal.pwms(stamp, VOLTS * self._cells)))
            out.append(Outgoing(topics.RPY_PID, self._spinal.pid()))
        self._k += 1
        return out

    def close(self) -> None:
        """Nothing is kept."""

    @property
    def _all_names(self) -> tuple[str, ...]:
        return (*self._names.joints, *self._names.gimbals)

    def _start(self, start: Mapping[str, float]) -> None:
        """Stand with these angles."""
        for name, angle in start.items():
            if name not in self._all_names:
                raise unknown_name("joint of --start", name, self._all_names)
            at = self._all_names.index(name)
            low, high = self._bounds[:, at]
            if not (isinstance(angle, int | float) and np.isfinite(angle) and low <= angle <= high):
                raise ConfigError(f"--start {name}={angle} is no angle within {low:g} and {high:g} rad")
            self._angles[at] = angle

    def _step(self, now: float, felt: tuple[np.ndarray, np.ndarray] | None) -> None:
        """A tick of the inner loop and of the plant; the board's attitude and rates are those of its IMU."""
        body = self._bodies.of(self.plant.truth())
        R, rates = body.R_W_link, body.rates_link
        if felt is not None:
            field = R.T @ MAGNETIC_FIELD
            before = self._attitude or AttitudeFilter(R[2] * self._robot.description.gravity, field)
            self._attitude = before.after(*felt, field, self._period)
            R, rates = self._attitude.R, felt[0]
        self._spinal, thrusts = attitude_loop(self._spinal, R, rates, now, self._period, self._limits)
        if len(gimbals := self._spinal.gimbals) == len(self._angles) - self._n_joints:
            self._angles[self._n_joints :] = gimbals.clip(*self._bounds[:, self._n_joints :])
        n = self._n_joints
        self.plant.apply(Command(thrusts, self._angles[:n], self._angles[n:]))

    def _take(self, one: Arrived, now: float) -> list[Outgoing]:
        """What the flight controller and the servos make of a message."""
        match one.value:
            case FourAxes() | Gains() | PMatrix() | TorqueInverse() | UavInfo() | MotorInfo() | Desire():
                self._spinal = self._spinal.received(one.value, now)
            case ServoTargets(numbers, counts) if self._servos is not None:
                self._bend(self._servos.angles(zip(numbers, counts, strict=True)), one.topic)
            case ServoTorques(numbers, on) if self._servos is not None:
                for name, switch in self._servos.named(zip(numbers, on, strict=True)):
                    self._on[self._all_names.index(name)] = float(switch > 0)
                self.plant.enable(self._on)
            case Joints(_, names, angles):
                self._bend(dict(zip(names, angles, strict=False)), one.topic)
            case int() if one.topic == topics.GIMBAL_DOF.name:
                self._spinal = self._spinal.with_gimbals(one.value)
            case int():
                self._spinal = self._spinal.configured(one.value)
                if one.value != Arming.ON or self._spinal.armed:
                    return [Outgoing(topics.ACK, one.value)]
                self.faults["armed without motor_info and uav_info: not acknowledged"] += 1
        return []

    def _bend(self, known: dict[str, float], topic: str) -> None:
        """Set points of servos, by name, within their limits."""
        if not all(map(math.isfinite, known.values())):
            self.faults[f"{topic}: no number"] += 1
            return
        set_points = [
            known.get(name, point) for name, point in zip(self._all_names, self._angles, strict=True)
        ]
        self._angles = np.array(set_points).clip(*self._bounds)
