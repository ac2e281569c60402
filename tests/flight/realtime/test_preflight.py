"""What is looked at before a flight: each thing fails for its own reason, by its name."""

from __future__ import annotations

import socket
import sys
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange.body import Body
from skylimb.apps.ros.profile import profile_topics
from skylimb.apps.ros1.installation import described_mass
from skylimb.apps.ros1.master import MasterWatch
from skylimb.base.errors import ConfigError
from skylimb.base.rotations import rotation_from_rpy
from skylimb.control.calibration_date import age_of, dated
from skylimb.control.estimation.records import Imu
from skylimb.control.supervisor.descents import unprotected
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.realtime.beginning import Beginning
from skylimb.flight.realtime.preflight import (
    Measured,
    PreflightFacts,
    StartLimits,
    checks,
    fence_of,
    preflight_facts,
)
from skylimb.flight.realtime.resting_imu import ImuOff, RestingImu

LIMITS = StartLimits(fence=((-2.0, 2.0), (-1.0, 1.0), (0.0, 3.0)))
I3, Z3 = np.eye(3), np.zeros(3)
STANDS = Body(np.array([0.1, 0.2, 0.3]), Z3, I3, Z3, Z3, Z3, I3, Z3, Z3, I3)
FACTS = PreflightFacts((4.1, 4.12), 2.0, 5e9)
AGES, OFFSETS = {"mocap/pose": 0.01, "imu": 0.005}, {"mocap/pose": -0.02, "imu": 0.001}
SOUND = Measured(STANDS, AGES, OFFSETS, 80.0, imu=ImuOff(0.3, 0.01))


def failed(facts: PreflightFacts = FACTS, measured: Measured = SOUND) -> list[str]:
    return [str(one) for one in checks(facts, measured, LIMITS) if not one.fine]


def test_a_robot_that_is_ready_passes_every_check() -> None:
    found = list(checks(FACTS, SOUND, LIMITS))
    assert failed() == []
    assert [one.name for one in found] == [
        "attitude", "motion", "fence", "IMU's force", "IMU's turning", "age of mocap/pose", "age of imu",
        "clock of mocap/pose", "clock of imu", "battery", "publishers of commands", "disk",
        "age of the calibration", "robot",
    ]  # fmt: skip
    assert [one.name for one in checks(PreflightFacts(), Measured(STANDS), LIMITS)] == [
        "attitude", "motion", "fence", "publishers of commands", "disk",
    ]  # fmt: skip


def test_the_pilots_page_names_every_check() -> None:
    beginning = Beginning(Z3, 0.0, np.zeros(2), 0.0, 0.0, 0.0)
    everything = replace(SOUND, beginning=beginning, rates={"mocap/pose": 100.0})
    facts = replace(FACTS, unprotected="rotor1")
    names = {one.name for one in (*checks(facts, everything, LIMITS), *checks(facts, Measured(None), LIMITS))}
    page = (Path(__file__).parents[3] / "docs" / "pilot.md").read_text(encoding="utf-8")
    table = page.partition("| check |")[2].partition("\n\n")[0]
    rows = [line.split("|")[1].strip() for line in table.splitlines()[2:]]
    told = {name for row in rows for name in row.split(", ")}
    # Those of a sensor stand for all of them.
    general = {
        "age of": "age of each sensor",
        "clock of": "clock of each sensor",
        "rate of": "rate of the motion capture",
    }
    for name in names:
        head = name.rpartition(" ")[0] if name.endswith((" mocap/pose", " imu")) else ""
        assert general.get(head, name) in told, name


def test_rotors_that_cannot_be_lost_are_named_and_refuse_nothing() -> None:
    robot = skylimb.load_robot("hydrus_xi_quad")
    told = unprotected(robot, "contact", Limits(losses=True))
    assert told == "rotor1, rotor4"
    assert unprotected(robot, "contact", Limits()) == "all, as supervisor.losses is off"
    found = {one.name: one for one in checks(replace(FACTS, unprotected=told), SOUND, LIMITS)}
    assert found["rotors whose loss is not protected"].found == told
    assert all(one.fine for one in found.values())


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"body": None}, "position: not known (a fresh pose"),
        ({"body": None, "unknown": "too fast"}, "position: not known: too fast (a fresh pose"),
        ({"rates": {"mocap/pose": 12.5}}, "rate of mocap/pose: 12.5 Hz (at least 18)"),
        ({"rates": {"mocap/pose": np.nan}}, "rate of mocap/pose: not known (at least 18)"),
        ({"body": STANDS._replace(R_WC=np.asarray(rotation_from_rpy(1.8, 0.0, 0.3)))}, "attitude: 1.8 rad"),
        ({"body": STANDS._replace(velocity=np.array([0.0, 0.0, -0.6]))}, "motion: 0.6 m/s"),
        (
            {"body": STANDS._replace(cog=np.array([0.0, 1.2, 0.3]))},
            "fence: y = 1.20 m is outside",
        ),
        ({"ages": {**AGES, "imu": 0.3}}, "age of imu: 0.3 s"),
        ({"offsets": {**OFFSETS, "imu": -0.2}}, "clock of imu: 0.2 s beside ours"),
        ({"offsets": {**OFFSETS, "imu": np.nan}}, "clock of imu: nan s"),
        ({"battery": 9.0}, "battery: 9 %"),
        ({"battery": np.nan}, "battery: not known (at least 10 %)"),
        ({"imu": ImuOff(19.6, 0.0)}, "IMU's force: 19.6 m/s^2 beside gravity"),
        ({"imu": ImuOff(np.nan, 0.0)}, "IMU's force: nan m/s^2"),
        ({"imu": ImuOff(0.1, 0.2)}, "IMU's turning: 0.2 rad/s beside the robot's"),
        (
            {"foreign": ("/base on /hydrus_xi/four_axes/command",)},
            "publishers of commands: /base",
        ),
    ],
)
def test_what_is_measured_is_refused_by_its_name(change: dict[str, Any], words: str) -> None:
    (found,) = failed(measured=replace(SOUND, **change))
    assert found.startswith(words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"masses": (4.6, 4.12)}, "robot: 4.600 kg as described, 4.120 kg in its file"),
        ({"calibrated": 31.0}, "age of the calibration: 31 days (0 to 30)"),
        ({"calibrated": -0.5}, "age of the calibration: -0.5 days"),
        ({"calibrated": np.nan}, "age of the calibration: not known: its file does not say"),
        ({"free": 9e8}, "disk: 0.9 GB free"),
    ],
)
def test_what_lies_on_the_desk_is_refused_by_its_name(change: dict[str, Any], words: str) -> None:
    (found,) = failed(replace(FACTS, **change))
    assert found.startswith(words)


