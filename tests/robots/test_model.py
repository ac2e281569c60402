"""Mass properties and kinematics against Pinocchio, and what any robot state must satisfy."""

from dataclasses import replace
from importlib import import_module
from typing import Any

import casadi as ca
import numpy as np
import pytest

from skylimb.base.errors import AllocationError, ConfigError
from skylimb.robots import GRAVITY, Robot, RobotState, load_robot

# Pinocchio fills its module at run time, where a type checker cannot look.
pin: Any = import_module("pinocchio")
ROBOT = load_robot("hydrus_xi_quad")
NAMES = [*ROBOT.description.shape_joints, *ROBOT.description.vectoring_joints]


class Oracle:
    """The same URDF in Pinocchio, with a free base."""

    def __init__(self):
        path = ROBOT.description.folder / "hydrus_xi_quad.urdf"
        self.model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
        self.data = self.model.createData()

    def configuration(self, q, psi, base=None):
        x = pin.neutral(self.model)
        if base is not None:
            x[:7] = pin.SE3ToXYZQUAT(base)
        for name, angle in zip(NAMES, [*q, *psi], strict=True):
            joint = self.model.joints[self.model.getJointId(name)]
            x[joint.idx_q : joint.idx_q + joint.nq] = (
                [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            )
        return x

    def frame(self, x, name):
        pin.framesForwardKinematics(self.model, self.data, x)
        pose = self.data.oMf[self.model.getFrameId(name)]
        return pose.translation.copy(), pose.rotation.copy()


@pytest.fixture(scope="module")
def oracle():
    return Oracle()


def draws(n, seed=1):
    rng = np.random.default_rng(seed)
    return [(rng.uniform(-1.57, 1.57, 3), rng.uniform(-np.pi, np.pi, 4)) for _ in range(n)]


def test_mass_is_the_published_one_plus_the_pen(oracle):
    assert ROBOT.mass == pytest.approx(4.0907 + 0.030, abs=1e-4)
    assert ROBOT.mass == pytest.approx(pin.computeTotalMass(oracle.model), abs=1e-12)
    assert ROBOT.description.mass == pytest.approx(ROBOT.mass, abs=1e-12)


def test_mass_cog_and_inertia_equal_pinocchios(oracle):
    for q, psi in draws(100):
        state, x = ROBOT.at(q, psi), oracle.configuration(q, psi)
        cog = pin.centerOfMass(oracle.model, oracle.data, x)
        pin.ccrba(oracle.model, oracle.data, x, np.zeros(oracle.model.nv))
        inertia = state.R_root_C.T @ oracle.data.Ig.inertia @ state.R_root_C
        assert state.mass == pytest.approx(oracle.data.mass[0], abs=1e-9)
        np.testing.assert_allclose(state.cog_root, cog, atol=1e-9)
        np.testing.assert_allclose(state.inertia_C, inertia, atol=1e-9)


def test_frames_of_all_links_equal_pinocchios(oracle):
    for q, psi in draws(10, seed=2):
        x = oracle.configuration(q, psi)
        for name, (position, R) in ROBOT.link_poses(q, psi).items():
            expected_position, expected_R = oracle.frame(x, name)
            np.testing.assert_allclose(position, expected_position, atol=1e-12)
            np.testing.assert_allclose(R, expected_R, atol=1e-12)


def test_allocation_matrix_does_the_work_of_thrusts_on_a_moved_body(oracle):
    """Move the body by a small twist about its centre of gravity: thrust and drag do the work Q predicts."""
    step = 1e-6
    for q, psi in draws(20, seed=3):
        state = ROBOT.at(q, psi)
        to_C = pin.SE3(state.R_root_C, state.cog_root)
        expected = np.zeros((6, ROBOT.n_rotors))
        for row in range(6):
            frames = {}
            for sign in (1, -1):
                twist = np.zeros(6)
                twist[row] = sign * step
                base = to_C * pin.exp6(twist) * to_C.inverse()
                x = oracle.configuration(q, psi, base)
                frames[sign] = [oracle.frame(x, rotor.link) for rotor in ROBOT.description.rotors]
            at_rest = oracle.configuration(q, psi)
            for i, rotor in enumerate(ROBOT.description.rotors):
                axis = oracle.frame(at_rest, rotor.link)[1][:, 2]
                (p_plus, R_plus), (p_minus, R_minus) = frames[1][i], frames[-1][i]
                moved, turned = (p_plus - p_minus) / (2 * step), pin.log3(R_plus @ R_minus.T) / (2 * step)
                # A rotor that spins about +z drags the body about -z.
                expected[row, i] = axis @ moved - rotor.spin * 0.0182 * (axis @ turned)
        np.testing.assert_allclose(state.allocation_C, expected, atol=1e-8)


def test_hovering_frame_carries_the_weight_along_z_without_torque():
    for q, psi in draws(50, seed=4):
        state = ROBOT.at(q, psi)
        wrench = state.allocation_C @ state.hover_thrusts
        np.testing.assert_allclose(wrench, [0, 0, ROBOT.mass * GRAVITY, 0, 0, 0], atol=1e-8)
        np.testing.assert_allclose(state.R_root_C.T @ state.R_root_C, np.eye(3), atol=1e-12)
        assert np.linalg.det(state.R_root_C) == pytest.approx(1.0)
        assert state.R_root_C[1, 0] == 0.0  # no yaw
        assert state.R_root_C[2, 2] > 0.0 or state.R_root_C[0, 0] < 0.0


def test_tip_in_both_frames_and_its_heading(oracle):
    for q, psi in draws(20, seed=5):
        state = ROBOT.at(q, psi)
        np.testing.assert_allclose(state.cog_root + state.R_root_C @ state.tip_C, state.tip_root, atol=1e-12)
        position, R = oracle.frame(oracle.configuration(q, psi), "link4")
        np.testing.assert_allclose(state.tip_root, position + 0.65 * R[:, 0], atol=1e-12)
        assert state.tip_heading == pytest.approx(np.sum(q), abs=1e-12)
        assert np.cos(state.tip_heading - np.arctan2(R[1, 0], R[0, 0])) == pytest.approx(1.0, abs=1e-12)


def test_jacobians_match_finite_differences():
    step = 1e-6
    for q, psi in draws(10, seed=6):
        state, angles = ROBOT.at(q, psi), np.concatenate([q, psi])
        for column in range(7):
            plus, minus = angles.copy(), angles.copy()
            plus[column] += step
            minus[column] -= step
            ahead, behind = ROBOT.at(plus[:3], plus[3:]), ROBOT.at(minus[:3], minus[3:])
            slope = (ahead.cog_root - behind.cog_root) / (2 * step)
            np.testing.assert_allclose(state.cog_jacobian[:, column], slope, atol=1e-6)
            if column < 3:
                slope = (ahead.tip_root - behind.tip_root) / (2 * step)
                np.testing.assert_allclose(state.tip_jacobian[:, column], slope, atol=1e-6)


@pytest.mark.parametrize("entry", ["inertia_C", "allocation_C", "R_root_C", "hover_thrusts", "tip_C"])
def test_symbolic_derivatives_match_finite_differences(entry):
    q, psi = ca.SX.sym("q", 3), ca.SX.sym("psi", 4)
    angles = ca.vertcat(q, psi)
    derivative = ca.Function(
        "d", [q, psi], [ca.jacobian(ca.vec(getattr(ROBOT.model(q, psi), entry)), angles)]
    )
    table = [([np.pi / 2 - t, 2 * t, -t], [-0.61, -3.09, 0.19, -0.59]) for t in (0.3, 0.5236, 0.75)]
    for joints, vectoring in table:
        exact, at, step = derivative(joints, vectoring).full(), np.array([*joints, *vectoring]), 1e-5

        def flat(x):
            value = getattr(ROBOT.at(x[:3], x[3:]), entry)
            return np.ravel(value, order="F")

        for column in range(7):
            move = step * np.eye(7)[column]
            slope = (
                8 * (flat(at + move) - flat(at - move)) - (flat(at + 2 * move) - flat(at - 2 * move))
            ) / (12 * step)
            np.testing.assert_allclose(exact[:, column], slope, rtol=1e-6, atol=1e-6)


def test_expressions_equal_numbers_for_sx_and_mx():
    (q, psi), fields = draws(1, seed=7)[0], RobotState._fields
    expected = ROBOT.at(q, psi)
    kinds: list[Any] = [ca.SX, ca.MX]
    for kind in kinds:
        a, b = kind.sym("a", 3), kind.sym("b", 4)
        outputs = ca.Function("f", [a, b], [entry + 0 * a[0] for entry in ROBOT.model(a, b)])(q, psi)
        for name, value in zip(fields, outputs, strict=True):
            got = np.array(value.full()).reshape(np.shape(getattr(expected, name)))
            np.testing.assert_array_equal(got, getattr(expected, name), err_msg=name)


def test_the_tick_stays_small():
    q, psi = ca.SX.sym("q", 3), ca.SX.sym("psi", 4)
    model = ROBOT.model(q, psi)
    parts = [model.cog_root, model.R_root_C, model.inertia_C, model.allocation_C, model.tip_C]
    assert ca.Function("parts", [q, psi], parts).n_instructions() <= 1000


def test_facts_of_the_nominal_posture():
    """Hover thrusts and conditioning at pi/6 on the branch of the vectoring table."""
    state = ROBOT.at([np.pi / 3, np.pi / 3, -np.pi / 6], [-0.6126, -3.0885, 0.1940, -0.5911])
    np.testing.assert_allclose(state.hover_thrusts, [8.8, 13.2, 10.6, 10.5], atol=0.1)
    assert np.linalg.cond(state.allocation_C[3:]) == pytest.approx(6.0, abs=0.3)
    assert np.hypot(*state.R_root_C[:2, 2]) < 1e-3


def test_thrust_directions_have_the_fixed_tilt():
    for q, psi in draws(5, seed=8):
        state = ROBOT.at(q, psi)
        in_root = state.R_root_C @ state.allocation_C[:3]
        np.testing.assert_allclose(in_root[2], np.cos(0.34906585), atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(in_root, axis=0), 1.0, atol=1e-12)


def test_skeleton_runs_from_the_root_to_the_tip():
    q, psi = draws(1, seed=9)[0]
    points = ROBOT.skeleton(q, psi)
    assert points.shape == (5, 3)
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=0), axis=1), [0.6, 0.6, 0.6, 0.65])
    np.testing.assert_allclose(points[0], 0.0)
    np.testing.assert_allclose(points[-1], ROBOT.at(q, psi).tip_root, atol=1e-12)


