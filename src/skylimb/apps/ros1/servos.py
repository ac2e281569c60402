"""Between angles of joints and counts of their servos, as the lab's `servo_bridge` has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from skylimb.apps.ros1.messages import Joints, ServoAngles
from skylimb.apps.ros1.outputs import Names
from skylimb.base.errors import ConfigError
from skylimb.robots.model import Robot

MOST = 16383
"""Counts of a target at most, to either side: the lab's."""


class Servo(NamedTuple):
    """One servo.

    Attributes:
        number: on the bus.
        scale: rad a count, its sense of turn included.
        zero: count at 0 rad.
    """

    number: int
    scale: float
    zero: int

    def angle(self, count: int) -> float:
        """Rad."""
        return self.scale * (count - self.zero)

    def count(self, angle: float) -> int:
        """The nearest count that a message can hold."""
        return round(min(max(angle / self.scale + self.zero, -MOST), MOST))


class Servos:
    """The servos of a robot.

    Args:
        robot: whose joints and gimbals they turn.
        servos: by the lab's names of the joints.

    Raises:
        ConfigError: for a joint without servo, a servo without joint, or a number that two have.
    """

    def __init__(self, robot: Robot, servos: Mapping[str, Servo]) -> None:
        names = Names(robot)
        wanted = (*names.joints, *names.gimbals)
        missing = [name for name in wanted if name not in servos]
        odd = [name for name in servos if name not in wanted]
        if missing or odd:
            what = f"no servo for {', '.join(missing)}" if missing else f"a servo for {', '.join(odd)}"
            raise ConfigError(f"servo_controller has {what}; the joints are {', '.join(wanted)}")
        self._servos = {name: servos[name] for name in wanted}
        self._names = {servo.number: name for name, servo in self._servos.items()}
        if len(self._names) != len(wanted):
            raise ConfigError("servo_controller: two servos have the same id")

    def counts(self, joints: Joints) -> ServoAngles:
        """Targets in counts; names that no servo has are left out."""
        known = dict(zip(joints.names, joints.angles, strict=False))
        servos = ((self._servos[name], angle) for name, angle in known.items() if name in self._servos)
        return ServoAngles(joints.stamp, {servo.number: servo.count(angle) for servo, angle in servos})

    def joints(self, angles: ServoAngles) -> Joints:
        """Angles by name, rad; numbers that are no servo of ours are left out."""
        found = {
            self._names[number]: self._servos[self._names[number]].angle(count)
            for number, count in angles.counts.items()
            if number in self._names
        }
        return Joints(angles.stamp, tuple(found), tuple(found.values()))
