"""The halves of a Kalman filter against the textbook's matrices, SciPy's Riccati equation, and themselves."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

from skylimb.control.estimation.kalman import Seen, corrected, mirrored, propagated, taken_in, unit_but_for

RNG = np.random.default_rng(5)
N = 7
ROOT = RNG.normal(size=(N, N))
COVARIANCE = ROOT @ ROOT.T + np.eye(N)
SHOWS = {0: RNG.normal(size=(3, 3)), 4: RNG.normal(size=(3, 3))}
OFF = np.array([0.3, -0.2, 0.7])


def rows() -> np.ndarray:
    H = np.zeros((3, N))
    for column, block in SHOWS.items():
        H[:, column : column + 3] = block
    return H


@pytest.mark.parametrize("noise", [1e-3, 0.5, 30.0])
def test_one_number_after_the_other_is_the_textbooks_update(noise: float) -> None:
    H = rows()
    gain = COVARIANCE @ H.T @ np.linalg.inv(H @ COVARIANCE @ H.T + noise**2 * np.eye(3))
    x, P = taken_in(COVARIANCE, [Seen(SHOWS, OFF, noise, 1.0)])
    np.testing.assert_allclose(x, gain @ OFF, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(P, (np.eye(N) - gain @ H) @ COVARIANCE, atol=1e-7)
    # Joseph's form, which is right for any gain, agrees.
    left = np.eye(N) - gain @ H
    np.testing.assert_allclose(P, left @ COVARIANCE @ left.T + noise**2 * gain @ gain.T, atol=1e-7)


def test_what_does_not_count_changes_nothing() -> None:
    x, P = taken_in(COVARIANCE, [Seen(SHOWS, OFF, 0.1, 0.0)])
    np.testing.assert_array_equal(x, np.zeros(N))
    np.testing.assert_allclose(P, COVARIANCE, atol=1e-15)


def test_a_step_is_the_textbooks_prediction() -> None:
    blocks = {(0, 3): RNG.normal(size=(3, 3)), (3, 4): RNG.normal(size=(2, 3))}
    F, drift = unit_but_for(N, blocks), RNG.uniform(size=N)
    np.testing.assert_array_equal(F[0:3, 3:6], blocks[0, 3])
    np.testing.assert_array_equal(F[3:5, 4:7], blocks[3, 4])
    np.testing.assert_array_equal(F[6, :6], np.zeros(6))
    np.testing.assert_allclose(propagated(COVARIANCE, F, drift), F @ COVARIANCE @ F.T + np.diag(drift))


def test_a_steady_filter_has_the_gain_of_the_riccati_equation() -> None:
    """A mass that a drifting force pushes, whose place and speed are seen: the linear case."""
    dt, mass, drift, noises = 0.01, 4.0, 0.35, (0.003, 0.008)
    A = expm(dt * np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0 / mass], [0.0, 0.0, 0.0]]))
    H, R, spread = np.eye(2, 3), np.diag(np.square(noises)), np.array([0.0, 0.0, drift**2 * dt])
    before = solve_discrete_are(A.T, H.T, np.diag(spread), R)
    wanted = before @ H.T @ np.linalg.inv(H @ before @ H.T + R)
    P = ahead = np.eye(3)
    for _ in range(4000):
        P = propagated(P, A, spread)
        ahead = P
        for k, noise in enumerate(noises):
            _, P = corrected(np.zeros(3), P, np.eye(3)[k], 0.0, noise**2, 1.0)
    np.testing.assert_allclose(ahead, before, rtol=1e-8, atol=1e-14)
    gain = P @ H.T @ np.linalg.inv(R)  # of the covariance that is left
    np.testing.assert_allclose(gain, wanted, rtol=1e-8, atol=1e-12)


def test_symbols_give_the_numbers_of_numbers() -> None:
    P = ca.SX.sym("P", N, N)
    blocks = {(0, 3): ca.SX(RNG.normal(size=(3, 3)))}
    F = unit_but_for(N, blocks)
    x, left = taken_in(mirrored(propagated(P, F, ca.SX(np.ones(N)))), [Seen(SHOWS, OFF, 0.1, 1.0)])
    found = ca.Function("step", [P], [ca.densify(x), ca.densify(left)])(COVARIANCE)
    plain = unit_but_for(N, {(0, 3): np.array(ca.DM(blocks[0, 3]))})
    wanted = taken_in(mirrored(propagated(COVARIANCE, plain, np.ones(N))), [Seen(SHOWS, OFF, 0.1, 1.0)])
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_allclose(np.array(one).reshape(other.shape), other, atol=1e-9)


def test_a_mirrored_matrix_is_symmetric_to_the_bit() -> None:
    skewed = COVARIANCE + np.triu(np.full((N, N), 1e-9), 1)
    P = mirrored(skewed)
    np.testing.assert_array_equal(P, P.T)
    np.testing.assert_array_equal(np.tril(P), np.tril(COVARIANCE))
