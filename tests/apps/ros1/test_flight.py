"""Real flights over a real master: the node `both`, a client with the lab's topics, a recorder."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange.convert import read_log
from skylimb.analysis.report.controller_replay import differences

HERE = Path(__file__).parent
TESTS = HERE.parents[1]
CLIENT, MESSAGES = TESTS / "helpers" / "lab_client.py", TESTS / "analysis" / "exchange" / "messages"
RECORDER = Path("/usr/lib/rosbag/record")
QUICK = {
    "phases.hover": 0.4,
    "phases.tare": 0.3,
    "phases.settle": 0.3,
    "phases.hover_end": 0.1,
    "approach.depth": 0.05,
    "approach.standoff": 0.02,
    "approach.speed": 0.3,
    "approach.retreat_speed": 0.3,
    "trajectory.radius": 0.02,
    "trajectory.period": 1.0,
}
"""A mission of few seconds."""

FRAMES = {
    **{"hydrus_xi/root": "world", "hydrus_xi/cog": "hydrus_xi/root", "hydrus_xi/fc": "hydrus_xi/root"},
    **{"hydrus_xi/link1": "hydrus_xi/root", "hydrus_xi/link2": "hydrus_xi/link1"},
    **{"hydrus_xi/battery2": "hydrus_xi/link2", "hydrus_xi/gimbal3": "hydrus_xi/link3"},
}
"""Some of those that are said, fixed ones among them."""


@contextmanager
def running(environment: dict[str, str], words: list[str], log: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A program, which gets Ctrl-C at the end."""
    with log.open("wb") as out:
        process = subprocess.Popen(words, env=environment, stdout=out, stderr=subprocess.STDOUT)
        try:
            yield process
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            try:
                process.wait(60)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def both(controller: str, out: Path, settings: dict[str, float]) -> list[str]:
    words = [sys.executable, "-m", "skylimb", "ros", "both", "--controller", controller, "--out", str(out)]
    words += ["--messages", str(MESSAGES)]
    changes = [f"{key}={value}" for key, value in settings.items()]
    return [*words, "--set", *changes] if changes else words


def require_time(said: str) -> None:
    """Skip where the machine was too busy for flights in real time, as the node itself says."""
    for late, ticks in re.findall(r"(\d+) of (\d+) ticks overran", said):
        if int(late) > 0.1 * int(ticks):
            pytest.skip(f"this machine is too busy: {late} of {ticks} ticks overran")
    for missed in re.findall(r"missed tick: (\d+) times", said):
        if int(missed) > 200:  # a second in all, in which nobody held the robot
            pytest.skip(f"this machine is too busy: {missed} ticks were missed")


def wait_for(log: Path, words: str, seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while words not in log.read_text(encoding="utf-8"):
        assert time.monotonic() < end, log.read_text(encoding="utf-8")
        time.sleep(0.1)


def fly(
    environment: dict[str, str],
    tmp_path: Path,
    controller: str,
    settings: dict[str, float],
    seconds: float,
    meanwhile: Callable[[], None] = lambda: None,
    record: bool = True,
) -> tuple[dict[str, Any], str]:
    """A whole flight by the client; what it saw, and what the node said."""
    log, bag = tmp_path / "node.log", tmp_path / "flight.bag"
    with running(environment, both(controller, tmp_path / "out", settings), log):
        wait_for(log, "both: hydrus_xi_quad")
        recorder = [str(RECORDER), "-O", str(bag), "-a"] if record else ["sleep", "1000"]
        with running(environment, recorder, tmp_path / "record.log"):
            time.sleep(2.0)
            words = [sys.executable, str(CLIENT), "paper", str(seconds), str(tmp_path / "seen.json")]
            client = subprocess.Popen(
                words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
            )
            meanwhile()
            told = client.communicate(timeout=seconds + 150.0)[0]
    said = log.read_text(encoding="utf-8")
    require_time(said)
    assert client.returncode == 0, told.decode() + said
    return json.loads((tmp_path / "seen.json").read_text(encoding="utf-8")), said


@pytest.mark.slow
def test_a_flight_with_the_labs_topics_survives_its_master(master: dict[str, str], tmp_path: Path) -> None:
    def kill() -> None:
        wait_for(tmp_path / "node.log", "TAKEOFF -> HOVER", 60.0)
        time.sleep(1.5)
        os.kill(int(master["MASTER_PID"]), signal.SIGKILL)

    seen, said = fly(master, tmp_path, "hybrid", QUICK, 12.0, kill, record=False)
    assert seen["states"][0] == 0
    assert FRAMES.items() <= dict(seen["frames"]).items()
    # START and STOP last for a tick; the topic shows every fifth.
    assert [state for state in seen["states"] if state not in (1, 6)][-5:] == [2, 3, 5, 4, 0]
    assert "takeoff is refused in HOVER: the robot flies already" in said
    assert "start is refused in HOVER" in said
    assert "fault: master is gone" in said
    assert "mission 'paper': flown; hovering at its end" in said
    scores = json.loads((tmp_path / "out" / "01-paper" / "metrics.json").read_text(encoding="utf-8"))
    assert scores["paper" if "paper" in scores else next(iter(scores))]


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["hybrid", "following"])
def test_the_papers_slide_is_that_of_run_and_its_bag_is_replayed(
    master: dict[str, str], tmp_path: Path, controller: str
) -> None:
    if not RECORDER.is_file():
        pytest.skip("no rosbag record here: apt-get install python3-rosbag")
    length = {"hybrid": 50.0, "following": 75.0}[controller]
    _, said = fly(master, tmp_path, controller, {}, length)
    assert "mission 'paper': flown; hovering at its end" in said
    folder = next((tmp_path / "out").glob("01-*"))
    flown = skylimb.Run.load(folder)
    assert flown.status == "OK"
    alone = [skylimb.run("paper", controller, seed=seed) for seed in (0, 1, 2)]
    for name in ("error_u_median", "error_v_median", "contact_force_normal_mean", "contact_fraction"):
        values = [run.metrics[name] for run in alone]
        wide = 3.0 * float(np.ptp(values)) + 0.1 * abs(float(np.mean(values)))
        assert abs(flown.metrics[name] - float(np.mean(values))) < wide, (name, flown.metrics[name], values)
    bag = tmp_path / "flight.bag"
    run = read_log(bag).run
    again = skylimb.replay(bag)
    assert [one for one in differences(run, again) if not one.same] == []
    for name in ("thrusts_command", "external_force_estimate"):
        np.testing.assert_allclose(again.log[name], run.log[name], atol=1e-9, rtol=0)


