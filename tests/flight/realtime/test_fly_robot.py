"""A robot behind a link: the plant's flight is that of `skylimb.run`, and it lands however it ends."""

from __future__ import annotations

import itertools
import json
import math
import os
import shutil
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.analysis.exchange.recorder import FULL, LEAST, FlightRecorder
from skylimb.analysis.report.controller_replay import differences
from skylimb.apps.cli.main import main
from skylimb.base.aside import UNREAD
from skylimb.base.errors import ConfigError, OutputError
from skylimb.base.interrupts import answering
from skylimb.control.supervisor.table import TABLE
from skylimb.flight.realtime.fly_on_clock import ClockedFlight
from skylimb.flight.realtime.fly_robot import ENDED, fly_robot
from skylimb.flight.realtime.link import Datagram, RemoteVehicle
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.preflight import StartLimits
from skylimb.flight.realtime.simulated_robot import SimulatedRobot, serve_plant
from skylimb.flight.realtime.udp import UdpLink, address_of
from skylimb.flight.takeoff import take_off


class End:
    """One end of a wire; what is sent at one end comes at the other."""

    def __init__(self, coming: deque[bytes], leaving: deque[bytes], name: str) -> None:
        self.coming, self.leaving, self.name = coming, leaving, name
        self.cut, self.ahead = False, 0.0
        self.late, self.sent = 0, deque[tuple[int, bytes]]()
        self.spoil: Callable[[dict[str, Any]], None] = lambda fields: None

    def receive(self, most: int) -> tuple[Iterable[Datagram], int]:
        found = [Datagram(self.coming.popleft(), self.name) for _ in range(min(most, len(self.coming)))]
        return found, 0

    def answer(self, sender: Any) -> None:
        """The wire has one other end."""

    def send(self, data: bytes) -> None:
        if not self.cut:
            fields = msgspec.msgpack.decode(data)
            if fields:
                fields["stamp"] += self.ahead
                self.spoil(fields)
            self.sent.append((self.late, msgspec.msgpack.encode(fields)))
            self.deliver(0)

    def deliver(self, ticks: int) -> None:
        """So many ticks have passed: what has been on its way for `late` of them comes at the other end."""
        self.sent = deque((left - ticks, data) for left, data in self.sent)
        while self.sent and self.sent[0][0] <= 0:
            self.leaving.append(self.sent.popleft()[1])


class InStep(Pacer):
    """A clock of which a tick passes when the robot's has: both ends go in step."""

    def __init__(
        self,
        robot: SimulatedRobot,
        period: float,
        before: Callable[[int], None],
        passed: Callable[[], None] = lambda: None,
    ) -> None:
        self.moment = 0
        super().__init__(period, lambda: self.moment, lambda seconds: None)
        self.robot, self.before, self.passed = robot, before, passed

    def wait(self, k: int) -> float:
        self.moment = self._start + round(k * self.period * 1e9)
        if k:
            self.robot.act()
            self.passed()
            self.robot.sense()
        self.before(k)
        return super().wait(k)


def flown(
    controller: str = "hybrid",
    before: Callable[[int, SimulatedRobot, End], None] = lambda k, robot, end: None,
    changes: Mapping[str, Any] = MappingProxyType({}),
    spoil: Callable[[dict[str, Any]], None] = lambda fields: None,
    start: StartLimits | None = None,
    recorder: FlightRecorder | None = None,
    late: int = 0,
) -> tuple[ClockedFlight, SimulatedRobot]:
    """What became of a flight over a wire whose messages are `late` ticks on their way, each way."""
    there, back = deque[bytes](), deque[bytes]()
    near, far = End(there, back, "robot"), End(back, there, "us")
    far.spoil = spoil
    (takeoff,) = take_off("paper", (controller,), set={**HOLD, **changes})
    robot = SimulatedRobot(takeoff, far)

    def passed() -> None:
        far.deliver(1)
        link.deliver(1)

    clock = InStep(robot, takeoff.period, lambda k: before(k, robot, far), passed)

    class Greeting(End):
        """The first state comes when somebody listens, as from a robot that waits."""

        def receive(self, most: int) -> tuple[Iterable[Datagram], int]:
            if not robot.flown and not self.coming and self.leaving is back:
                robot.sense()
                far.deliver(late)
            return super().receive(most)

    link = Greeting(near.coming, near.leaving, "robot")
    link.late = far.late = late
    keys, made = {**HOLD, **changes}, recorder
    return fly_robot(
        link, "paper", controller, keys, pacer=clock, listen=0.0, start=start, recorder=made
    ), robot


