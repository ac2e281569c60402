"""Which rotor has lost thrust: the wrench of a loss names its rotor, a push names none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.momentum_observer import ObserverState
from skylimb.control.estimation.records import BodyState
from skylimb.control.estimation.rotor_loss import TARE, THRESHOLD, WHITE, initial_loss, look
from skylimb.control.planning.vectoring import nominal_posture

DT = 0.005
ROBOT = skylimb.load_robot("hydrus_xi_quad")
MODEL = ROBOT.at(*nominal_posture(ROBOT, "contact"))


def flown(
    force: np.ndarray, torque: np.ndarray, seconds: float = 0.2, *before: np.ndarray
) -> tuple[Any, list[Any]]:
    """A hover in which this wrench, W and C, begins to act after the tare, and what is seen of it.

    Others may act for .4 s each before it.
    """
    state, known, seen = initial_loss(ROBOT.n_rotors), ObserverState(), list[Any]()
    momentum = np.zeros(6)
    begins = round(TARE / DT) + 2
    wrenches = [one for one in before for _ in range(round(0.4 / DT))]
    wrenches += [np.concatenate([force, torque])] * round(seconds / DT)
    for k in range(begins + len(wrenches)):
        if k >= begins:
            momentum = momentum + DT * wrenches[k - begins]
        body = BodyState(
            np.zeros(3),
            momentum[:3] / MODEL.mass,
            np.eye(3),
            np.linalg.solve(MODEL.inertia_C, momentum[3:]),
            MODEL,
        )
        state, one = look(state, known, body, MODEL.hover_thrusts, 0.0, 1.0, DT)
        if k < begins:
            assert one.lost == one.pushed == 0.0
        else:
            seen.append(one)
    return state, seen


@pytest.mark.parametrize("rotor", range(4))
@pytest.mark.parametrize("share", [0.7, 1.0])
def test_a_rotor_that_loses_thrust_is_found_with_its_share(rotor: int, share: float) -> None:
    wrench = -share * MODEL.hover_thrusts[rotor] * MODEL.allocation_C[:, rotor]
    state, seen = flown(wrench[:3], wrench[3:])
    wanted = np.ones(4)
    wanted[rotor] = 1.0 - share
    np.testing.assert_allclose(state.left, wanted, atol=0.03)
    first = next(k for k, one in enumerate(seen) if one.lost > 0.0)
    assert first * DT <= 0.12
    assert not any(one.pushed for one in seen)


def told(force: float, share: float) -> tuple[Any, list[Any]]:
    """The same where rotor 0 has lost a share, and makes ever less or more by `force` N a second."""
    state, known, seen = initial_loss(ROBOT.n_rotors), ObserverState(), list[Any]()
    momentum, thrusts = np.zeros(6), np.array(MODEL.hover_thrusts, dtype=float).ravel()
    begins = round(TARE / DT) + 2
    for k in range(begins + round(0.5 / DT)):
        if k >= begins:
            thrusts = thrusts + DT * np.array([force, 0.0, 0.0, 0.0])
            momentum = momentum - DT * share * thrusts[0] * np.asarray(MODEL.allocation_C)[:, 0]
        turning = np.linalg.solve(MODEL.inertia_C, momentum[3:])
        body = BodyState(np.zeros(3), momentum[:3] / MODEL.mass, np.eye(3), turning, MODEL)
        state, one = look(state, known, body, thrusts, 0.0, 1.0, DT)
        seen += [one] if k >= begins else []
    return state, seen


@pytest.mark.parametrize("force", [-15.0, 30.0])
def test_a_share_is_that_of_the_thrusts_of_then(force: float) -> None:
    """What is felt lags: with the thrusts of now half of one that falls would look like all of it."""
    state, seen = told(force, 0.5)
    np.testing.assert_allclose(state.left, [0.5, 1.0, 1.0, 1.0], atol=0.05)
    assert max(one.sure for one in seen) < 0.65


def test_a_loss_near_the_threshold_counts_for_what_it_is() -> None:
    """It shows and hides with the noise; each time that it shows it has acted for long."""
    column, rng = np.asarray(MODEL.allocation_C)[:, 0], np.random.default_rng(3)
    state, known, momentum = initial_loss(ROBOT.n_rotors), ObserverState(), np.zeros(6)
    begins, most = round(TARE / DT) + 2, 0.0
    small = 0.2 * np.asarray(MODEL.hover_thrusts).ravel()
    size = np.linalg.norm(WHITE @ column) * small[0]
    share = THRESHOLD / size
    for k in range(begins + 400):
        momentum = momentum - (k >= begins) * DT * share * small[0] * column
        shaken = momentum + (k >= begins) * 0.002 * rng.standard_normal(6)
        turning = np.linalg.solve(MODEL.inertia_C, shaken[3:])
        body = BodyState(np.zeros(3), shaken[:3] / MODEL.mass, np.eye(3), turning, MODEL)
        state, one = look(state, known, body, small, 0.0, 1.0, DT)
        most = max(most, one.sure)
    assert most < 1.35 * share


def test_a_push_is_no_rotor() -> None:
    state, seen = flown(np.array([0.0, 25.0, 25.0]), np.zeros(3))
    np.testing.assert_array_equal(state.left, np.ones(4))
    assert seen[-1].pushed == 1.0
    assert seen[-1].lost == 0.0


@pytest.mark.parametrize("rotor", range(4))
def test_a_push_that_comes_to_look_like_a_rotor_names_none_and_one_that_fails_meanwhile_is_named(
    rotor: int,
) -> None:
    push = np.array([0.0, 25.0, 25.0, 0.0, 0.0, 0.0])
    lost = -0.7 * MODEL.hover_thrusts[rotor] * MODEL.allocation_C[:, rotor]
    for seconds, left in ((0.2, 1.0), (0.7, 0.3)):
        state, seen = flown(lost[:3], lost[3:], seconds, push)
        np.testing.assert_allclose(state.left, np.where(np.arange(4) == rotor, left, 1.0), atol=0.03)
    assert not any(one.lost for one in seen[: round(0.6 / DT)])
