"""What a node is started with: missions beside the first one, checked against robot, rate and surface."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from skylimb.analysis.exchange.lab_topics import RECORD
from skylimb.analysis.exchange.recorder import recording
from skylimb.apps.ros.lab_config import LabConfig, read_lab_config
from skylimb.apps.ros.run import _bends, _doubts, missions_of
from skylimb.base.errors import ConfigError, UnknownNameError
from steered import ready
from wired import LAB


def test_missions_have_the_names_of_their_experiments(tmp_path: Path) -> None:
    takeoff, _ = ready("hybrid")
    text = (
        'robot = "hydrus_xi_quad"\n[trajectory]\nshape = "drawing"\ntext = "l"\nheight = 0.1\nwidth = 0.1\n'
    )
    drawing = tmp_path / "letter.toml"
    drawing.write_text(text + "[surface]\nposition = [1.5, 0.0, 1.2]\n", encoding="utf-8")
    missions = missions_of(takeoff, ("free_flight", str(drawing)))
    assert [*missions] == ["paper", "free_flight", "letter"]
    assert missions["paper"] is takeoff.mission
    assert missions["letter"].contact


def test_missions_that_cannot_be_flown_are_refused(tmp_path: Path) -> None:
    takeoff, _ = ready("hybrid")
    with pytest.raises(UnknownNameError, match="did you mean 'free_flight'"):
        missions_of(takeoff, ("free_fligt",))
    slow = tmp_path / "slow.toml"
    slow.write_text("controller_rate = 100.0\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="mission 'slow' is at 100 Hz, the node at 200 Hz"):
        missions_of(takeoff, (str(slow),))


def test_what_was_flown_before_an_error_is_kept(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with recording(folder) as recorder:
        assert not folder.exists()
        assert recorder is not None
    assert recorder.faults == {}
    assert list(tmp_path.iterdir()) == []

    def fly() -> None:
        with recording(folder) as recorder:
            assert recorder is not None
            recorder.take([(RECORD, {"data": b"", "layout.dim": []})])
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError) as error:
        fly()
    assert [path.name for path in tmp_path.rglob("*")] == ["out-interrupted", "01-flight.mcap"]
    assert error.value.__notes__ == [f"what was flown is kept in '{tmp_path / 'out-interrupted'}'"]


def test_a_forced_landing_that_does_not_bring_the_robot_down_is_said() -> None:
    """It came down tipped over before the flight controller held the attitude; now it would float away."""
    takeoff, _ = ready("hybrid")
    lab = read_lab_config([LAB / "motor_info.yaml"], takeoff.robot)
    assert lab.motors is not None
    assert not any("forced landing" in words for words in _doubts(lab, takeoff.robot))
    strong = LabConfig(replace(lab.motors, force_landing_thrust=11.0))
    assert "ends with 11 N a rotor" in _doubts(strong, takeoff.robot)[0]


def test_who_begins_a_controller_is_warned_of_the_joints() -> None:
    """A robot that stood bent otherwise moved before anybody had ordered anything, and nothing said so."""
    takeoff, _ = ready("hybrid")
    assert "the joints go to (1.05, 1.05, -0.52) rad now" in _bends(takeoff)