@pytest.mark.parametrize("controller", ["hybrid", "following"])
def test_over_a_link_it_is_the_flight_of_run(controller: str) -> None:
    over, robot = flown(controller)
    run = skylimb.run("paper", controller, set=HOLD)
    log, was = over.run.log, run.log
    assert over.run.status == "OK", over.run.cause
    assert over.faults == {}
    count = was.sizes["time"]
    for name in ("root_position_measured", "thrusts_command", "external_force_estimate", "phase"):
        np.testing.assert_allclose(log[name][:count], was[name], atol=1e-9, err_msg=name)
    np.testing.assert_array_equal(log.retreating[:count], 0.0)
    # Then it lands.
    assert log.retreating.values[-1] == 1.0
    assert robot.position()[2] < 0.3
    assert np.isfinite(log.thrusts_command).all()
    replayed = skylimb.replay(over.run)
    found = {one.signal: one for one in differences(over.run, replayed)}
    np.testing.assert_allclose(
        replayed.log.external_force_estimate[:count], log.external_force_estimate[:count], atol=1e-9
    )
    assert len(found) > 10


def swing(over: ClockedFlight) -> float:
    """The greatest measured tilt, rad."""
    x, y = over.run.log.root_quaternion_measured.values[:, 1:3].T
    return float(np.arccos(1.0 - 2.0 * (x**2 + y**2)).max())


@pytest.mark.parametrize("controller", ["hybrid", "following"])
def test_a_loop_that_is_slow_is_flown_with_gains_that_suit_it(controller: str) -> None:
    over, _ = flown(controller, late=5)  # 25 ms each way
    assert over.run.status == "OK", over.run.cause
    assert over.run.log.loop_delay.values[200:-50] == pytest.approx(0.05)
    assert swing(over) < 0.2
    # A replay flies with the gains of each tick too.
    mission = over.run.log.retreating.values == 0.0
    commands = [run.log.thrusts_command.values[mission] for run in (over.run, skylimb.replay(over.run))]
    np.testing.assert_allclose(*commands, atol=1e-9)
    # Nothing else tells it: commands that are as late and of which nobody says so lose the robot's balance.
    unsaid, _ = flown(controller, late=5, spoil=lambda fields: fields.pop("loop_delay"))
    assert swing(unsaid) > 0.3


def test_a_loop_that_is_too_slow_is_led_back_and_down() -> None:
    over, robot = flown("following", late=8)
    assert over.run.status == "FAILED"
    assert over.run.cause == "broken off by the guard (commands take too long)"
    assert over.faults["commands take too long"] == 1
    assert swing(over) < 0.2
    assert robot.position()[2] < 0.3


