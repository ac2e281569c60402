"""The centre of gravity's state against differences of the model's own geometry."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.base.rotations import quaternion_from_rotation, rotation_from_axis_angle, rotation_from_rpy
from skylimb.control.estimation.body_state import (
    AngleRateFilter,
    angle_rates,
    body_state,
    initial_angle_rate_state,
    rotor_wrench,
    see_body,
    seen_from,
)
from skylimb.control.estimation.records import BodyState, Measurement, Sensed
from skylimb.control.missions.reference import zero_reference
from skylimb.robots.model import Robot

DT = 0.005
Q = np.array([1.0, 0.9, -0.4])
PSI = np.array([3.0, 0.1, 3.1, 0.2])
RATES = np.array([0.3, -0.4, 0.2, 1.0, -0.5, 0.7, 0.4])
SPIN = np.array([0.4, -0.3, 0.6])
R0 = rotation_from_rpy(0.1, -0.2, 0.7)


@pytest.fixture(scope="module")
def robot() -> Robot:
    return skylimb.load_robot("hydrus_xi_quad")


def flat(value: Any) -> np.ndarray:
    return np.asarray(value, dtype=float).ravel()


def moving(t: float) -> Measurement:
    """A measured body that flies and turns while joints and rotors turn, exactly, at the time t in s."""
    size = float(np.linalg.norm(SPIN))
    R = R0 @ rotation_from_axis_angle((SPIN / size).tolist(), size * t)
    velocity = np.array([0.5, -0.2, 0.1])
    return Measurement(
        np.array([1.0, 2.0, 3.0]) + velocity * t,
        quaternion_from_rotation(R),
        velocity,
        SPIN,
        Q + RATES[:3] * t,
        PSI + RATES[3:] * t,
    )


def seen(robot: Robot, t: float) -> BodyState:
    return body_state(robot, moving(t), RATES)


def test_the_velocity_is_the_derivative_of_the_position(robot: Robot) -> None:
    step = 1e-5
    derivative = (flat(seen(robot, step).position) - flat(seen(robot, -step).position)) / (2 * step)
    np.testing.assert_allclose(flat(seen(robot, 0.0).velocity), derivative, atol=1e-8)
    still = body_state(robot, moving(0.0), np.zeros(7))
    assert np.abs(flat(still.velocity) - derivative).max() > 0.01


def test_place_attitude_and_turning_are_those_of_the_hovering_frame(robot: Robot) -> None:
    model, found = robot.at(Q, PSI), seen(robot, 0.0)
    place = np.array([1.0, 2.0, 3.0]) + R0 @ model.cog_root
    np.testing.assert_allclose(flat(found.position), place, atol=1e-9)
    np.testing.assert_allclose(np.asarray(found.R_WC, dtype=float), R0 @ model.R_root_C, atol=1e-9)
    np.testing.assert_allclose(flat(found.angular_velocity), model.R_root_C.T @ SPIN, atol=1e-9)
    assert float(found.model.mass) == pytest.approx(robot.mass)


# ---- angle rates ----


def test_the_first_tick_has_no_rate() -> None:
    made: Any = SimpleNamespace(n_joints=1, n_vectoring=1)
    state, rates = angle_rates(AngleRateFilter(), initial_angle_rate_state(made), np.array([1.0, -2.0]), DT)
    np.testing.assert_array_equal(rates, 0.0)
    np.testing.assert_allclose(state.smoothed, [1.0, -2.0])
    assert state.started == 1.0


@pytest.mark.parametrize("bandwidth", [10.0, 30.0])
def test_a_steady_turn_is_seen_behind_a_first_order_lag(bandwidth: float) -> None:
    made: Any = SimpleNamespace(n_joints=1, n_vectoring=1)
    gains, state, slope = AngleRateFilter(bandwidth), initial_angle_rate_state(made), np.array([0.5, -1.5])
    for k in range(41):
        state, rates = angle_rates(gains, state, 3.0 + slope * k * DT, DT)
        np.testing.assert_allclose(rates, slope * (1.0 - np.exp(-bandwidth * DT * k)), atol=1e-12)


def test_there_is_a_state_for_every_angle(robot: Robot) -> None:
    state = initial_angle_rate_state(robot)
    assert (state.smoothed.shape, state.started) == ((7,), 0.0)
    assert not state.smoothed.any()


def test_a_measurement_becomes_the_bodys_state(robot: Robot) -> None:
    gains, state = AngleRateFilter(40.0), initial_angle_rate_state(robot)

    for k in range(3):
        measurement = moving(k * DT)
        before = state
        state, body = see_body(gains, before, Sensed(robot, measurement, zero_reference(3, 4), DT))
        angles = np.concatenate([measurement.joint_angles, measurement.vectoring_angles])
        wanted, rates = angle_rates(gains, before, angles, DT)
        np.testing.assert_array_equal(state.smoothed, wanted.smoothed)
        velocity = body_state(robot, measurement, rates).velocity
        np.testing.assert_array_equal(flat(body.velocity), flat(velocity))


def test_in_other_axes_it_is_the_same_body(robot: Robot) -> None:
    body, thrusts = seen(robot, 0.0), np.array([8.0, 9.0, 10.0, 11.0])
    other = seen_from(body, rotation_from_rpy(0.3, -0.5, 0.2))
    axes, model = other.model.R_root_C, body.model
    np.testing.assert_allclose(other.R_WC @ axes.T, body.R_WC @ model.R_root_C.T, atol=1e-12)
    np.testing.assert_allclose(
        other.R_WC @ other.angular_velocity, body.R_WC @ body.angular_velocity, atol=1e-12
    )
    np.testing.assert_allclose(other.R_WC @ other.model.tip_C, body.R_WC @ model.tip_C, atol=1e-12)
    torques = [b.R_WC @ rotor_wrench(b, thrusts).torque for b in (other, body)]
    np.testing.assert_allclose(*torques, atol=1e-12)
    np.testing.assert_allclose(
        rotor_wrench(other, thrusts).force, rotor_wrench(body, thrusts).force, atol=1e-12
    )
    inertia = [b.R_WC @ b.model.inertia_C @ b.R_WC.T for b in (other, body)]
    np.testing.assert_allclose(*inertia, atol=1e-12)
