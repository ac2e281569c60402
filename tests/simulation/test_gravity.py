"""One gravity: the experiment's, in the plant, in the controller's model and in what a calibration knows."""

from dataclasses import replace

import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.flight.takeoff import take_off
from skylimb.studies.calibration.result import true_values


def test_plant_and_model_have_the_gravity_of_the_experiment() -> None:
    (takeoff,) = take_off("free_flight", ("hybrid",), set={"gravity": 9.78})
    assert takeoff.plant.model.opt.gravity.tolist() == [0.0, 0.0, -9.78]
    assert takeoff.robot.weight == pytest.approx(9.78 * takeoff.robot.mass, rel=1e-15)
    q, psi = takeoff.robot.nominal_posture(), takeoff.robot.description.vectoring_start
    state = takeoff.robot.at(q, psi)
    assert state.gravity.tolist() == [0.0, 0.0, 9.78]
    assert state.hover_thrusts.sum() == pytest.approx(
        9.78 / 9.80665 * skylimb.load_robot("hydrus_xi_quad").at(q, psi).hover_thrusts.sum(), rel=1e-12
    )


@pytest.mark.parametrize("gravity", [9.78, 9.83])
def test_the_estimated_force_of_a_hover_does_not_depend_on_the_place(gravity: float) -> None:
    run = skylimb.run("free_flight", controller="hybrid", set={"gravity": gravity, "stop_at": 3.0})
    lift = run.log.external_force_estimate.sel(axis="z").values[200:]
    assert np.abs(np.median(lift)) < 0.02  # N; 0.03 m/s^2 on 4 kg would make 0.12


def test_a_calibration_is_held_against_the_gravity_that_was_flown_with() -> None:
    run = skylimb.run("free_flight", controller="hybrid", set={"gravity": 9.79, "stop_at": 0.5})
    known = true_values(run, skylimb.load_robot("hydrus_xi_quad"))
    assert known is not None
    assert known[-1] == 9.79


def test_a_flight_that_says_no_gravity_had_that_of_its_robot() -> None:
    run = skylimb.run("free_flight", controller="hybrid", set={"stop_at": 0.5})
    robot = skylimb.load_robot("hydrus_xi_quad")
    config = "".join(line for line in run.config.splitlines(True) if not line.startswith("gravity"))
    silent = replace(run, log=run.log.assign_attrs(config=config))
    known = true_values(silent, robot)
    assert "gravity" in run.tables
    assert "gravity" not in silent.tables
    assert known is not None
    assert known[-1] == robot.description.gravity


def test_gravity_of_another_planet_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"gravity = 1\.62"):
        take_off("free_flight", ("hybrid",), set={"gravity": 1.62})
