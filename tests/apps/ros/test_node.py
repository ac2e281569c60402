"""The loop around a profile: what comes is handed on, Ctrl-C lands first, faults are said once."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skylimb.analysis.exchange.convert import read_log
from skylimb.analysis.exchange.frames import lab_link
from skylimb.analysis.exchange.lab_topics import CLOCK, DIAGNOSTICS, RECORD, ROW, STATE
from skylimb.analysis.exchange.recorder import FlightRecorder
from skylimb.apps.ros.answers import END
from skylimb.apps.ros.both import Both
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.messages import Arrived, Outgoing
from skylimb.apps.ros.node import Node
from skylimb.apps.ros.states import FlightState
from skylimb.base.aside import UNREAD
from skylimb.base.interrupts import ENDS
from skylimb.flight.realtime.pacer import Pacer
from steered import ready


class Carrier:
    """Hands over what is due at a tick, and keeps what is published."""

    def __init__(self, script: dict[int, Any], ends: int) -> None:
        self.script, self.ends, self.k = script, ends, 0
        self.published: list[Outgoing] = []
        self.met: Counter[str] = Counter()

    @property
    def closed(self) -> bool:
        return self.k >= self.ends

    def take(self) -> list[Arrived]:
        self.k += 1
        todo = self.script.get(self.k)
        if callable(todo):
            todo()
            return []
        return [Arrived(topic, None, "/client", time.monotonic()) for topic in todo or ()]

    def carry(self, messages: list[Outgoing]) -> None:
        self.published += messages

    @property
    def faults(self) -> Counter[str]:
        return self.met

    def of(self, topic: Any) -> list[Any]:
        return [value for name, value in self.published if name == topic]


class Clock:
    def __init__(self, busy: Callable[[], float] = lambda: 0.0) -> None:
        self.time, self.busy = 0, busy

    def pacer(self, period: float) -> Pacer:
        return Pacer(period, lambda: self.time, self.sleep, spin=0.0)

    def sleep(self, seconds: float) -> None:
        self.time += round((seconds + self.busy()) * 1e9)


def node(
    carrier: Carrier,
    recorder: FlightRecorder | None = None,
    busy: Callable[[], float] = lambda: 0.0,
    say: Callable[[str], None] | None = None,
) -> tuple[Node, Both, list[str]]:
    takeoff, controller = ready("hybrid")
    pacer, said = Clock(busy).pacer(takeoff.period), list[str]()
    missions = {"paper": takeoff.mission}
    both = Both(takeoff, Flyer(takeoff, controller, missions, lab_link(takeoff.robot), pacer))
    bridge: Any = carrier
    return Node(both, bridge, pacer, say or said.append, recorder=recorder), both, said


def sends(number: signal.Signals) -> Callable[[], None]:
    """What sends this process a signal."""
    return lambda: os.kill(os.getpid(), number)


@pytest.mark.parametrize("end", [*map(sends, ENDS), [END]], ids=[*(one.name for one in ENDS), "life cycle"])
def test_whatever_ends_a_node_has_the_motors_stopped_first(end: Any) -> None:
    carrier = Carrier({2: ["teleop_command/start"], 20: end}, 600)
    flying, both, said = node(carrier)
    flying.spin()
    assert "START -> ARM_ON" in said
    assert said[-1].endswith(" -> ARM_OFF")
    assert carrier.k < 600
    assert both.plant.stands


TAKES_OFF = {2: ["teleop_command/start"], 20: ["teleop_command/takeoff"]}
ENDED = 1300
"""Tick at which its user ends the flight that tests share."""

Landed = tuple[Carrier, Both, list[str], Path]


@pytest.fixture(scope="module")
def landed(tmp_path_factory: pytest.TempPathFactory) -> Landed:
    """A flight to hover that its user ends: of a closed window several signals come."""
    ends = dict.fromkeys((ENDED, ENDED + 1), sends(signal.SIGHUP))
    carrier, folder = Carrier(TAKES_OFF | ends, 6000), tmp_path_factory.mktemp("landed")
    recorder = FlightRecorder(folder)
    flying, both, said = node(carrier, recorder)
    flying.spin()
    recorder.close()
    return carrier, both, said, folder


def test_who_ends_it_lands_it_first(landed: Landed) -> None:
    carrier, both, said, folder = landed
    assert said[:4] == ["ARM_OFF -> START", "START -> ARM_ON", "ARM_ON -> TAKEOFF", "TAKEOFF -> HOVER"]
    assert said[-3:] == ["HOVER -> LAND", "LAND -> STOP", "STOP -> ARM_OFF"]
    assert carrier.k < 6000
    assert both.plant.stands
    assert carrier.of(STATE)[-1] in (0, 4, 6)
    assert len(carrier.of(RECORD)) == 1
    assert len(carrier.of(ROW)) > 500
    assert [kept.name for kept in both.kept] == ["flight"]
    flown, kept = both.kept[0].run().log, read_log(folder / "01-flight.mcap").run.log
    assert flown.sizes["time"] == len(carrier.of(ROW))
    np.testing.assert_array_equal(kept.thrusts_command, flown.thrusts_command)


def test_a_busy_computer_is_slow_and_flies_the_same_flight(landed: Landed) -> None:
    """Two ticks of three begin late, by up to a second: not a bit of the flight is another."""
    rng, flown = np.random.default_rng(3), []
    carrier = Carrier(TAKES_OFF, ENDED - 1)
    flying, both, _ = node(carrier, busy=lambda: float(rng.choice([0.0, 0.02, 1.0], p=[0.3, 0.6, 0.1])))
    flying.spin()
    assert both.pilot.flying.state == FlightState.HOVER
    for one, whose in (landed[:2], (carrier, both)):
        assert not whose.faults
        flown.append([value["data"] for value in one.of(ROW)])
        clock = [value["clock"] for value in one.of(CLOCK)]
        np.testing.assert_allclose(np.diff(clock), 0.005, atol=1e-6)
    assert max(flying.timing.late) > 0.5
    quiet, busy = flown
    np.testing.assert_array_equal(quiet[: len(busy)], busy)


@pytest.mark.parametrize("reads", [False, None])
def test_who_reads_what_is_said_neither_ends_nor_holds_up_a_node(
    reads: bool | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its pipe is closed, or full."""
    reader, writer = os.pipe()
    if reads is None:
        os.close(reader)
    os.set_blocking(writer, False)
    with contextlib.suppress(BlockingIOError, BrokenPipeError):
        while True:
            os.write(writer, b"x" * 4096)
    os.set_blocking(writer, True)
    carrier = Carrier({100: ["skylimb/mission"], 200: ["teleop_command/start"]}, 900)
    flying, both, _ = node(carrier, say=print)
    with os.fdopen(writer, "w", buffering=1) as stream, monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", stream)
        flying.spin()
        if reads is not None:
            os.close(reader)
        assert flying._words is not None
        flying._words._writer.join()
    assert carrier.k == 900
    assert both.pilot.flying.state == FlightState.ARM_ON
    assert flying.faults[UNREAD] > 0


def test_it_ends_when_the_middleware_is_gone_and_says_each_fault_once() -> None:
    carrier = Carrier({300: lambda: carrier.met.update({"master is gone": 1})}, 900)
    flying, _, said = node(carrier)
    flying.spin()
    assert said == ["fault: master is gone", "the middleware's process is gone"]
    assert flying.broken == said[-1]
    shown = carrier.of(DIAGNOSTICS)
    status = [one["status"][0] for one in shown]
    assert [one["level"] for one in status] == [0, 1, 0, 0]
    assert status[1]["message"] == "master is gone (1)"
    assert {"key": "master is gone", "value": "1"} in status[-1]["values"]
    assert len(flying.timing.late) == 900


def test_a_middleware_that_goes_in_flight_leaves_a_robot_that_nobody_commands() -> None:
    flying, both, said = node(Carrier(TAKES_OFF, 300))
    flying.spin()
    assert both.pilot.flying.in_air
    assert not both.plant.stands
    assert said[-1] == "the middleware's process is gone in flight: nobody commands the robot any more"
