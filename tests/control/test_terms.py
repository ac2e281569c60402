"""What a law adds up is told where it is asked for, and is what the law's force and torque are made of."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from law_records import hover
from skylimb.base.signal_table import PLACE_TERMS, SIGNALS, TURN_TERMS
from skylimb.control.cascade import Cascade
from skylimb.control.controller import cascade_from_tables
from skylimb.control.laws.preset import preset_mapping
from skylimb.robots.model import Robot

DT = 0.005
TELLING = ("pid", "impedance", "admittance", "hybrid", "following", "drawing", "task_frame")
OFF = np.array([0.02, -0.03, 0.01])
MOVING = np.array([0.05, 0.02, -0.04])


def told(cascade: Cascade, ticks: int = 1) -> dict[str, np.ndarray]:
    """Signals beside the reference by `OFF`, moving at `MOVING`; the robot stands as it does in hover."""
    measurement, reference = hover(cascade)
    measurement = measurement._replace(position=measurement.position + OFF, velocity=MOVING)
    state, signals = cascade.initial_state(), dict[str, Any]()
    for _ in range(ticks):
        state, _, signals = cascade.step(cascade.gains(), state, measurement, reference, DT)
    return {name: np.ravel(np.asarray(value, float)) for name, value in signals.items()}


@pytest.mark.parametrize("name", TELLING)
def test_they_are_told_where_they_are_asked_for_alone(robot: Robot, name: str) -> None:
    cascade = cascade_from_tables(*preset_mapping(name), robot)
    plain, telling = told(cascade), told(replace(cascade, tells=True))
    assert telling.keys() - plain.keys() == {*PLACE_TERMS, *TURN_TERMS}
    assert {*PLACE_TERMS, *TURN_TERMS} <= SIGNALS.keys()
    for signal, value in plain.items():
        np.testing.assert_array_equal(value, telling[signal])
    # They lead back to the reference.
    proportional, _, derivative = (telling[one] for one in PLACE_TERMS)
    assert proportional @ OFF < 0.0
    assert derivative @ MOVING < 0.0


def test_a_preset_that_plans_tells_none_of_its_path(robot: Robot) -> None:
    telling = told(replace(cascade_from_tables(*preset_mapping("mpc"), robot), tells=True))
    assert not telling.keys() & set(PLACE_TERMS)
    assert set(TURN_TERMS) <= telling.keys()


def test_of_a_pid_they_are_all_that_it_commands(robot: Robot) -> None:
    cascade = cascade_from_tables(*preset_mapping("pid"), robot)
    one, more = (told(replace(cascade, tells=True), ticks) for ticks in (1, 40))
    for signals in (one, more):
        wanted = sum(signals[term] for term in PLACE_TERMS) + np.array([0.0, 0.0, robot.description.gravity])
        np.testing.assert_allclose(signals["force_command"], robot.mass * wanted, atol=1e-9)
    assert np.all(np.abs(more[PLACE_TERMS[1]]) > 30.0 * np.abs(one[PLACE_TERMS[1]]))


def test_of_an_attitude_law_they_are_its_torque_but_for_what_is_fed_back(robot: Robot) -> None:
    cascade = cascade_from_tables(*preset_mapping("pid"), robot)
    signals = told(replace(cascade, tells=True))
    measurement, _ = hover(cascade)
    inertia = robot.at(measurement.joint_angles, measurement.vectoring_angles).inertia_C
    wanted = inertia @ sum(signals[term] for term in TURN_TERMS)
    assert np.abs(wanted).max() > 1e-2
    np.testing.assert_allclose(signals["torque_command"], wanted, atol=0.05 * np.abs(wanted).max())