@pytest.mark.parametrize(
    ("q", "psi", "message"),
    [
        ([0.1, 0.2], [0, 0, 0, 0], "must be 3 finite numbers"),
        ([0.1, 0.2, 0.3], [0, 0, 0], "must be 4 finite numbers"),
        ([0.1, 0.2, np.nan], [0, 0, 0, 0], "must be 3 finite numbers"),
        (["a", 0.2, 0.3], [0, 0, 0, 0], "must be 3 numbers"),
    ],
)
def test_wrong_angles_are_refused(q, psi, message):
    with pytest.raises(ConfigError, match=message):
        ROBOT.at(q, psi)


def test_a_singular_allocation_is_named():
    one = ROBOT.description.rotors[0]
    alike = Robot(replace(ROBOT.description, rotors=(one,) * 4))
    with pytest.raises(
        AllocationError, match=r"allocation matrix of 'hydrus_xi_quad' is singular .* \[0.1, 0.2, 0.3\]"
    ):
        alike.at([0.1, 0.2, 0.3], [0, 0, 0, 0])


def test_six_rotors_hover_with_the_least_thrust_and_along_z():
    rotors = ROBOT.description.rotors
    extra = tuple(replace(rotors[k], name=f"extra{k}", xyz=np.array([0.1, 0.2, 0.02])) for k in (0, 3))
    six = Robot(replace(ROBOT.description, rotors=(*rotors, *extra)))
    for q, psi in draws(10, seed=10):
        state = six.at(q, psi)
        wrench = state.allocation_C @ state.hover_thrusts
        weight = ROBOT.mass * GRAVITY
        np.testing.assert_allclose(wrench[2:], [weight, 0, 0, 0], atol=1e-7)
        np.testing.assert_allclose(wrench[:2], 0.0, atol=0.01 * weight)
        least = np.linalg.pinv(state.allocation_C[2:]) @ [weight, 0, 0, 0]
        np.testing.assert_allclose(state.hover_thrusts, least, atol=1e-7)


def test_a_robot_says_what_it_is():
    assert isinstance(ROBOT, Robot)
    assert repr(ROBOT) == "Robot('hydrus_xi_quad', 4.1206 kg, 3 joints, 4 rotors)"
