import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from skylimb.base import rotations as spatial

angle = st.floats(-1.4, 1.4)
unit = st.floats(-1.0, 1.0)


@given(angle, angle, angle)
def test_rpy_is_the_inverse_of_its_rotation(roll: float, pitch: float, yaw: float) -> None:
    R = spatial.rotation_from_rpy(roll, pitch, yaw)
    np.testing.assert_allclose(R, Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(spatial.rpy_from_rotation(R), [roll, pitch, yaw], atol=1e-9)


@given(st.tuples(unit, unit, unit), st.tuples(unit, unit, unit))
def test_hat_is_the_cross_product(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    expected = np.cross(a, b)
    np.testing.assert_allclose(spatial.hat(np.array(a)) @ np.array(b), expected, atol=1e-12)
    np.testing.assert_allclose(spatial.vee(spatial.hat(np.array(a))), a, atol=0)


def test_quaternions_agree_with_scipy() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        a, b = (rng.standard_normal(4) for _ in range(2))
        a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
        A, B = (Rotation.from_quat(q[[1, 2, 3, 0]]) for q in (a, b))
        np.testing.assert_allclose(spatial.rotation_from_quaternion(a), A.as_matrix(), atol=1e-12)
        product = spatial.quaternion_product(a, b)
        np.testing.assert_allclose(spatial.rotation_from_quaternion(product), (A * B).as_matrix(), atol=1e-12)
        back = spatial.quaternion_from_rotation(A.as_matrix())
        np.testing.assert_allclose(back, a if a[0] >= 0 else -a, atol=1e-12)


def test_rotation_error_is_the_small_angle_between_two_attitudes() -> None:
    R_ref = spatial.rotation_from_rpy(0.3, -0.2, 1.0)
    small = np.array([1e-4, -2e-4, 3e-4])
    R = R_ref @ Rotation.from_rotvec(small).as_matrix()
    np.testing.assert_allclose(spatial.rotation_error(R, R_ref), small, atol=1e-10)


@pytest.mark.parametrize("name", ["rot_x", "rot_y", "rot_z"])
def test_symbols_and_numbers_give_the_same(name: str) -> None:
    function, angle_symbol = getattr(spatial, name), ca.SX.sym("a")
    traced = ca.Function("f", [angle_symbol], [function(angle_symbol)])
    np.testing.assert_allclose(traced(0.7).full(), function(0.7), atol=1e-15)


@pytest.mark.parametrize(("angle", "turns"), [(0.5, 0), (3.5, -1), (-3.5, 1), (np.pi, -1), (7.0, -1)])
def test_an_angle_is_wrapped_to_half_a_turn_either_way(angle: float, turns: int) -> None:
    same = angle + 2.0 * np.pi * turns
    assert spatial.wrapped(angle) == pytest.approx(same)
    np.testing.assert_allclose(spatial.wrapped(np.array([angle, 0.0])), [same, 0.0])


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3))
def test_a_rotation_about_an_axis_agrees_with_scipy(v: tuple[float, ...]) -> None:
    turned, size = Rotation.from_rotvec(v).as_matrix(), float(np.linalg.norm(v))
    np.testing.assert_allclose(spatial.rotation_from_vector(np.array(v)), turned, atol=1e-9)
    np.testing.assert_allclose(spatial.rotation_from_axis_angle(np.array(v) / size, size), turned, atol=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_small_turn_is_the_rotation_vector_whichever_sign_a_quaternion_has(sign: float) -> None:
    turn = np.array([0.01, -0.02, 0.03])
    first = spatial.quaternion_from_rotation(spatial.rotation_from_rpy(0.4, -0.3, 2.0))
    then = spatial.quaternion_product(first, np.array([1.0, *0.5 * turn]))
    np.testing.assert_allclose(spatial.small_turn(first, sign * then), turn, rtol=1e-3)
