"""Imported multirotors with fixed rotors: hover and greatest push against linear programmes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armed_robots import TWO, multirotor_with_arm
from push_programmes import best_over_leans, lean_of, limits, margin_at
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.robots.equilibrium import can_hold, greatest_push
from skylimb.robots.equilibrium_results import TILT, Held, NotHeld, Within
from skylimb.robots.model import Robot

HEX: dict[str, Any] = {"joints": (), "stick": 0.5, "rotors": 6, "place": 0.32, "mass": 2.2}
MADE: dict[str, dict[str, Any]] = {
    "quadrotor, stick": {"joints": (), "stick": 0.45},
    "quadrotor, arm": {"joints": TWO},
    "hexarotor, heavy in front": {**HEX, "heavy": 1.2},
    "hexarotor, canted": {**HEX, "cant": 0.3},
    "octorotor, reversible": {**HEX, "rotors": 8, "cant": 0.5, "least": -12.0, "radius": 0.1, "place": 0.36},
    "six rotors, two above each other": {**HEX, "rotors": 3, "layers": (0.08, -0.02)},
}
BENT = (
    "posture = { offset = [0.3, -0.8], slope = [1.0, 1.0], "
    "theta_min = -0.1, theta_max = 0.1, theta_nominal = 0.0 }"
)
ANGLES = np.zeros(0)
RIGID = {"servo": 1e6, "stiff": True}
WAYS = np.array([[1.0, 0.0, 0.0], [0.6, -0.5, 0.3]])


def imported(folder: Path, given: dict[str, Any]) -> Robot:
    path, mapping = multirotor_with_arm(folder / "made.urdf", **given), folder / "mapping.toml"
    mapping.write_text(BENT if given["joints"] else "")
    return Robot(check_robot_file(path, mapping=mapping).description)


@pytest.mark.parametrize("given", MADE.values(), ids=MADE)
def test_a_level_hover_leaves_the_most_torque_that_a_linear_programme_finds(
    tmp_path: Path, given: dict[str, Any]
) -> None:
    robot = imported(tmp_path, given)
    q = robot.nominal_posture()
    found = can_hold(robot, q, ANGLES, None, Within(0.0, **RIGID))
    assert isinstance(found, Held), found
    low, high = limits(robot).T
    assert np.all((low <= found.thrusts) & (found.thrusts <= high))
    assert found.margin == pytest.approx(margin_at(robot, q, ANGLES, np.zeros(2)), rel=5e-3)


def test_what_no_linear_programme_holds_is_refused(tmp_path: Path) -> None:
    robot = imported(tmp_path, {**HEX, "heavy": 3.0})
    assert margin_at(robot, np.zeros(0), ANGLES, np.zeros(2)) < 0.0
    assert isinstance(can_hold(robot, np.zeros(0), ANGLES, None, Within(0.0, **RIGID)), NotHeld)


@pytest.mark.parametrize("name", ["quadrotor, arm", "hexarotor, heavy in front", "octorotor, reversible"])
def test_the_greatest_push_is_the_best_of_linear_programmes_over_all_leans(tmp_path: Path, name: str) -> None:
    robot = imported(tmp_path, MADE[name])
    q = robot.nominal_posture()
    for way in WAYS:
        along = way / np.linalg.norm(way)
        found = greatest_push(robot, q, ANGLES, along, Within(TILT, **RIGID))
        assert isinstance(found, Held), found
        best = best_over_leans(robot, q, ANGLES, along, lean_of(robot, found, q, ANGLES))
        assert found.force == pytest.approx(best, abs=2e-4 * robot.weight)
