"""The plant in place of the robot: sensors out, the flight controller's inner loop inside."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import numpy as np

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.body import Bodies
from skylimb.analysis.exchange.frames import felt_by
from skylimb.analysis.exchange.lab_messages import Names, TickView, floats
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
    TorqueInverse,
    UavInfo,
)
from skylimb.apps.ros1.grounded import GroundedPlant
from skylimb.apps.ros1.messages import Arrived, Outgoing, published
from skylimb.apps.ros1.profile import PendingRun, profile_topics
from skylimb.apps.ros1.servos import Servos
from skylimb.apps.ros1.spinal import Spinal, attitude_loop
from skylimb.apps.ros1.states import Arming
from skylimb.apps.ros1.tick import Tick
from skylimb.control.records import Command
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.takeoff import Takeoff

VOLTS = 4.1
"""Of a cell of the simulated battery."""


class Simulated:
    """A tick of the robot that the lab's stack flies: the plant's own ticks are those of the inner loop.

    Args:
        takeoff: plant and robot, at the inner loop's rate.
        link: whose pose is on the lab's topics.
        pacer: of the node's ticks; a whole number of the plant's.
        cells: of the battery.
        servos: by whose counts it speaks of joints; None for angles by name.
    """

    def __init__(
        self, takeoff: Takeoff, link: str, pacer: Pacer, cells: int = 6, servos: Servos | None = None
    ) -> None:
        robot = takeoff.robot
        self.plant = GroundedPlant(takeoff)
        self._period, self._pacer, self._cells = takeoff.period, pacer, cells
        self._inner = round(pacer.period / takeoff.period)
        self._bodies, self._names, self._servos = Bodies(robot, link), Names(robot), servos
        self._topics = profile_topics("simulator", servos is not None).published
        self._robot, self._link, self._forces = robot, link, list[np.ndarray]()
        self._spinal, self._limits = Spinal(robot.n_rotors), robot.thrust_limits()
        self._bounds = np.concatenate([robot.joint_limits(), robot.vectoring_limits()], axis=1)
        first = takeoff.mission.first
        self._angles = np.concatenate([first.joint_angles, first.vectoring_angles])
        self._n_joints, self._k = robot.n_joints, 0
        self.faults: Counter[str] = Counter()
        self.last: Tick | None = None
        self.kept: list[PendingRun] = []

    @property
    def over(self) -> str:
        """Why it cannot go on; empty while it can."""
        return self.plant.over

    def tick(self, arrived: Iterable[Arrived], stamp: float) -> list[Outgoing]:
        """One tick; `stamp` is the middleware's time, s."""
        now, landing = self._pacer.time(), self._spinal.force_landing
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
        body, angles = self._bodies.of(measured), np.concatenate(measured[4:6])
        view = TickView(stamp, self._names, body, angles, felt=felt, magnetic_field=(0.0, 0.0, 0.0))
        out += published(self._topics, view, self._k, self._pacer.period)
        if self._servos is not None and is_due(topics.SERVO_STATES, self._k, self._pacer.period):
            counts = self._servos.counts(dict(zip(self._all_names, floats(angles), strict=True)))
            out.append(Outgoing(topics.SERVO_STATES, ServoStates(stamp, tuple(counts.items()))))
        if is_due(topics.BATTERY, self._k, self._pacer.period):
            out.append(Outgoing(topics.BATTERY, VOLTS * self._cells))
            out.append(Outgoing(topics.PWMS, self._spinal.pwms(stamp)))
        self._k += 1
        return out

    def close(self) -> None:
        """Nothing is kept."""

    @property
    def _all_names(self) -> tuple[str, ...]:
        return (*self._names.joints, *self._names.gimbals)

    def _step(self, now: float, felt: tuple[np.ndarray, np.ndarray] | None) -> None:
        """A tick of the inner loop and of the plant; the board's rates are those of its IMU."""
        body = self._bodies.of(self.plant.truth())
        rates = body.rates_link if felt is None else felt[0]
        self._spinal, thrusts = attitude_loop(
            self._spinal, body.R_W_link, rates, now, self._period, self._limits
        )
        self.plant.apply(Command(thrusts, *np.split(self._angles, [self._n_joints])))

    def _take(self, one: Arrived, now: float) -> list[Outgoing]:
        """What the flight controller and the servos make of a message."""
        match one.value:
            case FourAxes():
                self._spinal = self._spinal.commanded(one.value, now)
            case Gains():
                self._spinal = self._spinal.gained(one.value)
            case PMatrix():
                self._spinal = self._spinal.with_p_matrix(one.value)
            case TorqueInverse():
                self._spinal = self._spinal.with_torque_inverse(one.value)
            case UavInfo() | MotorInfo():
                self._spinal = self._spinal.informed(one.value)
            case ServoTargets(numbers, counts) if self._servos is not None:
                self._bend(self._servos.angles(zip(numbers, counts, strict=True)), one.topic)
            case Desire(roll, pitch, yaw):
                self._spinal = self._spinal.desired(roll, pitch, yaw)
            case Joints(_, names, angles):
                self._bend(dict(zip(names, angles, strict=False)), one.topic)
            case int():
                self._spinal = self._spinal.configured(one.value)
                if one.value != Arming.ON or self._spinal.armed:
                    return [Outgoing(topics.ACK, one.value)]
                self.faults["armed without motor_info and uav_info: not acknowledged"] += 1
        return []

    def _bend(self, known: dict[str, float], topic: str) -> None:
        """Set points of servos, by name, within their limits."""
        if not np.isfinite(list(known.values())).all():
            self.faults[f"{topic}: no number"] += 1
            return
        set_points = [
            known.get(name, point) for name, point in zip(self._all_names, self._angles, strict=True)
        ]
        self._angles = np.clip(np.array(set_points), *self._bounds)
