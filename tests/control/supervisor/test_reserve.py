"""What is commanded where no controller does."""

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.supervisor.reserve import SOFT, Firmness, reserve_force, reserve_thrusts

ROBOT = skylimb.load_robot("hydrus_xi_quad")
MODEL = ROBOT.at(*nominal_posture(ROBOT, "contact"))


@pytest.mark.parametrize("torque", [(0.3, 0.0, 0.0), (0.0, -0.2, 0.0), (0.2, 0.3, 0.0)])
def test_what_turns_it_from_outside_is_turned_back(torque: tuple[float, ...]) -> None:
    still, made = np.zeros(3), np.asarray(MODEL.hover_thrusts)
    body = BodyState(still, still, np.eye(3), still, MODEL)

    def wrench(torque: np.ndarray) -> np.ndarray:
        outside = Wrench(still, torque)
        force = reserve_force(body, outside, still, SOFT)
        thrusts = reserve_thrusts(body, outside, force, np.ones(4), made, ROBOT.thrust_limits())
        return MODEL.allocation_C @ thrusts

    change = wrench(np.array(torque)) - wrench(still)
    np.testing.assert_allclose(change[3:5], -np.array(torque[:2]), atol=0.01)
    assert abs(change[2]) < 0.01  # its lift stays


STILL, LEFT = np.zeros(3), np.ones(4)
NONE = Wrench(STILL, STILL)
LEVEL = BodyState(STILL, STILL, np.eye(3), STILL, MODEL)
HOVER = np.asarray(MODEL.hover_thrusts)


def made(body: BodyState = LEVEL, outside: Wrench = NONE, firm: Firmness = SOFT) -> np.ndarray:
    """The wrench in {C} of the thrusts that hold it still."""
    force = reserve_force(body, outside, STILL, firm)
    return MODEL.allocation_C @ reserve_thrusts(
        body, outside, force, LEFT, HOVER, ROBOT.thrust_limits(), firm
    )


def test_what_pushes_it_from_outside_is_pushed_back() -> None:
    pushed = made(outside=Wrench(np.array([0.0, 0.0, -2.0]), STILL))
    assert pushed[2] - made()[2] == pytest.approx(2.0, abs=0.02)
    # To the side by a lean: it turns the thrust against the push.
    aside = made(outside=Wrench(np.array([-1.0, 0.0, 0.0]), STILL)) - made()
    turn = np.linalg.solve(MODEL.inertia_C, aside[3:])
    lean = SOFT.stiffness / (MODEL.mass * MODEL.gravity[2])
    np.testing.assert_allclose(turn[:2], [0.0, lean], atol=0.02 * lean)


def test_a_velocity_is_held_by_its_rate() -> None:
    sinking = LEVEL._replace(velocity=np.array([0.0, 0.0, -0.2]))
    assert made(sinking)[2] - made()[2] == pytest.approx(SOFT.hold * 0.2 * MODEL.mass, rel=0.02)


def test_a_turn_about_the_thrust_is_let_go_and_a_tilt_is_damped() -> None:
    """Yaw has the least torque, and what it takes of the thrusts roll and pitch have not."""
    yawing, tilting = (
        made(LEVEL._replace(angular_velocity=0.5 * axis)) - made() for axis in (np.eye(3)[2], np.eye(3)[0])
    )
    assert abs(yawing[5]) < 0.01 * SOFT.damping * 0.5 * MODEL.inertia_C[2, 2]
    assert tilting[3] == pytest.approx(-SOFT.damping * 0.5 * MODEL.inertia_C[0, 0], rel=0.1)


def test_rotors_that_lag_are_led_by_as_much_as_it_is_firm() -> None:
    sinking = LEVEL._replace(velocity=np.array([0.0, 0.0, -0.2]))
    limits, force = ROBOT.thrust_limits(), reserve_force(sinking, NONE, STILL, SOFT)
    plain, led = (
        reserve_thrusts(sinking, NONE, force, LEFT, HOVER, limits, SOFT._replace(lead=lead)) - HOVER
        for lead in (1.0, 2.0)
    )
    np.testing.assert_allclose(led, 2.0 * plain, atol=1e-9)
    assert np.abs(plain).max() > 0.1
