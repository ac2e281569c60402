"""Robots of two and three rotors on the topics: take-off, hover and landing."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armed_robots import multirotor_with_arm
from skylimb.apps.robot_import.writing import import_robot
from wired import Wire

STICK: dict[str, Any] = {"joints": (), "stick": 0.45, "turning": 1.5, "mass": 0.8}
SMOOTHED = {"controller.estimation.smoothing.on": True, "controller.translation.force": 0.5}
"""A velocity is the difference of positions here: without smoothing the tricopter is lost at take-off."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "made",
    [
        {"rotors": 2, "layers": (0.15,), "mount": "0.1 0 0"},
        {"rotors": 3, "mass": 1.2},
        {"rotors": 3, "mass": 1.2, "fixed": (0, 2)},
    ],
    ids=["bicopter", "tricopter", "tail"],
)
@pytest.mark.usefixtures("no_picture")
def test_it_takes_off_hovers_and_lands(made: dict[str, Any], tmp_path: Path) -> None:
    folder = tmp_path / "robot"
    import_robot(multirotor_with_arm(tmp_path / "robot.urdf", **{**STICK, **made}), folder)
    keys = {"robot": str(folder), "sensors.imu.on": True, **SMOOTHED}
    wire = Wire(flown=("board_tilted_hexarotor", "following", keys))
    wire.hover()
    wire.fly(5.0)
    assert np.std(wire.where[-600:], axis=0).max() < 0.05
    wire.tick("teleop_command/land")
    wire.fly(8.0)
    assert wire.said[-1] == "STOP -> ARM_OFF"
    assert not wire.armed