@pytest.mark.parametrize("stood", [0.6, 3.0])
def test_a_computer_that_stood_still_leads_the_robot_back_and_catches_up_no_tick(
    stood: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Stopped(InStep):
        """At tick 200 time goes on by itself; the robot holds itself meanwhile, and says so."""

        def wait(self, k: int) -> float:
            late = super().wait(k)
            if k != 200:
                return late
            for _ in range(round(stood / self.period)):
                self.moment += round(1e9 * self.period)
                self.robot.sense()
                self.passed()
            return Pacer.wait(self, k)

    monkeypatch.setattr(sys.modules[__name__], "InStep", Stopped)
    over, robot = flown()
    assert over.run.cause == "broken off by the guard (this computer stood still)"
    assert over.faults["missed tick"] == 1
    assert over.run.log.tick_late.values[200] == pytest.approx(stood, abs=0.01)
    assert over.run.log.tick_late.values[201:].max() == 0.0
    assert "CUT" not in {list(TABLE.modes)[int(mode)] for mode in over.run.log.supervisor_mode.values}
    assert swing(over) < 0.1
    assert robot.position()[2] < 0.3


def test_a_link_that_is_cut_coasts_then_breaks_off() -> None:
    def cut(k: int, robot: SimulatedRobot, far: End) -> None:
        far.cut = 80 <= k < 210

    over, _ = flown(before=cut)
    log = over.run.log
    held, broken = log.tick_held.values > 0.0, log.retreating.values > 0.0
    # It goes on where the model has it, and nearly as if it were seen.
    assert not held[:200].any()
    run = skylimb.run("paper", "hybrid", set=HOLD)
    away = log.root_position_measured.values[200] - run.log.root_position_measured.values[200]
    assert float(np.abs(away).max()) < 0.03
    assert 200 < np.argmax(broken) < 210
    assert over.run.cause == (
        "broken off by the guard (no pose for long, pose too old, no joint angles for long)"
    )
    assert over.faults["pose too old"] > 50
    # What is on the disk while it flies says why it landed, also where nobody lives to tell.
    modes = list(TABLE.modes)
    assert [modes[int(log.supervisor_mode[k])] for k in (79, 150, 205)] == ["NORMAL", "COAST", "DESCEND"]
    assert int(log.supervisor_bits[205]) >> list(TABLE.bits).index("blind") & 1


@pytest.mark.parametrize("step", [-2.0, -0.3, 0.3])
def test_a_robot_whose_clock_is_set_flies_on(step: float) -> None:
    def set_clock(k: int, robot: SimulatedRobot, far: End) -> None:
        far.ahead = step * (k >= 80)

    over, _ = flown(before=set_clock)
    run, count = skylimb.run("paper", "hybrid", set=HOLD), 160
    assert over.faults["clock of the stamps was set"] == 1
    assert over.faults.get("pose too old", 0) <= 3  # of seven messages that are refused four are waited for
    assert not over.run.log.retreating.values[:count].any()
    away = over.run.log.root_position_measured - run.log.root_position_measured
    assert float(np.abs(away[:count]).max()) < 0.005


@pytest.mark.parametrize(
    ("field", "stuck"),
    [("angular_velocity", None), ("angular_velocity", (0.5, 0.0, 0.0)), ("velocity", (0.3, 0.0, 0.0))],
)
def test_a_twist_that_sticks_leads_back_and_down(field: str, stuck: tuple[float, ...] | None) -> None:
    """Poses are perfect; the last rates for ever tipped it over within 3 s."""
    states, kept = itertools.count(), dict[str, Any]()

    def spoil(fields: dict[str, Any]) -> None:
        if next(states) > 200:
            fields[field] = kept.setdefault(field, list(stuck) if stuck else fields[field])

    over, robot = flown(spoil=spoil)
    log = over.run.log
    lean = np.linalg.norm(log.root_quaternion_measured.values[:, 1:3], axis=1)
    assert over.run.cause.startswith("broken off by the guard (")
    assert 200 < np.argmax(log.retreating.values > 0.0) < 225
    assert 2.0 * float(np.arcsin(lean.max())) < 0.2
    assert -0.1 < robot.position()[2] < 0.1


@pytest.mark.parametrize("ticks", [20, 600])
def test_an_encoder_that_lies_is_not_believed(ticks: int) -> None:
    """A tenth of a second of joint 1 at -1 rad in place of 1.05 had the true poses refused."""
    states = itertools.count()

    def spoil(fields: dict[str, Any]) -> None:
        if 200 < next(states) <= 200 + ticks:
            fields["angles"] = [-1.0, *fields["angles"][1:]]

    over, robot = flown(spoil=spoil)
    lean = np.linalg.norm(over.run.log.root_quaternion_measured.values[:, 1:3], axis=1)
    assert over.faults["angle out of range"] == ticks
    assert over.run.cause == ("" if ticks == 20 else "broken off by the guard (no joint angles for long)")
    assert 2.0 * float(np.arcsin(lean.max())) < 0.2
    assert -0.1 < robot.position()[2] < 0.1


def test_a_state_that_says_that_it_is_old_is_not_flown_by() -> None:
    with pytest.raises(ConfigError, match="age of state"):
        flown(spoil=lambda fields: fields.update(capture_age=5.0))


def test_a_robot_that_tilts_too_far_is_broken_off() -> None:
    over, _ = flown(changes={"terminations.distance": 0.012})
    assert "lost position: more than 0.012 m from the reference" in over.run.cause
    assert over.run.failed
    assert over.run.log.retreating.values[-1] == 1.0


@pytest.mark.parametrize("changes", [{"plant.thrust_scale": 1.1}, {"plant.mass_scale": 0.9}])
def test_commands_go_on_until_a_robot_that_sinks_late_is_down(changes: dict[str, float]) -> None:
    over, robot = flown(changes=changes)
    assert over.run.status == "OK"
    assert robot.position()[2] < 0.0


def test_a_robot_that_is_broken_off_high_up_is_led_all_the_way_down() -> None:
    """Its mission ends 0.6 m below the place where it is broken off."""
    circle = {"trajectory.shape": "circle", "trajectory.radius": 0.3, "trajectory.period": 6.0}

    def gone(k: int, robot: SimulatedRobot, far: End) -> None:
        far.cut = 1013 <= k < 1143

    over, robot = flown(before=gone, changes=circle)
    assert over.run.cause.startswith("broken off by the guard (")
    heights = over.run.log.root_position_measured.values[:, 2]
    assert heights[np.argmax(over.run.log.retreating.values > 0.0)] > 1.3
    assert robot.position()[2] < 0.0


@pytest.mark.parametrize("scale", [0.92, 1.1])
def test_on_the_ground_the_commands_stop_once_the_thrusts_are_low(scale: float) -> None:
    stood: list[np.ndarray] = []

    def ground(k: int, robot: SimulatedRobot, far: End) -> None:
        data = robot._data
        if stood or data.qpos[2] < 0.15:
            stood.append(data.qpos[0:7].copy())
            data.qpos[0:7], data.qvel[0:6] = stood[0], 0.0

    over, _ = flown(before=ground, changes={"plant.thrust_scale": scale})
    thrusts = over.run.log.thrusts_command.values.sum(axis=1)
    assert over.run.status == "OK"
    assert 100 < len(stood) < 2000
    assert 0.5 * thrusts[100] < thrusts[-1] < 0.8 * thrusts[100]


def test_a_terminal_that_goes_away_lands_the_robot_and_ctrl_z_stops_no_flight() -> None:
    frozen: list[Any] = []

    def gone(k: int, robot: SimulatedRobot, far: End) -> None:
        if k in (100, 101, 120):  # a shell says it again
            signal.raise_signal(signal.SIGHUP)
        frozen.append(signal.getsignal(signal.SIGTSTP))

    with pytest.warns(UserWarning, match="the robot is led back and down"):
        over, robot = flown(before=gone)
    assert over.run.cause == ENDED
    assert robot.position()[2] < 0.05
    assert set(frozen) == {signal.SIG_IGN}


def test_a_reader_who_is_gone_ends_no_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    reader, writer = os.pipe()
    os.close(reader)

    def says(k: int, robot: SimulatedRobot, far: End) -> None:
        if k == 100:
            print("a word", flush=True)

    with os.fdopen(writer, "w", buffering=1) as stream, monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", stream)
        over, _ = flown(before=says)
    assert over.run.status == "OK"
    assert over.faults == {UNREAD: 1}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_who_ends_it_lands_the_robot_and_a_second_time_stops_the_commands(number: signal.Signals) -> None:
    def once(k: int, robot: SimulatedRobot, far: End) -> None:
        if k == 100:
            signal.raise_signal(number)

    def twice(k: int, robot: SimulatedRobot, far: End) -> None:
        if k in (100, 120):
            signal.raise_signal(number)

    before = signal.getsignal(number)
    with pytest.warns(UserWarning, match="the robot is led back and down"):
        over, robot = flown(before=once)
    assert over.run.cause == ENDED
    assert over.run.failed
    assert robot.position()[2] < 0.05
    assert signal.getsignal(number) == before
    if number == signal.SIGINT:
        # As Python answers it at first, whoever ran these tests may have it ignored.
        with (
            answering([number], signal.default_int_handler),
            pytest.warns(UserWarning, match=ENDED),
            pytest.raises(KeyboardInterrupt),
        ):
            flown(before=twice)


def test_over_udp_on_the_wall_clock(tmp_path: Path) -> None:
    robot = UdpLink(("127.0.0.1", 0))
    near = UdpLink(("127.0.0.1", 0), robot.address)
    short = {**HOLD, "approach.contact": False, "approach.depth": 0.05}
    ticks: list[int] = []
    served = threading.Thread(target=lambda: ticks.append(serve_plant(robot, "paper", short)))
    served.start()
    try:
        over = fly_robot(near, "paper", "hybrid", short, patience=30.0, recorder=FlightRecorder(tmp_path))
    finally:
        served.join(timeout=60.0)
        near.close()
        robot.close()
    assert not served.is_alive()
    assert ticks[0] > 100
    assert over.run.log.sizes["time"] > 100
    assert np.isfinite(over.run.log.thrusts_command).all()
    # Between the look and the first command the record was made, for a second: 130 states were lost.
    assert over.faults.get("flood", 0) < 40
    assert next(tmp_path.glob("*.mcap")).stat().st_size > 10_000


def test_a_disk_that_fills_in_flight_is_said_at_once_and_lands_nobody(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    recorder, told = FlightRecorder(tmp_path), dict[int, str]()

    def fill(k: int, robot: SimulatedRobot, far: End) -> None:
        told[k] = caplog.text
        if k == 100:
            monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=LEAST - 1))

    over, _ = flown(before=fill, recorder=recorder)
    assert FULL not in told[100]
    assert f"recorder: {FULL}" in told[410]
    assert over.faults[FULL] == 1
    assert over.run.cause == ""


