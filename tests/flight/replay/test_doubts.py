"""A log of wrong units is named by what a live flight would refuse."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.clock import Clock
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.records import Command
from skylimb.flight.replay.doubts import doubts
from skylimb.flight.replay.recorded import Recorded, sampled

ROBOT = skylimb.load_robot("hydrus_xi_quad")
COUNT = 200


def hovering() -> Recorded:
    rows = lambda value: np.tile(np.asarray(value, dtype=float), (COUNT, 1))  # noqa: E731
    q, psi = nominal_posture(ROBOT, "torque")
    z = [0.0, 0.0, 0.0]
    measured = Measurement(
        rows([0.3, 0.0, 1.2]),
        rows([1.0, 0.0, 0.0, 0.0]),
        rows(z),
        rows(z),
        rows(q),
        rows(psi),
        np.zeros(COUNT),
    )
    command = Command(rows(np.full(4, 10.0)), rows(q), rows(psi))
    ticks = np.arange(float(COUNT))
    return Recorded(0.005 * ticks, measured, command, Clock(ticks, np.ones(COUNT)), np.zeros(COUNT, bool), ())


def test_a_sound_log_raises_no_doubt() -> None:
    held = hovering()
    held.measurement.position[:5] *= 1000.0  # a few rows
    assert list(doubts(held, ROBOT)) == []
    no_thrusts = replace(held, command=held.command._replace(thrusts=np.full((COUNT, 4), np.nan)))
    assert list(doubts(no_thrusts, ROBOT)) == []


@pytest.mark.parametrize(
    ("entry", "change", "words"),
    [
        ("position", lambda value: 1000.0 * value, "root_position_measured is outside of "),
        (
            "velocity",
            lambda value: value + 50.0,
            "velocity is above 10 m/s in 100 % of its rows: mill",
        ),
        ("angular_velocity", lambda value: value - 57.0, "angular velocity is above 20 rad/s"),
        (
            "quaternion",
            lambda value: value[:, [1, 2, 0, 3]],
            "root_quaternion_measured tilts by more than 0.7",
        ),
        ("quaternion", lambda value: 2.0 * value, "root_quaternion_measured is of another length than 1"),
        ("joint_angles", np.degrees, "joint_angles_measured is beyond the joints' limits in 100 %"),
    ],
)
def test_what_no_live_flight_believes_is_named(entry: str, change: Any, words: str) -> None:
    held = hovering()
    value = change(getattr(held.measurement, entry))
    held = replace(held, measurement=held.measurement._replace(**{entry: value}))
    found = list(doubts(held, ROBOT))
    assert found[0].startswith(words)


def test_thrusts_in_grams_are_named() -> None:
    held = hovering()
    held = replace(held, command=held.command._replace(thrusts=held.command.thrusts * 1000.0 / 9.81))
    (found,) = doubts(held, ROBOT)
    assert found == "thrusts_command is above the rotors' 30 N in 100 % of its rows: grams?"


def test_a_log_whose_time_is_in_milliseconds_is_refused() -> None:
    log = xr.Dataset(coords={"time": 5.0 * np.arange(100)})
    with pytest.raises(ConfigError, match=r"rows at 0\.2 Hz cannot be replayed: at least 10 Hz; is its"):
        sampled(log, 0.005)
