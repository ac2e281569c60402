"""One short calibration flight, of a robot that differs from its description in everything."""

from __future__ import annotations

import pytest

import skylimb
from skylimb.calibration.public import calibration_from
from skylimb.calibration.record import Record, record_of
from skylimb.calibration.result import Calibration
from skylimb.robots.loader import load_robot

ROBOT = load_robot("hydrus_xi_quad")

SHORT = {
    "phases.hover": 1.0,
    "phases.tare": 2.0,
    "phases.hover_end": 0.5,
    "posture.waypoints": [[1.57, 0.3, 0.3], [0.2, 1.57, 0.2]],
}
"""A third of the flight that ships."""

OTHERWISE = {
    "plant.rotor_scale": [0.98, 1.01, 1.02, 1.0],
    "plant.cog_offset": [0.01, -0.005, 0.01],
    "plant.mass_scale": 1.01,
    "plant.rotor_lag": 0.06,
    "sensors.attitude_misalignment": [0.01, -0.01, 0.017],
    "sensors.latency": 0.025,
}


@pytest.fixture(scope="session")
def flown() -> skylimb.Run:
    """The flight."""
    return skylimb.run("calibration", seed=2, set={**SHORT, **OTHERWISE})


@pytest.fixture(scope="session")
def record(flown: skylimb.Run) -> Record:
    """Its record."""
    return record_of(flown, ROBOT)


@pytest.fixture(scope="session")
def made(flown: skylimb.Run) -> Calibration:
    """Its calibration."""
    return calibration_from(flown, ROBOT)
