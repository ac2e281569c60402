"""Parts of a flight in which motors could not follow, so that thrusts are not known."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.robots.model import Robot
from skylimb.studies.calibration.motors import followed
from skylimb.studies.calibration.public import calibration_from
from skylimb.studies.calibration.report import write_calibration


def test_a_third_of_a_second_without_motion_capture_moves_no_number_beyond_its_interval(
    short: dict[str, Any], otherwise: dict[str, Any], robot: Robot, tmp_path: Path
) -> None:
    """The lag was 6.5 standard deviations off: rotors were commanded from 1 to 30 N when frames came back."""
    lost = {"kind": "sensor", "time": 8.0, "duration": 0.35, "capture": "lost"}
    flown = skylimb.run("calibration", seed=2, set={**short, **otherwise, "events": [lost]})
    made = calibration_from(flown, robot)
    assert made.truth is not None
    beside = np.abs(made.estimate.value - made.truth) / made.estimate.deviation
    assert beside.max() < 3.5, dict(zip(made.estimate.labels, beside.round(1), strict=True))
    # Nor are the intervals wide.
    assert made.estimate.deviation[list(made.estimate.labels).index("rotor_lag")] < 2e-4
    assert 0.3 < made.flight["seconds_unfollowed"] < 2.0
    page = (write_calibration(made, tmp_path / "made") / "report.html").read_text(encoding="utf-8")
    assert f"Another {made.flight['seconds_unfollowed']:g} s, in which motors could not follow" in page


def test_a_motor_follows_as_far_as_its_torque_goes(robot: Robot) -> None:
    rotor = robot.description.rotors[1]
    command = np.full((400, robot.n_rotors), 10.0)
    command[100:, 1] = 30.0
    follows = followed(command, 0.005, robot)
    assert follows[:100].all()
    assert not follows[100:160].any()  # six lags of 0.05 s
    assert follows[200:].all()
    # By the torque that a step of speed takes in the tick after it; drag comes besides.
    assert rotor.thrust_factor is not None
    assert rotor.inertia is not None
    speeds = np.sqrt(np.array([10.0, 30.0]) / rotor.thrust_factor)
    needed = rotor.inertia * np.diff(speeds)[0] * (1.0 - np.exp(-0.005 / rotor.lag)) / 0.005
    assert needed + rotor.drag_torque_coefficient * 10.0 > rotor.torque_max
    command[100:, 1] = 12.0
    assert followed(command, 0.005, robot).all()


def test_thrusts_are_those_of_the_lag_alone_wherever_motors_follow(
    short: dict[str, Any], robot: Robot
) -> None:
    """Held against the rotors that are simulated, whose torque has a limit."""
    lost = {"kind": "sensor", "time": 3.0, "duration": 0.35, "capture": "lost"}
    log = skylimb.run("calibration", seed=2, set={**short, "events": [lost]}).log
    command, dt = log["thrusts_command"].values, 0.005
    factor = np.array([rotor.thrust_factor for rotor in robot.description.rotors], dtype=float)
    left = np.exp(-dt / robot.description.rotors[0].lag)
    speed, wanted = log["rotor_speeds"].values.copy(), np.sqrt(command / factor)
    for before, now, speeds in zip(speed[:-1], speed[1:], wanted[:-1], strict=True):
        now[:] = left * before + (1.0 - left) * speeds
    beside = np.abs(factor * speed**2 - log["thrusts"].values).max(axis=1)
    follows = followed(command, dt, robot)
    assert 0.1 < dt * np.count_nonzero(~follows) < 1.0
    assert beside[~follows].max() > 0.3
    assert beside[200:][follows[200:]].max() < 2e-3  # before, rotors come up from rest


def test_a_flight_whose_motors_never_follow_is_refused_and_says_why(flown: skylimb.Run, robot: Robot) -> None:
    command = flown.log["thrusts_command"]
    values = command.values.copy()
    values[::20, 0], values[10::20, 0] = 30.0, 1.0
    log = flown.log.assign(thrusts_command=(command.dims, values, command.attrs))
    with pytest.raises(ConfigError, match="motors could not follow what was commanded"):
        calibration_from(dataclasses.replace(flown, log=log), robot)
