"""Reach to posture and back, on numbers and symbols, for a closed form and a polynomial."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.base.errors import DescriptionError, UnreachableError
from skylimb.control.planning.posture import posture_family
from skylimb.robots import Robot, load_robot

ROBOT = load_robot("hydrus_xi_quad")
FAMILY = posture_family(ROBOT)


def with_posture(**changes):
    d = ROBOT.description
    return Robot(replace(d, posture=replace(d.posture, **changes)))


# Joint angles that do not keep the heading: the reach of this family has no closed form.
BENT_ROBOT = with_posture(offset=np.array([1.3, 0.3, 0.2]), slope=np.array([-0.8, 1.5, -1.2]))
BENT = posture_family(BENT_ROBOT)


def test_facts_of_the_paper_family():
    assert FAMILY.reach(np.pi / 6) == pytest.approx(1.09, abs=0.002)
    assert FAMILY.reach(0.20) == pytest.approx(1.158, abs=0.001)
    assert FAMILY.reach(1.25) == pytest.approx(0.766, abs=0.001)
    assert FAMILY.slope(np.pi / 6) == pytest.approx(-0.295, abs=0.001)
    assert FAMILY.reach_nominal == FAMILY.reach(FAMILY.theta_nominal)
    assert FAMILY.coefficients is not None
    np.testing.assert_allclose(FAMILY.joint_angles(np.pi / 6), [np.pi / 3, np.pi / 3, -np.pi / 6], atol=1e-12)


def test_the_joint_limits_end_the_family_where_joint2_stops():
    assert FAMILY.theta_max == pytest.approx(1.57 / 2)
    assert FAMILY.described == (0.20, 1.25)
    lower, upper = ROBOT.joint_limits()
    for theta in (FAMILY.theta_min, FAMILY.theta_max):
        assert np.all(FAMILY.joint_angles(theta) >= lower)
        assert np.all(FAMILY.joint_angles(theta) <= upper)
    with pytest.raises(UnreachableError, match=r"shape angle 0.8 rad .* 0.2 .. 0.785 rad .*limits of joint2"):
        FAMILY.joint_angles(0.8)


@pytest.mark.parametrize("family", [FAMILY, BENT], ids=["closed form", "polynomial"])
def test_reach_is_that_of_the_model_averaged_over_vectoring(family):
    robot = ROBOT if family is FAMILY else BENT_ROBOT
    for theta in np.linspace(family.theta_min, family.theta_max, 7):
        reaches = []
        for psi in np.random.default_rng(0).uniform(-np.pi, np.pi, (200, 4)):
            for turned in (psi, psi + np.pi):
                s = robot.model(ca.DM(family.joint_angles(theta)), ca.DM(turned))
                d, h = (s.tip_root - s.cog_root).full().ravel(), float(s.tip_heading)
                reaches.append(d[0] * np.cos(h) + d[1] * np.sin(h))
        assert family.reach(theta) == pytest.approx(np.mean(reaches), abs=1e-10)
        assert np.ptp(reaches) < 3.1e-3


def test_the_second_family_really_has_no_closed_form():
    assert BENT.coefficients is None


@given(st.floats(0.0, 1.0))
def test_reach_and_shape_angle_are_inverse(share):
    for family, exact in ((FAMILY, 1e-12), (BENT, 1e-9)):
        reach = family.reach_min + share * (family.reach_max - family.reach_min)
        theta = family.shape_angle(reach)
        assert family.theta_min - 1e-9 <= theta <= family.theta_max + 1e-9
        assert family.reach(theta) == pytest.approx(reach, abs=exact)


@given(st.floats(0.21, 0.78))
def test_slope_is_the_derivative_of_reach(theta):
    for family in (FAMILY, BENT):
        theta = family.theta_min + (theta - 0.2) * (family.theta_max - family.theta_min) / 0.59
        step = 1e-5
        difference = (family.reach(theta + step) - family.reach(theta - step)) / (2 * step)
        assert family.slope(theta) == pytest.approx(difference, abs=1e-6)


@pytest.mark.parametrize("family", [FAMILY, BENT], ids=["closed form", "polynomial"])
def test_symbols_give_what_numbers_give_and_are_held_inside(family):
    x = ca.SX.sym("x")
    f = ca.Function("f", [x], [family.reach(x), family.slope(x), family.joint_angles(x)])
    inverse = ca.Function("g", [x], [family.shape_angle(x)])
    for theta in np.linspace(family.theta_min, family.theta_max, 5):
        reach, slope, q = f(theta)
        assert float(reach) == pytest.approx(family.reach(theta), abs=1e-13)
        assert float(slope) == pytest.approx(family.slope(theta), abs=1e-12)
        np.testing.assert_allclose(q.full().ravel(), family.joint_angles(theta), atol=1e-13)
        assert float(inverse(family.reach(theta))) == pytest.approx(theta, abs=1e-7)
    assert float(inverse(5.0)) == pytest.approx(family.shape_angle(family.reach_max), abs=1e-9)
    assert float(inverse(0.0)) == pytest.approx(family.shape_angle(family.reach_min), abs=1e-9)
    held = f(9.0)[2].full().ravel()
    np.testing.assert_allclose(held, family.joint_angles(family.theta_max), atol=1e-12)


def test_the_inverse_costs_a_tick_almost_nothing():
    x = ca.SX.sym("x")
    assert ca.Function("f", [x], [FAMILY.joint_angles(FAMILY.shape_angle(x))]).n_instructions() <= 30


def test_arrays_go_through_in_one_call():
    thetas = np.linspace(0.2, 0.78, 5)
    np.testing.assert_allclose(FAMILY.shape_angle(FAMILY.reach(thetas)), thetas, atol=1e-12)
    assert FAMILY.joint_angles(thetas).shape == (5, 3)


@pytest.mark.parametrize("reach", [0.5, 1.2, -1.0, np.nan, np.inf])
def test_an_unreachable_reach_is_named(reach):
    with pytest.raises(
        UnreachableError, match=r"reach .* m of 'hydrus_xi_quad' is outside of 0.9972 .. 1.158 m"
    ):
        FAMILY.shape_angle(reach)


def test_a_family_that_turns_back_is_refused():
    robot = with_posture(offset=np.array([1.2, 0.0, 0.0]), theta_min=-0.3)
    with pytest.raises(
        DescriptionError, match=r"reach of 'hydrus_xi_quad' turns back at theta = (-0.00|0.00)"
    ):
        posture_family(robot)


def test_a_family_outside_of_the_joint_limits_is_refused():
    robot = with_posture(offset=np.array([1.5707963, 1.0, 0.0]))
    with pytest.raises(DescriptionError, match=r"without posture.theta_nominal"):
        posture_family(robot)