def test_where_nobody_answers_nothing_flies() -> None:
    link = UdpLink(("127.0.0.1", 0), ("127.0.0.1", 9))
    with pytest.raises(
        OutputError,
        match=r"no measurement came within 0.05 s \(nothing was heard: it is not there, or .* flies it\)",
    ):
        fly_robot(link, "paper", "hybrid", patience=0.05)
    link.close()


def test_only_this_machine_commands_by_default(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert address_of("127.0.0.1:9870") == ("127.0.0.1", 9870)
    assert address_of("localhost:1") == ("127.0.0.1", 1)
    assert address_of("192.168.1.2:80", anywhere=True) == ("192.168.1.2", 80)
    for text in ("192.168.1.2:80", "0.0.0.0:80", "robot", "127.0.0.1:x", "127.0.0.1:70000"):
        with pytest.raises(ConfigError, match=text.split(":")[0]):
            address_of(text)
    assert main(["fly", "paper", "--udp", "10.0.0.1:1", "--out", str(tmp_path / "out")]) == 2
    assert (
        "10.0.0.1 is not this machine, and whoever reaches the port commands the robot; --anywhere"
        in capsys.readouterr().err
    )


def test_a_robot_that_is_not_ready_is_not_flown_and_says_why() -> None:
    def rolled(fields: dict[str, Any]) -> None:
        fields |= {"quaternion": (0.6, 0.8, 0.0, 0.0), "battery": 5.0, "mass": 5.0}

    with pytest.raises(ConfigError, match=r"nothing is flown: attitude: 1.* rad of tilt") as refused:
        flown(spoil=rolled)
    for words in ("battery: 5 % (at least 10 %)", "robot: 5.000 kg as described, 4.1"):
        assert words in str(refused.value)


def turned_by(angle: float) -> Callable[[dict[str, Any]], None]:
    """The same world, seen by a capture that is turned about W's z."""
    c, s = math.cos(angle), math.sin(angle)
    half, up = math.cos(0.5 * angle), math.sin(0.5 * angle)

    def spoil(fields: dict[str, Any]) -> None:
        for name in ("position", "velocity"):
            x, y, z = fields[name]
            fields[name] = (c * x - s * y, s * x + c * y, z)
        w, x, y, z = fields["quaternion"]
        fields["quaternion"] = (half * w - up * z, half * x - up * y, half * y + up * x, half * z + up * w)

    return spoil


def moved(fields: dict[str, Any]) -> None:
    x, y, z = fields["position"]
    fields["position"] = (x + 1.5, y, z)


def bent(fields: dict[str, Any]) -> None:
    fields["angles"] = [fields["angles"][0] + 0.2, *fields["angles"][1:]]


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (
            moved,
            r"place: 1\.5\d? m from the mission's beginning \(at most 0\.1; lead it to \(0\.39, ",
        ),
        (
            turned_by(3.0),
            r"heading: 3 rad from the mission's beginning \(at most 0\.3; lead it to yaw ",
        ),
        (turned_by(-0.35), r"heading: 0.35\d* rad"),
        (bent, r"joints: 0\.2\d* rad from the mission's beginning \(at most 0\.1; lead it to \(1\.\d\d, "),
    ],
)
def test_a_robot_that_is_not_where_its_mission_begins_is_not_flown(
    spoil: Callable[[dict[str, Any]], None], words: str
) -> None:
    with pytest.raises(ConfigError, match=words):
        flown(spoil=spoil)


