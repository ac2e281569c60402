"""Ways down in the user's cache: found once, and anew for another robot."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.control.supervisor import kept_ways
from skylimb.control.supervisor.kept_ways import Ways, kept_or_found
from skylimb.robots.model import Robot

POSTURE = np.array([0.1, 1.0 / 3.0]), np.array([0.7])
FOUND: tuple[Ways, Ways] = (np.array([1.0 / 3.0, -np.pi]), None), (None,)


@pytest.fixture
def robot(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Robot:
    """A robot, and a cache of its own."""
    monkeypatch.setattr(kept_ways, "cache_folder", lambda: tmp_path)
    return skylimb.load_robot("hydrus_xi_quad")


def ways(robot: Robot, *constants: float, posture: tuple[np.ndarray, np.ndarray] = POSTURE) -> int:
    """How often a search was needed; what comes is what it finds, to the last bit."""
    searched: list[int] = []

    def search() -> tuple[Ways, Ways]:
        searched.append(1)
        return FOUND

    for rotors, joints in (kept_or_found(robot, posture, constants, search) for _ in range(2)):
        assert rotors[0] is not None
        assert rotors[0].tobytes() == FOUND[0][0].tobytes()  # type: ignore[union-attr]
        assert (rotors[1], joints) == (None, (None,))
    return len(searched)


def test_they_are_found_once(robot: Robot) -> None:
    assert ways(robot, 0.1) == 1
    assert ways(robot, 0.1) == 0


def test_another_robot_posture_or_constant_is_searched_anew(robot: Robot) -> None:
    servos = replace(robot.description.shape_servos, torque_limit=3.0)
    for other in (robot, Robot(replace(robot.description, shape_servos=servos))):
        assert ways(other, 0.1) == 1
    fewer = Robot(replace(robot.description, rotors=robot.description.rotors[1:]))
    assert ways(fewer, 0.1) == 1
    assert ways(robot, 0.2) == 1
    assert ways(robot, 0.1, posture=(POSTURE[0] + 1e-12, POSTURE[1])) == 1
    assert ways(robot, 0.1) == 0


def test_a_damaged_entry_is_found_anew(robot: Robot, tmp_path: Path) -> None:
    assert ways(robot) == 1
    (entry,) = tmp_path.glob("descents/*.json")
    entry.write_bytes(entry.read_bytes()[:-3])
    with pytest.warns(UserWarning, match="damaged"):
        assert ways(robot) == 1
    assert ways(robot) == 0


def test_without_a_cache_they_are_found_each_time(monkeypatch: pytest.MonkeyPatch, robot: Robot) -> None:
    def nowhere() -> Path:
        raise ImportError("platformdirs")

    for folder in (nowhere, lambda: Path("~")):
        monkeypatch.setattr(kept_ways, "cache_folder", folder)
        assert ways(robot) == 2
    assert not Path("~").exists()
