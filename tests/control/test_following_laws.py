"""The laws of the preset `following`, one by one, in numbers."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skylimb
from skylimb.control.contact import following as contact_law
from skylimb.control.contact_machine import SLIDE
from skylimb.control.lateral import Moves, lateral_move
from skylimb.control.records import ContactView, Demand, LawInput, no_contact
from skylimb.control.shape import recentring
from skylimb.control.translation import following
from skylimb.errors import ConfigError
from skylimb.estimation.records import BodyState, Estimate, Measurement, Start, Wrench
from skylimb.missions.reference import zero_reference
from skylimb.packing import numeric
from skylimb.planning.vectoring import vectoring_table
from skylimb.robots.model import GRAVITY_W, Robot, RobotState
from skylimb.symbolic import right_inverse

DT = 0.005
GAINS = following.Gains(stiffness=(5.0, 8.0, 5.0), damping_ratio=(0.8, 0.7, 0.8), press_mass_ratio=1.0)
ENGAGED = no_contact()._replace(engaged=1.0, normal_force=1.0)
ARM = np.array([1.09, 0.0, 0.1])
X, Y = np.eye(3)[:2]
NOBODY: Any = None
START = Start(NOBODY, 1.09, np.zeros(4))


@pytest.fixture(scope="module")
def robot() -> Robot:
    return skylimb.load_robot("hydrus_xi_quad")


@pytest.fixture(scope="module")
def model(robot: Robot) -> RobotState:
    table = vectoring_table(robot, "contact")
    return robot.at([np.pi / 3, np.pi / 3, -np.pi / 6], table.angles(np.pi / 6))


def inputs(model: RobotState, contact: ContactView = ENGAGED, **changes: Any) -> LawInput:
    z3 = np.zeros(3)
    given_ = {"position": z3, "velocity": z3, "force": -X, "tip_position": ARM, "tip_velocity": z3} | changes
    body = BodyState(given_["position"], given_["velocity"], np.eye(3), z3, model)
    reference = zero_reference(3, 4)._replace(
        contact_axis=X,
        sliding_axis=Y,
        reach=1.09,
        tip_position=given_["tip_position"],
        tip_velocity=given_["tip_velocity"],
    )
    wrench = Wrench(given_["force"], z3)
    estimate = Estimate(body, wrench, wrench, -1.0, ARM, Wrench(z3, z3))
    return LawInput(NOBODY, NOBODY, reference, DT, estimate, contact)


def test_at_rest_with_the_wanted_force_it_pushes_with_that_force_and_carries_the_weight(model: Any) -> None:
    gains = numeric(GAINS)
    state, force, _ = following.step(gains, following.initial_state(gains, START), inputs(model))
    np.testing.assert_allclose(force, model.mass * GRAVITY_W + X, atol=1e-12)
    assert state.integral == 0.0
    assert state.tank == pytest.approx(GAINS.tank)


def test_an_eased_contact_is_pressed_with_less_and_asks_for_less(model: Any) -> None:
    gains = numeric(GAINS)
    eased = ENGAGED._replace(normal_force=0.3, ease=0.3)
    state, force, _ = following.step(
        gains, following.initial_state(gains, START), inputs(model, eased, force=-0.3 * X)
    )
    np.testing.assert_allclose(force, model.mass * GRAVITY_W + 0.3 * X, atol=1e-12)
    assert state.integral == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("behind", "ease"), [(0.0, 1.0), (0.015, 1.0), (0.0275, 0.5), (0.04, 0.2), (0.2, 0.2)]
)
def test_a_pen_that_stays_behind_presses_less(model: Any, behind: float, ease: float) -> None:
    gains = numeric(contact_law.Gains(ease_beyond=(0.015, 0.04), least_ease=0.2))
    state = contact_law.initial_state(contact_law.Gains(), START)
    state = numeric(state._replace(machine=state.machine._replace(state=SLIDE)))
    given_ = inputs(model, tip_position=ARM + behind * Y)
    given_ = given_._replace(reference=given_.reference._replace(touch=1.0))
    _, view, _ = contact_law.step(gains, state, given_)
    assert view.ease == pytest.approx(ease)


def test_the_distances_that_ease_are_in_order() -> None:
    with pytest.raises(ConfigError, match="ease_beyond"):
        contact_law.Gains(ease_beyond=(0.04, 0.02))


def test_a_missing_force_is_integrated_up_to_its_limit(model: Any) -> None:
    gains, state = numeric(GAINS), following.initial_state(numeric(GAINS), START)
    for _ in range(4000):
        state, _, _ = following.step(gains, state, inputs(model, ENGAGED._replace(normal_force=0.5)))
    assert state.integral == pytest.approx(GAINS.force_integral_limit)


@given(
    st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-2.0, 4.0)), min_size=1, max_size=60),
    st.floats(0.0, 0.5),
)
def test_the_integral_gives_no_more_than_tank_and_damper_put_in(
    motion: list[tuple[float, float]], tank: float
) -> None:
    """Work of the integral on the motion <= tank at first + what the damper dissipated + a tick's worth."""
    robot = skylimb.load_robot("hydrus_xi_quad")
    plain = type("Model", (), {"mass": robot.mass})
    gains = numeric(GAINS)
    state = following.State(3.0, tank, np.zeros(2))
    spent = dissipated = 0.0
    for speed, normal in motion:
        view = ENGAGED._replace(normal_force=normal)
        given_ = inputs(plain, view, velocity=speed * X)  # pyright: ignore[reportArgumentType]
        before = state
        state, force, _ = following.step(gains, before, given_)
        damper = robot.mass * GAINS.press_damping * speed
        pushed = float(force[0]) + damper - GAINS.force
        spent += pushed * speed * DT
        dissipated += damper * speed * DT
    slack = GAINS.force_integral_limit * 0.3 * DT
    assert spent <= tank + dissipated + slack + 1e-9


