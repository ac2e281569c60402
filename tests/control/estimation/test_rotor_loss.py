"""Which rotor has lost thrust: the wrench of a loss names its rotor, a push names none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.momentum_observer import ObserverState
from skylimb.control.estimation.records import BodyState
from skylimb.control.estimation.rotor_loss import TARE, initial_loss, look
from skylimb.control.planning.vectoring import nominal_posture

DT = 0.005
ROBOT = skylimb.load_robot("hydrus_xi_quad")
MODEL = ROBOT.at(*nominal_posture(ROBOT, "contact"))


def flown(force: np.ndarray, torque: np.ndarray, seconds: float = 0.2) -> tuple[Any, list[Any]]:
    """A hover in which this wrench, W and C, begins to act after the tare, and what is seen of it."""
    state, known, seen = initial_loss(ROBOT.n_rotors), ObserverState(), list[Any]()
    momentum = np.zeros(6)
    begins = round(TARE / DT) + 2
    for k in range(begins + round(seconds / DT)):
        if k >= begins:
            momentum = momentum + DT * np.concatenate([force, torque])
        body = BodyState(
            np.zeros(3),
            momentum[:3] / MODEL.mass,
            np.eye(3),
            np.linalg.solve(MODEL.inertia_C, momentum[3:]),
            MODEL,
        )
        state, one = look(state, known, body, MODEL.hover_thrusts, 1.0, DT)
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


def test_a_push_is_no_rotor() -> None:
    state, seen = flown(np.array([0.0, 25.0, 25.0]), np.zeros(3))
    np.testing.assert_array_equal(state.left, np.ones(4))
    assert seen[-1].pushed == 1.0
    assert seen[-1].lost == 0.0