@pytest.mark.parametrize(
    ("force", "gyro", "off"),
    [
        ((0.0, 0.0, 9.81), (0.0, 0.01, 0.0), (0.0, 0.01)),
        ((0.0, 0.0, -9.81), (0.0, 0.0, 0.0), (19.62, 0.0)),
        ((0.0, 0.0, 1.0), (0.0, 0.3, 0.0), (8.81, 0.3)),
        ((9.81, 0.0, 0.0), (0.0, 0.0, 0.0), (13.87, 0.0)),
        ((np.nan, 0.0, 9.81), (0.0, 0.0, 0.0), (np.nan, 0.0)),
    ],
)
def test_a_wrong_sign_unit_or_axis_of_an_imu_shows_on_the_ground(force: Any, gyro: Any, off: Any) -> None:
    """By the attitude that another sensor shows; one knock says nothing."""
    R = np.asarray(rotation_from_rpy(0.1, -0.05, 1.0))
    imu = RestingImu(9.81)
    assert imu.off is None
    for k in range(40):
        knock = 100.0 * (k % 9 == 0)
        imu.take(R, Z3, Imu(np.array(gyro) + knock, R.T @ (np.array(force) + knock)))
    assert imu.off == pytest.approx(off, abs=0.01, nan_ok=True)


def test_a_calibration_is_as_old_as_it_says(tmp_path: Path) -> None:
    """However it was copied."""
    path, now = tmp_path / "calibration.toml", datetime.now(UTC)
    path.write_text(dated('format = "x"\n'))
    assert age_of(path) == pytest.approx(0.0, abs=0.01)
    assert age_of(path) >= 0.0
    for days in (400.0, -2.0):
        path.write_text(f"made = {(now - timedelta(days=days)).isoformat()}\n")
        facts = preflight_facts(skylimb.load_robot("hydrus_xi_quad"), None, str(path), "")
        assert facts.calibrated == pytest.approx(days, abs=0.01)
    path.write_text('format = "x"\n')
    assert np.isnan(age_of(path))


def test_a_fence_is_six_numbers_that_rise() -> None:
    assert fence_of((-1, 1, -2, 2, 0, 3)) == ((-1, 1), (-2, 2), (0, 3))
    for wrong in ((-1, 1, -2, 2, 0), (1, -1, -2, 2, 0, 3), (-1, 1, -2, 2, 0, float("nan"))):
        with pytest.raises(ConfigError, match="--fence"):
            fence_of(wrong)


def master(monkeypatch: pytest.MonkeyPatch, **answers: Any) -> None:
    answering = SimpleNamespace(Master=lambda name: SimpleNamespace(**answers), MasterException=LookupError)
    monkeypatch.setitem(sys.modules, "rosgraph", answering)


def test_the_master_tells_who_else_commands_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    publishers = [["/h/four_axes/command", ["/skylimb", "/base", "/killed"]], ["/h/joints_ctrl", ["/user"]]]
    with socket.create_server(("127.0.0.1", 0)) as base, socket.create_server(("127.0.0.1", 0)) as killed:
        ports = {"/base": base.getsockname()[1], "/killed": killed.getsockname()[1]}
        killed.close()
        master(
            monkeypatch,
            getSystemState=lambda: (publishers, [], []),
            lookupNode=lambda name: f"http://127.0.0.1:{ports[name]}/",
        )
        foreign = foreign_to_skylimb()
    assert foreign == ("/base on /h/four_axes/command",)


def test_a_node_that_cannot_be_reached_may_command_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its machine may be slow, or behind a network that is."""
    publishers = [["/h/four_axes/command", ["/skylimb", "/far"]]]
    system = {
        "getSystemState": lambda: (publishers, [], []),
        "lookupNode": lambda name: "http://256.1.1.1:1/",
    }
    master(monkeypatch, **system)
    assert foreign_to_skylimb() == ("/far on /h/four_axes/command",)


def foreign_to_skylimb() -> tuple[str, ...]:
    topics = {topic.full("h") for topic in profile_topics("controller").commands}
    watch = MasterWatch(topics, "/skylimb", every=1e-3)
    while watch.foreign is None:
        pass
    watch.close()
    return watch.foreign


def test_the_described_robot_is_weighed(monkeypatch: pytest.MonkeyPatch) -> None:
    text = '<robot><link><inertial><mass value="1.5"/></inertial></link><mass value="2"/></robot>'
    for told, mass in ((text, 3.5), ("<robot", None), ("<robot/>", None)):
        master(monkeypatch, getParam=lambda name, told=told: told)
        assert described_mass("hydrus_xi") == mass
