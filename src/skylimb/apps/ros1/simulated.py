"""The plant in place of the robot: sensors out, the flight controller's inner loop inside."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

import numpy as np

from skylimb.apps.ros1 import topics
from skylimb.apps.ros1.body import Bodies
from skylimb.apps.ros1.desk import Arrived
from skylimb.apps.ros1.grounded import GroundedPlant
from skylimb.apps.ros1.live import Kept
from skylimb.apps.ros1.messages import (
    Desire,
    FourAxes,
    Gains,
    Joints,
    MotorInfo,
    PMatrix,
    ServoAngles,
    UavInfo,
)
from skylimb.apps.ros1.outputs import Accelerometer, Names, Outgoing, Rates, seen_by_sensors
from skylimb.apps.ros1.servos import Servos
from skylimb.apps.ros1.spinal import Spinal, attitude_loop
from skylimb.apps.ros1.states import Arming
from skylimb.control.records import Command
from skylimb.control.thrusts import thrust_limits
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
        self._bodies, self._names, self._rates = Bodies(robot, link), Names(robot), Rates(pacer.period)
        self._felt, self._servos = Accelerometer(pacer.period, robot.description.gravity), servos
        self._spinal, self._limits = Spinal(robot.n_rotors), thrust_limits(robot)
        self._bounds = (robot.joint_limits(), robot.vectoring_limits())
        first = takeoff.mission.first
        self._joints, self._gimbals = np.array(first.joint_angles), np.array(first.vectoring_angles)
        self._k = 0
        self.faults: Counter[str] = Counter()
        self.last: Any = None
        self.kept: list[Kept] = []

    @property
    def over(self) -> str:
        """Why it cannot go on; empty while it can."""
        return self.plant.fault() or (
            "the time is over for which noise is laid out" if self.plant.over else ""
        )

    def tick(self, arrived: Iterable[Arrived], stamp: float) -> list[Outgoing]:
        """One tick; `stamp` is the middleware's time, s."""
        now, k = self._pacer.time(), self._k
        landing = self._spinal.force_landing
        out = [answer for one in arrived for answer in self._take(one, now)]
        measured = self.plant.measure()
        for inner in range(self._inner):
            if inner:
                self.plant.measure()
            self._step(now + inner * self._period)
        if self._spinal.force_landing and not landing:
            # A forced landing of its own is told like one that was commanded.
            out.append(Outgoing(topics.ACK, int(Arming.FORCE_LANDING)))
        truth = self.plant.truth()
        seen = measured._replace(angular_velocity=truth.angular_velocity)
        body = self._bodies.of(seen)
        shown = seen_by_sensors(k, stamp, seen, body, self._felt.of(body), self._names, self._rates)
        out += map(self._in_counts, shown)
        if self._rates.due(topics.BATTERY, k):
            out.append(Outgoing(topics.BATTERY, VOLTS * self._cells))
        self._k = k + 1
        return out

    def close(self) -> None:
        """Nothing is kept."""

    def _step(self, now: float) -> None:
        """A tick of the inner loop and of the plant."""
        body = self._bodies.of(self.plant.truth())
        self._spinal, thrusts = attitude_loop(
            self._spinal, body.R_W_link, body.rates_link, now, self._period, self._limits
        )
        self.plant.apply(Command(thrusts, self._joints, self._gimbals))

    def _take(self, one: Arrived, now: float) -> list[Outgoing]:
        """What the flight controller and the servos make of a message."""
        match one.value:
            case FourAxes():
                self._spinal = self._spinal.commanded(one.value, now)
            case Gains():
                self._spinal = self._spinal.gained(one.value)
            case PMatrix():
                self._spinal = self._spinal.with_p_matrix(one.value)
            case UavInfo() | MotorInfo():
                self._spinal = self._spinal.told(one.value)
            case ServoAngles() if self._servos is not None:
                self._bend(self._servos.joints(one.value), one.topic)
            case Desire(roll, pitch, yaw):
                self._spinal = self._spinal.desired(roll, pitch, yaw)
            case Joints():
                self._bend(one.value, one.topic)
            case int():
                self._spinal = self._spinal.configured(one.value)
                if one.value != Arming.ON or self._spinal.armed:
                    return [Outgoing(topics.ACK, one.value)]
                self.faults["armed without motor_info and uav_info: not acknowledged"] += 1
        return []

    def _in_counts(self, one: Outgoing) -> Outgoing:
        """Joint states as the servos tell them, where somebody else makes angles of them."""
        if self._servos is None or one.topic != topics.JOINT_STATES:
            return one
        return Outgoing(topics.SERVO_STATES, self._servos.counts(one.value))

    def _bend(self, value: Joints, topic: str) -> None:
        """Set points of servos, by name, within their limits."""
        known = dict(zip(value.names, value.angles, strict=False))
        if not np.isfinite(list(known.values())).all():
            self.faults[f"{topic}: no number"] += 1
            return
        for names, points, (low, high) in (
            (self._names.joints, self._joints, self._bounds[0]),
            (self._names.gimbals, self._gimbals, self._bounds[1]),
        ):
            wanted = np.array([known.get(name, point) for name, point in zip(names, points, strict=True)])
            points[:] = np.clip(wanted, low, high)