def test_a_battery_that_stays_low_in_flight_lands_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skylimb.flight.realtime.charge.LASTS", 0.2)
    states: list[int] = []

    def drained(fields: dict[str, Any]) -> None:
        states.append(0)
        fields["battery"] = 90.0 if len(states) < 80 else 1.0

    over, robot = flown(spoil=drained)
    assert over.run.cause == "low battery: 1 per cent"
    assert np.argmax(over.run.log.retreating.values > 0.0) == pytest.approx(80 + 40, abs=4)
    assert robot.position()[2] < 0.05


def test_a_robot_whose_imu_is_wrong_is_not_flown() -> None:
    def upside_down(fields: dict[str, Any]) -> None:
        fields |= {"imu_angular_velocity": (0.0, 0.0, 0.0), "imu_specific_force": (0.0, 0.0, -9.81)}

    with pytest.raises(ConfigError, match=r"nothing is flown: IMU's force: 19\.\d m/s\^2 beside gravity"):
        flown(spoil=upside_down)


def test_a_check_commands_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    robot = UdpLink(("127.0.0.1", 0))
    host, port = robot.address
    (takeoff,) = take_off("paper", (None,), set=HOLD)
    simulated = SimulatedRobot(takeoff, robot)
    over = threading.Event()

    def stand() -> None:
        while not over.wait(takeoff.period):
            simulated.act()
            simulated.sense()

    asked = ["--set", *(f"{key}={json.dumps(value)}" for key, value in HOLD.items())]
    standing = threading.Thread(target=stand)
    standing.start()
    try:
        assert main(["fly", "paper", "--udp", f"{host}:{port}", "--check", *asked]) == 0
    finally:
        over.set()
        standing.join()
        robot.close()
    said = capsys.readouterr().out
    assert simulated.flown == 0
    for name in (
        "attitude",
        "motion",
        "fence",
        "place",
        "heading",
        "joints",
        "age of state",
        "clock of state",
        "disk",
    ):
        assert f"ok  {name}: " in said
    assert main(["fly", "paper", "--realtime", "--check"]) == 2