@pytest.mark.slow
def test_controller_and_simulator_fly_in_servo_counts(master: dict[str, str], tmp_path: Path) -> None:
    """As on the robot: motors told before arming, servos in counts, and a flight controller between them."""
    lab = HERE.parent / "ros" / "lab"
    common = ["--messages", str(MESSAGES), "--config", str(lab / "servo.yaml")]
    settings = ["--set", *(f"{key}={value}" for key, value in QUICK.items())]
    ros = [sys.executable, "-m", "skylimb", "ros"]
    simulator = [*ros, "simulator", "--experiment", "paper", *common, *settings]
    motors = str(lab / "motor_info.yaml")
    controller = [*ros, "controller", "--bare", "--controller", "hybrid", *common, motors, *settings]
    log = tmp_path / "controller.log"
    with (
        running(master, simulator, tmp_path / "simulator.log"),
        running(master, controller, log),
    ):
        wait_for(log, "controller: hydrus_xi_quad")
        wait_for(tmp_path / "simulator.log", "simulator: hydrus_xi_quad")
        time.sleep(2.0)
        words = [sys.executable, str(CLIENT), "paper", "14", str(tmp_path / "seen.json")]
        client = subprocess.run(words, env=master, capture_output=True, timeout=180.0, check=False)
    said = log.read_text(encoding="utf-8")
    require_time(said)
    assert client.returncode == 0, client.stdout.decode() + client.stderr.decode() + said
    seen = json.loads((tmp_path / "seen.json").read_text(encoding="utf-8"))
    assert [state for state in seen["states"] if state not in (1, 6)][-5:] == [2, 3, 5, 4, 0]
    assert FRAMES.items() <= dict(seen["frames"]).items()
    assert "mission 'paper': flown; hovering at its end" in said
    for name, angle in {"joint1": 0.87, "joint2": 1.4, "joint3": -0.7}.items():
        assert abs(seen["posed"][name] - angle) < 0.08


@pytest.mark.slow
def test_hostile_publishers_of_real_messages(master: dict[str, str], tmp_path: Path) -> None:
    """A second battery, a wrong md5, and a flood, by real publishers; the node says each."""
    log = tmp_path / "node.log"
    with running(master, both("hybrid", tmp_path / "out", QUICK), log):
        wait_for(log, "both: hydrus_xi_quad")
        hostile = HERE / "hostile.py"
        for what in ("flood", "md5", "battery", "battery"):
            subprocess.Popen([sys.executable, str(hostile), what], env=master)
        for words in (
            "fault: flood of target_pose",
            "fault: wrong md5 of uav/nav",
            "second publisher of battery",
        ):
            wait_for(log, words, 40.0)
    assert "Traceback" not in log.read_text(encoding="utf-8")
