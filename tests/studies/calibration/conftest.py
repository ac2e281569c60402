"""One short calibration flight, of a robot that differs from its description in everything."""

from __future__ import annotations

from typing import Any

import pytest

import skylimb
from skylimb.robots.loader import load_robot
from skylimb.robots.model import Robot
from skylimb.studies.calibration.public import calibration_from
from skylimb.studies.calibration.record import Record, record_of
from skylimb.studies.calibration.result import Calibration


@pytest.fixture(scope="session")
def robot() -> Robot:
    """The robot as it is described."""
    return load_robot("hydrus_xi_quad")


@pytest.fixture(scope="session")
def short() -> dict[str, Any]:
    """Changes that leave a third of the flight that ships."""
    return {
        "phases.hover": 1.0,
        "phases.tare": 2.0,
        "phases.hover_end": 0.5,
        "posture.waypoints": [[1.57, 0.3, 0.3], [0.2, 1.57, 0.2]],
    }


@pytest.fixture(scope="session")
def otherwise() -> dict[str, Any]:
    """How the robot that flies differs from its description."""
    return {
        "plant.rotor_scale": [0.98, 1.01, 1.02, 1.0],
        "plant.cog_offset": [0.01, -0.005, 0.01],
        "plant.mass_scale": 1.01,
        "plant.rotor_lag": 0.06,
        "sensors.attitude_misalignment": [0.01, -0.01, 0.017],
        "sensors.latency": 0.025,
    }


@pytest.fixture(scope="session")
def flown(short: dict[str, Any], otherwise: dict[str, Any]) -> skylimb.Run:
    """The flight."""
    return skylimb.run("calibration", seed=2, set={**short, **otherwise})


@pytest.fixture(scope="session")
def record(flown: skylimb.Run, robot: Robot) -> Record:
    """Its record."""
    return record_of(flown, robot)


@pytest.fixture(scope="session")
def made(flown: skylimb.Run, robot: Robot) -> Calibration:
    """Its calibration."""
    return calibration_from(flown, robot)