def test_what_would_end_the_loop_lands_the_robot_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """The log fails, as one of a user's own vehicle may."""
    there, robots = list[float](), list[SimulatedRobot]()
    record = RemoteVehicle.record

    def fails(vehicle: RemoteVehicle, *given: Any) -> Any:
        if len(there) > 100:
            raise ZeroDivisionError("no log")
        return record(vehicle, *given)

    def follow(k: int, robot: SimulatedRobot, far: End) -> None:
        there.append(float(robot.position()[2]))
        robots[:] = [robot]

    monkeypatch.setattr(RemoteVehicle, "record", fails)
    with pytest.raises(ZeroDivisionError, match="no log") as raised:
        flown(before=follow)
    assert raised.value.__notes__ == ["the robot was led back and down before this was raised"]
    assert there[100] > 0.9
    assert robots[0].position()[2] < 0.05
    assert np.diff(there).min() > -0.6 * robots[0]._period  # it did not fall


def test_a_robot_that_leaves_its_fence_is_led_back_and_down() -> None:
    """Its centre of gravity is at x = 0.385 m, and touches at 0.42 m."""
    fence = ((-1.0, 0.4), (-1.0, 1.0), (-1.0, 2.0))
    over, _ = flown(start=StartLimits(fence=fence))
    assert over.run.cause == "beyond the fence: x = 0.40 m is outside of -1 .. 0.4 m"
    log = over.run.log
    assert log.retreating.values[-1] == 1.0
    assert log.cog_position_estimate.values[-1, 0] < 0.25
    with pytest.raises(ConfigError, match=r"nothing is flown: fence: x = 0\.39 m is outside"):
        flown(start=StartLimits(fence=((-1.0, 0.3), *fence[1:])))
