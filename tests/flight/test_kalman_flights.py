"""Flights whose estimation is the extended Kalman filter: every way to fly it, its replay, its C."""

from __future__ import annotations

import dataclasses
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.errors import ConfigError
from skylimb.base.packing import Layout
from skylimb.control.cascade import Cascade
from skylimb.control.estimation.laws import kalman
from skylimb.control.estimation.records import Imu, Sensed, Start, Wrench
from skylimb.control.missions.reference import zero_reference
from skylimb.control.needs import needs_of
from skylimb.flight.export import export_c
from skylimb.flight.flying import fly, fly_here
from skylimb.flight.takeoff import take_off
from strict_c import StrictC

LAW = {"estimation.law": "kalman"}
WITH_IMU = {**LAW, "estimation.imu.on": True}
ON = {f"controller.{key}": value for key, value in WITH_IMU.items()}
SHORT = {**HOLD, **ON, "sensors.imu.on": True, "stop_at": 1.5}


def controller(changes: dict[str, Any], name: str = "following") -> Cascade:
    made = skylimb.load_controller(name, skylimb.load_robot("hydrus_xi_quad"), changes)
    assert isinstance(made, Cascade)
    return made


class Untraceable:
    """Hides that a controller can be traced, so that the free driver flies it with numbers."""

    def __init__(self, inner: Any) -> None:
        self.name, self.step, self.gains = inner.name, inner.step, inner.gains
        self.initial_state, self.needs = inner.initial_state, needs_of(inner)


def test_all_drivers_fly_the_same() -> None:
    (takeoff,) = take_off("paper", ("following",), set=SHORT)
    compiled, fastest = fly_here(takeoff), fly(takeoff)
    slow = fly_here(dataclasses.replace(takeoff, controller=Untraceable(takeoff.controller)))
    np.testing.assert_array_equal(fastest.signals[: fastest.ticks], compiled.signals[: compiled.ticks])
    for name in ("configuration", "thrusts_command", "external_force_estimate", "gyro_bias_estimate"):
        np.testing.assert_allclose(slow.signal(name), compiled.signal(name), atol=1e-8, err_msg=name)


def test_the_replay_of_a_flight_gives_its_bits() -> None:
    run = skylimb.run("paper", "following", set=SHORT)
    again = skylimb.replay(run)
    for name in ("thrusts_command", "external_force_estimate", "accelerometer_bias_estimate"):
        np.testing.assert_array_equal(again.log[name].values, run.log[name].values, err_msg=name)


@pytest.mark.parametrize(
    "changes",
    [pytest.param(LAW, id="without an IMU", marks=pytest.mark.slow), pytest.param(WITH_IMU, id="with one")],
)
def test_exported_c_passes_its_test_vector(
    changes: dict[str, Any], tmp_path: Path, strict_c: StrictC
) -> None:
    folder = tmp_path / "export"
    export_c(controller(changes), folder)
    sources = ("main.c", "controller.c", "controller_function.c")
    strict_c.link([folder / source for source in sources], tmp_path / "example")
    done = subprocess.run([tmp_path / "example"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert "60 ticks" in done.stdout


def test_the_state_is_known_better_than_it_is_measured() -> None:
    settings = {**HOLD, "sensors.imu.on": True}
    plain, felt = (skylimb.run("paper", "hybrid", set={**settings, **more}) for more in ({}, ON))
    assert felt.status == "OK"
    for name, share in (("cog_position", 0.5), ("cog_velocity", 0.7)):
        off, less = (
            float(np.sqrt(np.mean((run.log[f"{name}_estimate"].values - run.log[name].values) ** 2)))
            for run in (plain, felt)
        )
        assert less < share * off, name


@pytest.mark.parametrize("scale", [0.9, 1.1])
def test_thrust_that_is_off_is_found_and_fed(scale: float) -> None:
    run = skylimb.run(
        "paper", "following", set={**HOLD, "controller.estimation.law": "kalman", "plant.thrust_scale": scale}
    )
    assert run.status == "OK"
    assert float(run.log.thrust_scale_estimate.values[-1]) == pytest.approx(scale, abs=0.02)
    assert np.abs(run.log.cog_position - run.log.cog_position_reference).sel(axis="z").max() < 0.12


def test_nothing_that_is_measured_can_spoil_the_estimate() -> None:
    """Each entry in turn is no number, then too large, while the robot hovers."""
    made = controller(WITH_IMU)
    robot, gains = made.robot, made.gains().estimation
    start = made.initial_state()
    (takeoff,) = take_off("paper", ("following",), set=SHORT)
    flight = fly_here(takeoff)
    names = ("root_position_measured", "root_quaternion_measured", "root_velocity_measured")
    names += ("root_angular_velocity_measured", "joint_angles_measured", "vectoring_angles_measured")
    entries = [flight.signal(name)[10] for name in names]
    felt = Imu(
        *(flight.signal(f"imu_{name}_measured")[10] for name in ("angular_velocity", "specific_force"))
    )
    sizes = Layout(start.estimation)
    reference = zero_reference(robot.n_joints, robot.n_vectoring)

    def step(state: Any, measurement: Any) -> Any:
        state, estimate, _ = kalman.step(gains, state, Sensed(robot, measurement, reference, 0.005))
        weight = np.array([0.0, 0.0, robot.weight])
        return kalman.commanded(gains, state, estimate, Wrench(weight, np.zeros(3)), 0.005)

    from skylimb.control.estimation.records import Measurement

    good = Measurement(*entries, capture_age=0.01, imu=felt)
    settled = start.estimation
    for _ in range(3):
        settled = step(settled, good)
    odd = [
        good._replace(**{name: np.full_like(getattr(good, name), value)})
        for name in good._fields[:6]
        for value in (np.nan, np.inf, -1e12)
    ]
    odd += [good._replace(capture_age=value) for value in (np.nan, np.inf, -1.0, 1e9)]
    odd += [good._replace(imu=Imu(np.full(3, np.nan), felt.specific_force))]
    for measurement in odd:
        state = step(step(settled, measurement), good)
        assert np.isfinite(sizes.pack(state)).all(), measurement
        np.testing.assert_allclose(state.body.position, settled.body.position, atol=0.01)
    assert np.isfinite(
        sizes.pack(step(kalman.initial_state(gains, Start(robot, 1.0, np.zeros(4))), odd[0]))
    ).all()


def test_it_is_refused_where_it_cannot_work() -> None:
    with pytest.raises(ConfigError, match=r"works on what an IMU measures: set sensors\.imu\.on = true"):
        skylimb.run("paper", "following", set={**HOLD, **ON})
    for key, value in (("spread.velocity", 0.0), ("spread.force", -1.0), ("imu.gyro", 1e9)):
        with pytest.raises(ConfigError, match=f"estimation.{key}"):
            controller({**LAW, f"estimation.{key}": value})
    with pytest.raises(ConfigError, match="did you mean 'kalman'"):
        controller({"estimation.law": "kalmann"})
