"""A simulator in another program, asked over UDP: in step, whatever is lost, and its mistakes are named."""

from __future__ import annotations

import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.errors import ConfigError, SkylimbError
from skylimb.flight.realtime import udp_plant

SIMULATOR = Path(__file__).parents[3] / "examples" / "plants" / "udp_simulator.py"
QUIET = {"stop_at": 1.0, "sensors.latency": 0.0} | {
    f"sensors.{name}_noise": 0.0
    for name in ("position", "velocity", "attitude", "angular_velocity", "joint", "vectoring")
}


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


@pytest.fixture
def simulator() -> Iterator[str]:
    port = free_port()
    process = subprocess.Popen([sys.executable, str(SIMULATOR), str(port)])
    yield f"127.0.0.1:{port}"
    process.kill()
    process.wait(10)


def test_another_program_flies_what_the_engine_flies(simulator: str) -> None:
    """Free flight twice, as a program that runs on is begun anew by every flight."""
    engine = skylimb.run("free_flight", "pid", set=QUIET)
    for _ in range(2):
        run = skylimb.run("free_flight", "pid", set=QUIET, plant=skylimb.UdpPlant(simulator))
        assert run.status == engine.status, run.cause
        away = run.log.cog_position.values - engine.log.cog_position.values
        assert np.abs(away).max() < 1e-5


def test_another_program_touches_the_board(simulator: str) -> None:
    given = {**HOLD, "stop_at": 2.5}
    run = skylimb.run("paper", "hybrid", set=given, plant=skylimb.UdpPlant(simulator))
    assert run.status == "STOPPED", run.cause
    assert run.log.contact_force_normal.values.max() > 0.3


class Strewn:
    """A socket on a bad way: each datagram comes twice, and the one before it once more, behind it."""

    def __init__(self, real: socket.socket) -> None:
        self._real, self._before = real, b""

    def sendto(self, data: bytes, peer: Any) -> None:
        for one in (data, data, self._before or data):
            self._real.sendto(one, peer)
        self._before = data

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)


def test_a_request_that_comes_late_or_twice_is_no_step(simulator: str) -> None:
    """A late one was stepped, and the next answer that was asked again, too."""
    given = {**QUIET, "stop_at": 0.1}
    straight = skylimb.run("free_flight", "pid", set=given, plant=skylimb.UdpPlant(simulator))
    plant = skylimb.UdpPlant(simulator)
    plant._socket = Strewn(plant._socket)  # type: ignore[assignment]
    strewn = skylimb.run("free_flight", "pid", set=given, plant=plant)
    assert (straight.status, strewn.status) == ("STOPPED", "STOPPED")
    np.testing.assert_array_equal(strewn.log.thrusts.values, straight.log.thrusts.values)
    np.testing.assert_array_equal(strewn.log.root_position.values, straight.log.root_position.values)


class Still:
    """A robot that does not move, in a thread: what it was asked, and what it answers."""

    def __init__(self, answers: Callable[[dict[str, Any], int], Any]) -> None:
        self.asked, self.steps, self._answers = 0, 0, answers
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._socket.getsockname()[1]}"
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        seen, truth = -1, {}
        while True:
            data, peer = self._socket.recvfrom(65535)
            told = msgspec.msgpack.decode(data)
            self.asked += 1
            truth = told["start"]["truth"] if "start" in told else truth
            self.steps += "drive" in told and told["seq"] != seen
            seen = told["seq"]
            answer = self._answers({"seq": seen, "truth": truth}, self.asked)
            for one in answer if isinstance(answer, list) else [answer]:
                self._socket.sendto(msgspec.msgpack.encode(one), peer)


def test_lost_and_doubled_answers_step_nobody_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(udp_plant, "_AGAIN", 0.02)

    def answers(fine: dict[str, Any], count: int) -> Any:
        return {0: [], 1: [fine, fine]}.get(count % 5, [fine])

    still = Still(answers)
    flight = skylimb.begin("free_flight", controller="pid", plant=skylimb.UdpPlant(still.address))
    for _ in range(4):
        flight.tick()
    assert still.steps == 20
    assert still.asked > 24


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        (lambda fine, count: 7, "an answer is no msgpack map"),
        (lambda fine, count: {"seq": fine["seq"]}, "an answer has no map 'truth'"),
        (lambda fine, count: {**fine, "error": "the gazebo leaks"}, "plant 'udp' says: the gazebo leaks"),
        (lambda fine, count: {**fine, "truth": {**fine["truth"], "joint_angles": [0.0]}}, "joint_angles"),
        (lambda fine, count: {**fine, "seq": 1}, r"no answer with seq \d+ from .*; the last one has seq 1$"),
        (lambda fine, count: {"truth": fine["truth"]}, "; the last one has seq None$"),
    ],
)
def test_a_wrong_answer_is_named(answers: Any, words: str) -> None:
    plant = skylimb.UdpPlant(Still(answers).address, patience=0.5)
    with pytest.raises(SkylimbError, match=words):
        skylimb.begin("free_flight", controller="pid", plant=plant)


def test_a_simulator_that_dies_ends_the_flight_and_its_log_is_kept() -> None:
    still = Still(lambda fine, count: fine if count < 100 else [])
    given = {"stop_at": 1.0}
    run = skylimb.run("free_flight", "pid", set=given, plant=skylimb.UdpPlant(still.address, patience=0.3))
    assert run.status == "FAILED"
    assert "no answer from" in run.cause
    assert run.log.sizes["time"] > 10


def test_nobody_there_is_named_and_no_other_machine_is_asked_by_mistake() -> None:
    plant = skylimb.UdpPlant(f"127.0.0.1:{free_port()}", patience=0.3)
    with pytest.raises(SkylimbError, match=r"plant 'udp': no answer from 127\.0\.0\.1:\d+ within 0\.3 s"):
        skylimb.begin("free_flight", controller="pid", plant=plant)
    with pytest.raises(ConfigError, match=r"is not this machine, .*in Python anywhere=True"):
        skylimb.UdpPlant("192.0.2.1:9871")
    with pytest.raises(ConfigError, match=r"port 0 of '127\.0\.0\.1:0' is outside of 1 \.\. 65535"):
        skylimb.UdpPlant("127.0.0.1:0")


@pytest.mark.parametrize("patience", [0.0, -1.0, float("nan"), "10"])
def test_a_patience_that_is_no_time_is_refused(patience: Any) -> None:
    with pytest.raises(ConfigError, match=r"patience = .* is no number of seconds above 0"):
        skylimb.UdpPlant("127.0.0.1:9871", patience=patience)


def test_a_stream_of_other_answers_does_not_hold_it_for_ever() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        plant = skylimb.UdpPlant(f"127.0.0.1:{other.getsockname()[1]}", patience=0.5)
        over = threading.Event()

        def flood() -> None:
            _, asked = other.recvfrom(65535)
            while not over.wait(0.01):
                other.sendto(msgspec.msgpack.encode({"seq": 1, "truth": {}}), asked)

        threading.Thread(target=flood, daemon=True).start()
        begun = time.monotonic()
        with pytest.raises(SkylimbError, match="the last one has seq 1"):
            skylimb.begin("free_flight", controller="pid", plant=plant)
        over.set()
        assert time.monotonic() - begun < 30.0


def test_its_socket_closes_when_nobody_holds_it() -> None:
    plant = skylimb.UdpPlant(f"127.0.0.1:{free_port()}")
    held = plant._socket
    assert held.fileno() >= 0
    del plant
    assert held.fileno() == -1
