"""Robots of the user's own are calibrated: by a flight of theirs, or by its folder again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import skylimb
from made_robots import multirotor
from skylimb.base.errors import ConfigError
from skylimb.studies.calibration.excited import require_excited
from skylimb.studies.calibration.public import robot_of
from skylimb.studies.calibration.record import record_of
from skylimb.studies.calibration.report import write_calibration


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> skylimb.Run:
    """A hexarotor without joints, which nobody ships."""
    robot = multirotor(tmp_path_factory.mktemp("own"), mass=2.5, thrust_max=15.0).parent
    short = {"phases.hover": 1.0, "phases.tare": 2.0, "phases.hover_end": 0.5, "posture.waypoints": []}
    return skylimb.run("calibration", set={"robot": str(robot), **short})


def test_its_log_is_read_and_shows_motion(flown: skylimb.Run) -> None:
    record = record_of(flown, robot_of(flown))
    assert record.angles.shape[1] == 0
    require_excited(record)


def test_a_log_without_the_robots_files_says_so(flown: skylimb.Run, tmp_path: Path) -> None:
    flown.save(tmp_path / "log.nc")
    with pytest.raises(ConfigError, match=r"without its robot's files.*; name the folder of the flight"):
        robot_of(skylimb.Run.load(tmp_path / "log.nc"))


@pytest.mark.slow
def test_it_is_calibrated_from_its_flight_and_from_its_folder(flown: skylimb.Run, tmp_path: Path) -> None:
    made = skylimb.calibrate(flown)
    assert made.corrections.robot == flown.log.attrs["robot"]
    np.testing.assert_allclose(made.corrections.rotor_scale, np.ones(6), atol=0.03)
    folder = write_calibration(made, tmp_path / "calibrated", flown)
    assert skylimb.calibrate(folder).corrections == made.corrections
