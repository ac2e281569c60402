"""The board's attitude: exact at rest, corrected slowly, and deaf to a push."""

from __future__ import annotations

import numpy as np
import pytest

from skylimb.apps.ros.attitude_filter import AttitudeFilter
from skylimb.base.rotations import rotation_from_rpy

UP, FIELD, STILL = np.array([0.0, 0.0, 9.8]), np.array([0.3, 0.0, -0.35]), np.zeros(3)


def turned(roll: float, pitch: float, yaw: float) -> np.ndarray:
    return np.asarray(rotation_from_rpy(roll, pitch, yaw))


def seen(R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return R.T @ UP, R.T @ FIELD


@pytest.mark.parametrize("rpy", [(0.0, 0.0, 0.0), (0.3, -0.2, 2.5), (-0.5, 0.4, -3.0)])
def test_at_rest_it_is_the_attitude(rpy: tuple[float, float, float]) -> None:
    R = turned(*rpy)
    board = AttitudeFilter(*seen(R))
    for _ in range(10):
        board = board.after(STILL, *seen(R), 0.001)
    np.testing.assert_allclose(board.R, R, atol=1e-12)


def test_it_turns_with_the_gyro_and_forgets_an_error_in_its_own_time() -> None:
    rates, dt = np.array([0.4, -0.3, 0.5]), 0.001
    R = turned(0.1, 0.0, 0.0)
    board = AttitudeFilter(*seen(R))
    for _ in range(500):
        angle = rates * dt
        R = R @ turned(*angle)
        board = board.after(rates, *seen(R), dt)
    np.testing.assert_allclose(board.R, R, atol=2e-3)
    # What it believes of up is a third of the way off after 1.8 s.
    off, board = turned(0.2, 0.0, 0.0), AttitudeFilter(*seen(np.eye(3)))
    for _ in range(1800):
        board = board.after(STILL, *seen(off), dt)
    left = np.arccos(board.R[2] @ off[2])
    assert left / 0.2 == pytest.approx(np.exp(-1.0), abs=0.02)


def test_a_push_is_not_taken_for_gravity() -> None:
    board = AttitudeFilter(UP, FIELD)
    after = board
    for _ in range(300):
        after = after.after(STILL, np.array([8.0, 0.0, 9.8]), FIELD, 0.001)
    np.testing.assert_allclose(after.R, board.R, atol=1e-12)
