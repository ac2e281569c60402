"""Each law alone, on numbers, against the equation it stands for."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skylimb
from skylimb.control.attitude import impedance as attitude
from skylimb.control.attitude_target import attitude_target
from skylimb.control.records import LawInput
from skylimb.control.shape import admittance
from skylimb.control.thrusts import allocate, rotor_wrench
from skylimb.control.translation import impedance, pid
from skylimb.errors import SkylimbError
from skylimb.estimation.records import BodyState, Estimate, Start, Wrench
from skylimb.missions.reference import zero_reference
from skylimb.packing import numeric
from skylimb.planning.vectoring import vectoring_table
from skylimb.robots.model import RobotState
from skylimb.spatial import rotation_from_rpy

G = np.array([0.0, 0.0, 9.80665])
HYBRID = impedance.Gains((1.0, 3.0, 1.0), (2.5, 2.5, 1.5), (0.6, 0.6, 0.7))


@pytest.fixture(scope="module")
def model() -> RobotState:
    robot = skylimb.load_robot("hydrus_xi_quad")
    return robot.at([np.pi / 3, np.pi / 3, -np.pi / 6], vectoring_table(robot).angles(np.pi / 6))


def inputs(model: Any, **changes: Any) -> LawInput:
    z3 = np.zeros(3)
    values = {
        "position": z3,
        "velocity": z3,
        "R": np.eye(3),
        "omega": z3,
        "force": z3,
        "torque": z3,
        "contact": 0.0,
    }
    values |= changes
    body = BodyState(values["position"], values["velocity"], values["R"], values["omega"], model)
    reference = zero_reference(3, 4)._replace(
        reach=1.09, contact_axis=np.array([1.0, 0, 0]), align=1.0, adapt=1.0
    )
    wrench = Wrench(values["force"], values["torque"])
    estimate = Estimate(body, wrench, wrench, values["contact"], z3, Wrench(z3, z3))
    nobody: Any = None
    return LawInput(nobody, nobody, reference, 0.005, estimate)


def start(reach: float = 1.09) -> Start:
    nobody: Any = None
    return Start(nobody, reach, np.zeros(4))


vec3 = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array)


@given(position=vec3, velocity=vec3, force=vec3)
def test_impedance_closes_to_its_own_dynamics(position: Any, velocity: Any, force: Any) -> None:
    """Put f_cmd into eq:dynamics: what is left must be eq:impedance control 1."""
    m = SimpleNamespace(mass=4.12)
    gains = numeric(HYBRID)
    _, command, _ = impedance.step(gains, (), inputs(m, position=position, velocity=velocity, force=force))
    acceleration = (command + force) / m.mass - G
    M_d = m.mass * gains.virtual_mass_ratio
    K = M_d * gains.normalized_stiffness
    C = M_d * 2.0 * gains.damping_ratio * np.sqrt(gains.normalized_stiffness)
    np.testing.assert_allclose(M_d * acceleration + C * velocity + K * position, force, atol=1e-9)


def test_a_ratio_of_one_feeds_nothing_back() -> None:
    m = SimpleNamespace(mass=4.0)
    _, command, _ = impedance.step(numeric(HYBRID), (), inputs(m, force=np.array([1.0, 1.0, 1.0])))
    np.testing.assert_allclose(command - 4.0 * G, [0.0, -2.0 / 3.0, 0.0], atol=1e-12)


def test_pid_terms_and_limits() -> None:
    ones, low, high = (1.0, 1.0, 1.0), (0.1, 0.1, 0.1), (1.5, 1.5, 1.5)
    gains = numeric(pid.Gains((2.0, 2.0, 2.0), ones, (3.0, 3.0, 3.0), ones, low, ones, high))
    m = SimpleNamespace(mass=2.0)
    state = pid.initial_state(gains, start())
    _, command, _ = pid.step(gains, state, inputs(m, position=np.array([-0.1, 0.0, 0.0])))
    np.testing.assert_allclose(command, 2.0 * (np.array([0.2 + 0.0005, 0, 0]) + G), atol=1e-12)
    for _ in range(1000):
        state, command, _ = pid.step(gains, state, inputs(m, position=np.array([-10.0, 0.0, 0.0])))
    assert state.integral[0] == pytest.approx(0.1)
    np.testing.assert_allclose(command, 2.0 * (np.array([1.1, 0, 0]) + G), atol=1e-12)


@given(
    roll=st.floats(-0.5, 0.5), pitch=st.floats(-0.5, 0.5), yaw=st.floats(-3.0, 3.0), size=st.floats(1.0, 60.0)
)
def test_the_target_attitude_points_the_force(roll: float, pitch: float, yaw: float, size: float) -> None:
    """eq:target roll and pitch angle: at the target, the z axis of C lies along the wanted force."""
    force = size * rotation_from_rpy(roll, pitch, yaw)[:, 2]
    rpy, R = attitude_target(force, yaw, yaw)
    np.testing.assert_allclose(R[:, 2], force / size, atol=1e-9)
    np.testing.assert_allclose(rpy, [roll, pitch, yaw], atol=1e-9)


def test_attitude_closes_to_its_own_dynamics(model: RobotState) -> None:
    """Put tau_cmd into eq:dynamics: what is left must be eq:impedance control 1 (second line)."""
    gains = numeric(attitude.Gains((10.0, 10.0, 5.0), (40.0, 40.0, 10.0), (1.1, 1.1, 0.8)))
    omega, torque = np.array([0.1, -0.2, 0.3]), np.array([0.05, 0.02, -0.03])
    R = rotation_from_rpy(0.05, -0.04, 0.1)
    at = inputs(model, R=R, omega=omega, torque=torque)
    _, command, _ = attitude.step(gains, (), at, np.eye(3))
    inertia = model.inertia_C
    acceleration = np.linalg.solve(inertia, command + torque - np.cross(omega, inertia @ omega))
    e_R = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    spring = (
        gains.normalized_stiffness * e_R
        + 2 * gains.damping_ratio * np.sqrt(gains.normalized_stiffness) * omega
    )
    expected = np.linalg.solve(inertia, torque / gains.virtual_inertia_ratio) - spring
    np.testing.assert_allclose(acceleration, expected, atol=1e-9)


def test_admittance_follows_its_differential_equation(model: RobotState) -> None:
    """A step of force against the exact second-order response of eq:admittance control."""
    from scipy.signal import StateSpace, lsim

    gains = admittance.Gains(40.0, 55.0, 16.0)
    state, push, found = admittance.initial_state(gains, start()), -1.0, []
    for _ in range(4000):
        state, arm, _ = admittance.step(gains, state, inputs(model, contact=push), (0.5, 1.2))
        found.append(arm.reach)
    system = StateSpace([[0, 1], [-16 / 40, -55 / 40]], [[0], [1 / 40]], [[1, 0]], [[0]])
    _, exact, _ = lsim(system, np.full(4000, push), np.arange(4000) * 0.005)
    np.testing.assert_allclose(np.array(found[:-1]) - 1.09, exact[1:], atol=3e-4)
    assert found[-1] - 1.09 == pytest.approx(push / 16.0, rel=0.01)


def test_admittance_leaves_its_limit_as_soon_as_the_force_turns(model: RobotState) -> None:
    gains, state = admittance.Gains(40.0, 55.0, 16.0), admittance.State(1.0, 0.0)
    for _ in range(3000):
        state, _, _ = admittance.step(gains, state, inputs(model, contact=-5.0), (0.95, 1.15))
    assert state == (0.95, 0.0)
    state, arm, _ = admittance.step(gains, state, inputs(model, contact=5.0), (0.95, 1.15))
    assert arm.reach > 0.95


@given(force=vec3, torque=vec3)
def test_allocation_gives_the_wanted_lift_and_torque(force: Any, torque: Any) -> None:
    robot = skylimb.load_robot("hydrus_xi_quad")
    model = robot.at([np.pi / 3, np.pi / 3, -np.pi / 6], vectoring_table(robot).angles(np.pi / 6))
    R = rotation_from_rpy(0.05, 0.1, 0.4)
    wanted = 4.1 * G + force
    body = BodyState(np.zeros(3), np.zeros(3), R, np.zeros(3), model)
    thrusts = allocate(body, wanted, 0.2 * torque, (np.zeros(4), np.full(4, 30.0)))
    np.testing.assert_allclose(rotor_wrench(body, thrusts.total).torque, 0.2 * torque, atol=1e-9)
    np.testing.assert_allclose(
        (model.allocation_C @ (thrusts.total - thrusts.rotation))[2], R[:, 2] @ wanted, atol=1e-9
    )
    np.testing.assert_allclose(
        thrusts.rotation, np.linalg.pinv(model.allocation_C[3:]) @ (0.2 * torque), atol=1e-9
    )


def test_allocation_keeps_within_the_limits(model: RobotState) -> None:
    body = BodyState(np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3), model)
    thrusts = allocate(body, 10.0 * 4.1 * G, np.ones(3), (np.ones(4), np.full(4, 30.0)))
    assert thrusts.total.min() >= 1.0
    assert thrusts.total.max() <= 30.0


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
