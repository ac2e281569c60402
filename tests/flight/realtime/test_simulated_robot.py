"""The served plant does as a robot's program has to: one sender, numbers that rise, finite commands."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from short_flights import HOLD
from skylimb.control.records import Command
from skylimb.flight.realtime.link import Datagram
from skylimb.flight.realtime.messages import GREETING, Names, StateMessage, decode, encode
from skylimb.flight.realtime.simulated_robot import SimulatedRobot
from skylimb.flight.takeoff import take_off


class Wire:
    """A link whose other end is in the test's hands."""

    def __init__(self) -> None:
        self.coming, self.answered = list[Datagram](), list[Any]()

    def receive(self, most: int) -> tuple[list[Datagram], int]:
        found, self.coming = self.coming, []
        return found, 0

    def send(self, data: bytes) -> None:
        """Nobody listens."""

    def answer(self, sender: Any) -> None:
        self.answered.append(sender)


class Served:
    """A robot, and who commands it."""

    def __init__(self) -> None:
        (takeoff,) = take_off("paper", (None,), set=HOLD)
        self.wire, self.names, self.model = Wire(), Names(takeoff.robot), takeoff.robot
        self.robot = SimulatedRobot(takeoff, self.wire)

    def told(self, seq: int, thrust: float, sender: str = "a", **changes: Any) -> None:
        command = Command(
            np.full(self.model.n_rotors, thrust),
            np.zeros(self.model.n_joints),
            np.zeros(self.model.n_vectoring),
        )
        message = self.names.command_message(seq, 0.0, command)
        message = replace(message, **changes)
        self.wire.coming.append(Datagram(encode(message), sender))

    def tick(self, count: int = 1) -> float | None:
        """The first thrust that is flown then."""
        for _ in range(count):
            self.robot.sense()
            self.robot.act()
        return None if self.robot._command is None else float(self.robot._command.thrusts[0])


@pytest.fixture
def served() -> Served:
    return Served()


def test_commands_of_one_sender_are_obeyed_and_none_that_was_overtaken(served: Served) -> None:
    served.told(10, 11.0)
    assert served.tick() == 11.0
    served.told(0, 30.0, "b")
    served.told(12, 12.0)
    served.told(11, 5.0)
    served.told(12, 6.0)
    assert served.tick() == 12.0
    assert served.robot.counts == {"second sender": 1, "command overtaken or said twice": 2}
    assert served.wire.answered == ["a"]


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"thrusts": (float("nan"),) * 4}, "command is no number"),
        ({"angles": (float("inf"),) * 7}, "command is no number"),
        ({"thrusts": (1.0,) * 3}, "wrong size"),
    ],
)
def test_what_is_no_command_changes_nothing(served: Served, changes: dict[str, Any], fault: str) -> None:
    served.told(0, 11.0)
    served.tick()
    served.told(1, 12.0, **changes)
    assert served.tick() == 11.0
    assert served.robot.counts == {fault: 1}


def test_it_says_how_old_the_measurement_was_that_its_command_answers(served: Served) -> None:
    sent = list[bytes]()
    served.wire.send = sent.append  # type: ignore[method-assign]

    def said() -> float | None:
        return decode(sent[-1], StateMessage).loop_delay

    served.tick()
    assert said() is None
    served.told(0, 11.0, stamp=0.0)
    served.tick(2)
    assert said() == pytest.approx(0.005)  # the state of tick 0, in that of tick 1
    served.told(1, 11.0, stamp=0.005)
    served.tick(4)
    assert said() == pytest.approx(0.01)
    served.told(2, 11.0, stamp=0.005)
    served.tick(2)
    assert said() == pytest.approx(0.03)


def test_whoever_comes_after_a_silence_is_answered_and_counts_anew(served: Served) -> None:
    """A check, a second one, then a flight, each from its own port; and a controller started again."""
    for sender in ("check", "check again"):
        served.wire.coming.append(Datagram(GREETING, sender))
        assert served.tick(50) is None
    assert served.robot.flown == 0
    for k in range(5):
        served.told(k, 11.0, "flight")
        served.tick()
    served.wire.coming.append(Datagram(GREETING, "late"))
    served.tick()
    assert served.wire.answered == ["check", "check again", "flight"]
    served.tick(50)
    served.told(0, 13.0, "flight")
    assert served.tick() == 13.0


def test_who_only_looks_takes_no_robot_from_who_flies_it_and_stands_still_for_a_moment(
    served: Served,
) -> None:
    """A `--check`, or a second `fly` that looks first: the robot was told nothing until it had gone."""
    served.told(0, 11.0, "flight")
    served.tick(60)
    for k in range(1, 40):
        served.wire.coming.append(Datagram(GREETING, "check"))
        served.told(k, 12.0 + k, "flight")
        assert served.tick() == 12.0 + k
    assert served.wire.answered == ["flight", "flight"]
    served.tick(210)  # the flight has been killed
    served.wire.coming.append(Datagram(GREETING, "check"))
    served.tick()
    assert served.wire.answered[-1] == "check"
