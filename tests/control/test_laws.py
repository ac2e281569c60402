"""The paper's laws, each alone, on numbers, against the equation it stands for."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.base.errors import SkylimbError
from skylimb.base.packing import numeric
from skylimb.base.rotations import rotation_from_rpy
from skylimb.base.signal_table import PLACE_TERMS, TURN_TERMS
from skylimb.control.allocation.thrusts import allocate
from skylimb.control.attitude.laws import impedance as attitude
from skylimb.control.attitude.target import attitude_target
from skylimb.control.contact.laws import open as open_contact
from skylimb.control.estimation.body_state import rotor_wrench
from skylimb.control.estimation.records import BodyState, Start
from skylimb.control.records import ContactView, LawInput
from skylimb.control.shape.laws import admittance, fixed
from skylimb.control.translation.laws import impedance, pid
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState

G = np.array([0.0, 0.0, 9.80665])
MASS, DT = 4.0, 0.005
HYBRID = impedance.Gains((1.0, 3.0, 1.0), (2.5, 2.5, 1.5), (0.6, 0.6, 0.7))
Make = Callable[..., LawInput]

vec3 = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array)


# ---- translation ----


@given(error=vec3, velocity_error=vec3, reference=vec3, acceleration=vec3, force=vec3)
def test_impedance_closes_to_its_own_dynamics(
    make_inputs: Make, error: Any, velocity_error: Any, reference: Any, acceleration: Any, force: Any
) -> None:
    """Put f_cmd into eq:dynamics: what is left must be eq:impedance control 1, on any reference."""
    gains: Any = numeric(HYBRID)
    at = make_inputs(
        position=reference + error,
        velocity=0.5 * reference + velocity_error,
        force=force,
        reference={"position": reference, "velocity": 0.5 * reference, "acceleration": acceleration},
    )
    _, command, signals = impedance.step(gains, (), at)
    moved = (command + force) / MASS - G
    M_d = MASS * gains.virtual_mass_ratio
    K = M_d * gains.normalized_stiffness
    C = M_d * 2.0 * gains.damping_ratio * np.sqrt(gains.normalized_stiffness)
    np.testing.assert_allclose(
        M_d * (moved - acceleration) + C * velocity_error + K * error, force, atol=1e-9
    )
    told = MASS * sum(signals[term] for term in PLACE_TERMS) * gains.virtual_mass_ratio
    np.testing.assert_allclose(told, -C * velocity_error - K * error, atol=1e-9)


def test_a_ratio_of_one_feeds_nothing_back(make_inputs: Make) -> None:
    _, command, _ = impedance.step(numeric(HYBRID), (), make_inputs(force=np.array([1.0, 1.0, 1.0])))
    np.testing.assert_allclose(command - 4.0 * G, [0.0, -2.0 / 3.0, 0.0], atol=1e-12)


WIDE = (1e3, 1e3, 1e3)
PID = pid.Gains((2.0, 2.5, 3.0), (1.0, 1.5, 2.0), (3.0, 3.5, 4.0), WIDE, WIDE, WIDE, WIDE)


def test_pid_terms_and_limits(make_inputs: Make, make_start: Callable[..., Start]) -> None:
    """Each term by itself, on every axis: proportional, integral, derivative, and what is fed forward."""
    gains: Any = numeric(PID)
    none = pid.initial_state(PID, make_start())
    ask, move = np.array([0.3, -0.2, 0.1]), np.array([-0.1, 0.4, 0.2])
    state, force, signals = pid.step(gains, none, make_inputs(position=-ask))
    np.testing.assert_allclose(state.integral, gains.integral * ask * DT, atol=1e-12)
    np.testing.assert_allclose(
        force, MASS * (gains.proportional * ask + gains.integral * ask * DT + G), atol=1e-12
    )
    _, force, _ = pid.step(gains, none, make_inputs(reference={"position": ask}))
    np.testing.assert_allclose(
        force, MASS * (gains.proportional * ask + gains.integral * ask * DT + G), atol=1e-12
    )
    _, force, _ = pid.step(gains, none, make_inputs(velocity=-move))
    np.testing.assert_allclose(force, MASS * (gains.derivative * move + G), atol=1e-12)
    _, force, _ = pid.step(gains, none, make_inputs(reference={"velocity": move, "acceleration": ask}))
    np.testing.assert_allclose(force, MASS * (gains.derivative * move + ask + G), atol=1e-12)
    _, force, _ = pid.step(gains, pid.State(ask), make_inputs())
    np.testing.assert_allclose(force, MASS * (ask + G), atol=1e-12)
    told = gains.proportional * ask, gains.integral * ask * DT, np.zeros(3)
    np.testing.assert_allclose([signals[term] for term in PLACE_TERMS], told, atol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("name", ["proportional", "integral", "derivative", "sum"])
def test_each_term_of_the_pid_has_its_own_limit(
    make_inputs: Make, make_start: Callable[..., Start], name: str, sign: float
) -> None:
    limits = {f"{name}_limit": (0.3, 0.4, 0.5)}
    gains: Any = numeric(
        pid.Gains(**{**{key: getattr(PID, key) for key in PID.__dataclass_fields__}, **limits})
    )
    far = {"reference": {"position": np.full(3, 50.0 * sign)}}
    if name == "derivative":
        far = {"velocity": np.full(3, -50.0 * sign)}
    state = pid.initial_state(PID, make_start())
    if name == "integral":
        for _ in range(10):
            state, _, _ = pid.step(gains, state, make_inputs(**far))
        np.testing.assert_allclose(state.integral, sign * np.array([0.3, 0.4, 0.5]), atol=1e-12)
        far = {}
    _, force, _ = pid.step(
        gains, pid.State(np.zeros(3)) if name == "proportional" else state, make_inputs(**far)
    )
    accelerated = force / MASS - G
    if name == "proportional":
        accelerated = accelerated - gains.integral * 50.0 * sign * DT
    np.testing.assert_allclose(accelerated, sign * np.array([0.3, 0.4, 0.5]), atol=1e-9)


# ---- attitude ----


@given(
    roll=st.floats(-0.5, 0.5), pitch=st.floats(-0.5, 0.5), yaw=st.floats(-3.0, 3.0), size=st.floats(1.0, 60.0)
)
def test_the_target_attitude_points_the_force(roll: float, pitch: float, yaw: float, size: float) -> None:
    """eq:target roll and pitch angle: at the target, the z axis of C lies along the wanted force."""
    force = size * rotation_from_rpy(roll, pitch, yaw)[:, 2]
    rpy, R = attitude_target(force, yaw, yaw)
    np.testing.assert_allclose(R[:, 2], force / size, atol=1e-9)
    np.testing.assert_allclose(rpy, [roll, pitch, yaw], atol=1e-9)


def test_the_target_tilts_in_the_present_heading_and_turns_to_the_wanted_one() -> None:
    force = rotation_from_rpy(0.1, -0.2, 0.7)[:, 2]
    rpy, R = attitude_target(force, 0.7, -0.4)
    np.testing.assert_allclose(rpy, [0.1, -0.2, -0.4], atol=1e-12)
    np.testing.assert_allclose(R, rotation_from_rpy(0.1, -0.2, -0.4), atol=1e-12)


def test_attitude_closes_to_its_own_dynamics(make_inputs: Make, model: RobotState) -> None:
    """Put tau_cmd into eq:dynamics: what is left must be eq:impedance control 1 (second line)."""
    gains = numeric(attitude.Gains((10.0, 10.0, 5.0), (40.0, 40.0, 10.0), (1.1, 1.1, 0.8)))
    omega, torque = np.array([0.1, -0.2, 0.3]), np.array([0.05, 0.02, -0.03])
    R, target = rotation_from_rpy(0.05, -0.04, 0.1), rotation_from_rpy(-0.2, 0.1, 0.3)
    at = make_inputs(model, R=R, omega=omega, torque=torque)
    _, command, signals = attitude.step(gains, (), at, target)
    inertia = model.inertia_C
    acceleration = np.linalg.solve(inertia, command + torque - np.cross(omega, inertia @ omega))
    off = target.T @ R
    e_R = 0.5 * np.array([off[2, 1] - off[1, 2], off[0, 2] - off[2, 0], off[1, 0] - off[0, 1]])
    spring = (
        gains.normalized_stiffness * e_R
        + 2 * gains.damping_ratio * np.sqrt(gains.normalized_stiffness) * omega
    )
    expected = np.linalg.solve(inertia, torque / gains.virtual_inertia_ratio) - spring
    np.testing.assert_allclose(acceleration, expected, atol=1e-9)
    np.testing.assert_allclose(sum(signals[term] for term in TURN_TERMS), -spring, atol=1e-12)


# ---- shape ----


def test_admittance_follows_its_differential_equation(
    make_inputs: Make, make_start: Callable[..., Start]
) -> None:
    """A step of force against the exact second-order response of eq:admittance control."""
    from scipy.signal import StateSpace, lsim

    gains = admittance.Gains(40.0, 55.0, 16.0)
    state, push, found = admittance.initial_state(gains, make_start()), -1.0, []
    assert state == (1.09, 0.0)
    for _ in range(4000):
        before = state
        state, arm, signals = admittance.step(gains, state, make_inputs(contact_force=push), (0.5, 1.2))
        assert arm == (state.reach, before.rate)
        assert signals == {}
        found.append(arm.reach)
    system = StateSpace([[0, 1], [-16 / 40, -55 / 40]], [[0], [1 / 40]], [[1, 0]], [[0]])
    _, exact, _ = lsim(system, np.full(4000, push), np.arange(4000) * 0.005)
    np.testing.assert_allclose(np.array(found[:-1]) - 1.09, exact[1:], atol=3e-4)
    assert found[-1] - 1.09 == pytest.approx(push / 16.0, rel=0.01)


def test_one_tick_of_the_admittance_in_numbers(make_inputs: Make) -> None:
    gains, before = admittance.Gains(2.0, 3.0, 5.0, force_reference=-0.4), admittance.State(1.0, 0.1)
    at = make_inputs(contact_force=-1.4, reference={"reach": 1.2})
    state, arm, _ = admittance.step(gains, before, at, (0.5, 1.5))
    rate = 0.1 + DT * (-1.4 + 0.4 + 5.0 * (1.2 - 1.0) - 3.0 * 0.1) / 2.0
    assert state.rate == pytest.approx(rate, abs=1e-15)
    assert arm.reach == state.reach == pytest.approx(1.0 + rate * DT, abs=1e-15)
    free = make_inputs(contact_force=-1.4, reference={"reach": 1.2, "adapt": 0.0})
    state, _, _ = admittance.step(gains, before, free, (0.5, 1.5))
    assert state.rate == pytest.approx(0.1 + DT * (5.0 * 0.2 - 0.3) / 2.0, abs=1e-15)


@pytest.mark.parametrize(("push", "limit"), [(-5.0, 0.95), (5.0, 1.15)])
def test_admittance_leaves_its_limit_as_soon_as_the_force_turns(
    make_inputs: Make, push: float, limit: float
) -> None:
    gains, state = admittance.Gains(40.0, 55.0, 16.0), admittance.State(1.0, 0.0)
    for _ in range(3000):
        state, _, _ = admittance.step(gains, state, make_inputs(contact_force=push), (0.95, 1.15))
    assert state == (limit, 0.0)
    state, arm, _ = admittance.step(gains, state, make_inputs(contact_force=-push), (0.95, 1.15))
    assert 0.95 < arm.reach < 1.15


def test_a_stiff_arm_keeps_the_references_reach(make_inputs: Make, make_start: Callable[..., Start]) -> None:
    gains = fixed.Gains()
    state, arm, signals = fixed.step(
        gains, fixed.initial_state(gains, make_start()), make_inputs(reference={"reach": 1.02}), (0.5, 1.2)
    )
    assert (state, arm, signals) == ((), (1.02, 0.0), {})


def test_the_papers_controllers_judge_no_contact(make_inputs: Make, make_start: Callable[..., Start]) -> None:
    gains = open_contact.Gains()
    assert open_contact.step(gains, open_contact.initial_state(gains, make_start()), make_inputs()) == (
        (),
        ContactView(),
        {},
    )
    assert set(ContactView()) == {None}


# ---- thrusts ----


def turned(model: RobotState, R: np.ndarray) -> BodyState:
    return BodyState(np.zeros(3), np.zeros(3), R, np.zeros(3), model)


@given(force=vec3, torque=vec3)
def test_allocation_gives_the_wanted_lift_and_torque(model: RobotState, force: Any, torque: Any) -> None:
    R = rotation_from_rpy(0.05, 0.1, 0.4)
    wanted = 4.1 * G + force
    thrusts = allocate(turned(model, R), wanted, 0.2 * torque, (np.zeros(4), np.full(4, 30.0)))
    made = rotor_wrench(turned(model, R), thrusts.total)
    np.testing.assert_allclose(made.torque, 0.2 * torque, atol=1e-9)
    np.testing.assert_allclose(made.force, R @ (model.allocation_C @ thrusts.total)[:3], atol=1e-9)
    lift = model.allocation_C @ (thrusts.total - thrusts.rotation)
    np.testing.assert_allclose(lift[2], R[:, 2] @ wanted, atol=1e-9)
    np.testing.assert_allclose(lift[3:], 0.0, atol=1e-9)
    np.testing.assert_allclose(
        thrusts.rotation, np.linalg.pinv(model.allocation_C[3:]) @ (0.2 * torque), atol=1e-9
    )


@given(torque=vec3)
def test_thrusts_that_hold_the_lift_turn_without_lifting(model: RobotState, torque: Any) -> None:
    limits = np.zeros(4), np.full(4, 30.0)
    thrusts = allocate(turned(model, np.eye(3)), 4.1 * G, 0.2 * torque, limits, hold_lift=True)
    made = model.allocation_C @ thrusts.rotation
    np.testing.assert_allclose(made[2:], [0.0, *(0.2 * torque)], atol=1e-9)


def test_allocation_keeps_within_the_limits(model: RobotState) -> None:
    low, high = np.array([0.0, 1.0, 2.0, 3.0]), np.array([20.0, 21.0, 22.0, 23.0])
    for lift, expected in ((1e3, high), (-1e3, low)):
        thrusts = allocate(turned(model, np.eye(3)), lift * G, np.zeros(3), (low, high))
        np.testing.assert_array_equal(thrusts.total, expected)


def test_the_limits_are_those_of_the_rotors(robot: Robot) -> None:
    low, high = robot.thrust_limits()
    rotors = robot.description.rotors
    assert low.tolist() == [rotor.thrust_min for rotor in rotors]
    assert high.tolist() == [rotor.thrust_max for rotor in rotors]
    assert (low < high).all()


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: impedance.Gains((0.0, 1, 1), (1, 1, 1), (1, 1, 1)), "virtual_mass_ratio"),
        (lambda: admittance.Gains(-1.0, 1.0, 1.0), "mass"),
        (lambda: attitude.Gains((1, 1, 1), (1, 1, -1), (1, 1, 1)), "normalized_stiffness"),
    ],
)
def test_gains_that_cannot_be_are_refused(make: Any, name: str) -> None:
    with pytest.raises(SkylimbError, match=name):
        make()
