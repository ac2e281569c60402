"""A hover that numbers at rest allow, and that a flight does not."""

from pathlib import Path

import pytest

from armed_robots import multirotor_with_arm
from made_robots import chain
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.apps.robot_import.findings import hover_doubts
from skylimb.apps.robot_import.hover_flight import HOVER, not_hovered
from skylimb.flight.public import run
from skylimb.robots.loader import load_robot


def test_a_hover_that_its_servos_are_too_slow_for_is_none(tmp_path: Path) -> None:
    robot = chain(tmp_path, links=2)
    found = check_robot_file(robot)
    assert found.actuation is not None
    assert found.actuation.hover  # at rest it is held
    assert not found.can_hover
    (reason,) = found.reasons
    assert "does not last in a flight: lost attitude" in reason.value
    flown = run("free_flight", "following", set={"robot": str(robot), **HOVER})
    assert not_hovered(flown) in reason.value


def test_a_bicopter_that_hovers_is_passed(tmp_path: Path) -> None:
    made = {"joints": (), "stick": 0.45, "rotors": 2, "turning": 1.5, "mass": 0.8, "layers": (0.15,)}
    found = check_robot_file(multirotor_with_arm(tmp_path / "bicopter.urdf", mount="0.1 0 0", **made))
    assert found.can_hover, found.reasons


@pytest.mark.parametrize("name", ["tilted_hexarotor", "hydrus_xi_quad"])
def test_others_are_not_flown(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "skylimb.apps.robot_import.hover_flight.fly", lambda takeoff: pytest.fail(str(takeoff))
    )
    assert list(hover_doubts(load_robot(name))) == []