def test_the_centre_of_gravity_stands_behind_the_tips_reference(model: Any) -> None:
    gains = numeric(GAINS)
    wanted = ARM + np.array([0.0, 0.05, -0.02])
    target = following.cog_target(gains, inputs(model, tip_position=wanted))
    np.testing.assert_allclose(target + ARM, wanted, atol=1e-12)


@pytest.mark.parametrize("speed", [0.0, 0.1])
def test_friction_is_cancelled_only_as_the_path_moves(model: Any, speed: float) -> None:
    gains = numeric(GAINS)
    rubbed = inputs(model, ENGAGED._replace(speed=speed), force=np.array([-1.0, -0.4, 0.3]))
    state = following.initial_state(gains, START)
    state, force, _ = following.step(gains, state, rubbed)
    for _ in range(200):
        state, force, _ = following.step(gains, state, rubbed)
    share = min(1.0, speed / GAINS.cancel_speed)
    np.testing.assert_allclose((force - model.mass * GRAVITY_W)[1:], share * np.array([0.4, -0.3]), atol=1e-6)


def test_the_arm_keeps_to_its_limits_and_goes_home(model: Any) -> None:
    gains = numeric(recentring.Gains(arm_share=0.0))
    state = recentring.initial_state(gains, START)
    ahead = inputs(model, ENGAGED._replace(anchor=-1.0))
    new, arm, _ = recentring.step(gains, state, ahead, (1.0, 1.15))
    assert arm.reach - 1.09 == pytest.approx(gains.rate_limit * DT)
    for _ in range(1000):
        new, arm, _ = recentring.step(gains, new, ahead, (1.0, 1.15))
    assert arm.reach == 1.15
    for _ in range(8000):
        new, arm, _ = recentring.step(gains, new, inputs(model, no_contact()), (1.0, 1.15))
    assert arm.reach == pytest.approx(1.09, abs=1e-4)


def test_small_moves_give_the_side_force_that_is_missing(robot: Robot) -> None:
    gains = numeric(Moves(damping=1e-6, cutoff=1000.0))
    q, psi = np.array([np.pi / 3, np.pi / 3, -np.pi / 6]), vectoring_table(robot, "contact").angles(np.pi / 6)
    at_rest = robot.at(q, psi)
    lift, torque = at_rest.mass * 9.80665, np.array([0.1, -0.2, 0.15])

    def side(move: np.ndarray) -> np.ndarray:
        moved = robot.at(q, psi + move)
        turn = at_rest.R_root_C.T @ moved.R_root_C
        Q = np.kron(np.eye(2), turn) @ moved.allocation_C
        return (Q @ (right_inverse(Q[2:, :]) @ np.array([lift, *torque])))[:2]

    wanted = side(np.zeros(4)) + np.array([0.1, -0.05])
    move = np.zeros(4)
    for _ in range(20):
        force = np.array([*wanted, lift])
        seen = inputs(at_rest)._replace(robot=robot, measurement=Measurement(q, q, q, q, q, psi))
        found = lateral_move(gains, move, seen, Demand(force, force, torque, q, psi))
        move = np.asarray(found[0]).ravel()
    np.testing.assert_allclose(side(move), wanted, atol=1e-4)
