"""Between angles of joints and counts of their servos, as the lab's `servo_bridge` has it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from skylimb.analysis.exchange.lab_ticks import Names
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

    def counts(self, angles: Mapping[str, float]) -> dict[int, int]:
        """Counts by number of angles by name, rad; names that no servo has are left out."""
        servos = ((self._servos[name], angle) for name, angle in angles.items() if name in self._servos)
        return {servo.number: servo.count(angle) for servo, angle in servos}

    def angles(self, counts: Iterable[tuple[int, int]]) -> dict[str, float]:
        """Angles by name, rad, of numbers and counts; numbers that are no servo of ours are left out."""
        return {name: self._servos[name].angle(count) for name, count in self.named(counts)}

    def named(self, values: Iterable[tuple[int, int]]) -> Iterator[tuple[str, int]]:
        """Names and values of numbers and values; numbers that are no servo of ours are left out."""
        return ((self._names[number], value) for number, value in values if number in self._names)
