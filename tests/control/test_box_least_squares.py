"""The active set within bounds against a reference solver and a linear programme."""

from collections.abc import Iterator

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import linprog, lsq_linear

from skylimb.control.box_least_squares import ITERATIONS, nearest_in_box

WEIGHTS = np.array([1.0, 1.0, 3.0, 10.0, 10.0, 0.3])
REACH, DRAG = 0.4, 0.02


def rotors(n: int, tilt: float) -> np.ndarray:
    """Weighted allocation matrix, (6, n), of a flat ring whose rotors tilt to either side in turn, rad."""
    columns = []
    for k, angle in enumerate(2.0 * np.pi * np.arange(n) / n):
        outward, up = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([0.0, 0.0, 1.0])
        sign = (-1.0) ** k
        axis = np.cos(tilt) * up + sign * np.sin(tilt) * np.cross(outward, up)
        columns.append([*axis, *(np.cross(REACH * outward, axis) + sign * DRAG * axis)])
    return WEIGHTS[:, None] * np.array(columns).T


RINGS = {4: rotors(4, 0.2), 6: rotors(6, 0.35), 8: rotors(8, 0.35)}


def problems(n: int, count: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Wanted thrusts and their bounds, N: a little, half or far out of reach; or reachable by others."""
    rng = np.random.default_rng(n)
    A = RINGS[n]
    for k in range(count):
        lower = rng.uniform(-2.0, 2.0, n)
        upper = lower + rng.uniform(5.0, 15.0, n)
        inside = lower + (upper - lower) * rng.uniform(size=n)
        wanted = inside + rng.normal(size=n) * (0.5, 5.0, 50.0)[k % 3]
        if k % 4 == 0:
            wanted = inside + (np.eye(n) - np.linalg.pinv(A) @ A) @ (wanted - inside)
        yield wanted, lower, upper


def solve(A: np.ndarray, *given: np.ndarray) -> tuple[np.ndarray, float]:
    x, iterations = nearest_in_box(*A.shape)(A, *given)
    return x.full().ravel(), float(iterations)


@pytest.mark.parametrize("n", RINGS)
def test_it_is_the_least_squares_solution_of_the_reference_and_never_outside(n: int) -> None:
    A, most = RINGS[n], 0.0
    for wanted, lower, upper in problems(n, 900):
        x, iterations = solve(A, wanted, lower, upper)
        assert (x >= lower).all()
        assert (x <= upper).all()
        reference = lsq_linear(A, A @ wanted, (lower, upper), method="bvls", tol=1e-14, max_iter=300).x
        np.testing.assert_allclose(A @ x, A @ reference, atol=1e-6)
        if n <= 6:  # more rotors leave a choice
            np.testing.assert_allclose(x, reference, atol=1e-6)
        most = max(most, iterations)
    assert 4 < most < ITERATIONS / 2


@pytest.mark.parametrize("n", RINGS)
def test_nothing_is_missing_whenever_a_linear_programme_finds_thrusts(n: int) -> None:
    A, feasible = RINGS[n], 0
    for wanted, lower, upper in problems(n, 160):
        bounds = np.stack([lower, upper], axis=1)
        found = linprog(np.zeros(n), A_eq=A, b_eq=A @ wanted, bounds=bounds, method="highs")
        x, _ = solve(A, wanted, lower, upper)
        missing = np.abs(A @ (x - wanted)).max()
        if found.status == 0:
            feasible += 1
            assert missing < 1e-6
        else:
            assert missing > 1e-9
    assert 65 <= feasible <= 90


@pytest.mark.parametrize("n", RINGS)
def test_what_is_inside_comes_back_to_the_bit_without_an_iteration(n: int) -> None:
    for wanted, lower, upper in problems(n, 30):
        inside = np.clip(wanted, lower, upper)
        x, iterations = solve(RINGS[n], inside, lower, upper)
        np.testing.assert_array_equal(x, inside)
        assert iterations == 0.0


def test_of_several_answers_it_is_the_one_near_what_was_wanted() -> None:
    """As the regularised problem has it: its solution is unique, and differs by what it costs in A x."""
    A, n = RINGS[8], 8
    moved = []
    for wanted, lower, upper in problems(n, 200):
        x, _ = solve(A, wanted, lower, upper)
        soft = 1e-4 * np.sqrt(np.trace(A.T @ A) / n)
        stacked = np.vstack([A, soft * np.eye(n)])
        near = lsq_linear(stacked, stacked @ wanted, (lower, upper), method="bvls", tol=1e-14).x
        moved.append(np.abs(x - near).max())
    assert np.median(moved) < 1e-5
    assert max(moved) < 0.05


def test_a_bound_of_no_width_holds() -> None:
    A = RINGS[6]
    wanted, lower, upper = next(problems(6, 1))
    lower = upper.copy()
    x, _ = solve(A, wanted, lower, upper)
    np.testing.assert_array_equal(x, upper)
    lower[:3] -= 4.0
    x, _ = solve(A, wanted, lower, upper)
    free = lsq_linear(A[:, :3], A @ wanted - A[:, 3:] @ upper[3:], (lower[:3], upper[:3]), method="bvls").x
    np.testing.assert_allclose(x[:3], free, atol=1e-6)
    np.testing.assert_array_equal(x[3:], upper[3:])


def test_columns_of_nothing_stay_near_what_was_wanted() -> None:
    A = np.zeros((6, 4))
    x, _ = solve(A, np.array([0.5, 2.0, -3.0, 0.1]), np.zeros(4), np.ones(4))
    np.testing.assert_allclose(x, [0.5, 1.0, 0.0, 0.1])


def test_it_is_called_within_a_traced_function_of_scalars() -> None:
    A, symbol = RINGS[4], ca.SX.sym("wanted", 4)
    lower, upper = np.zeros(4), np.full(4, 10.0)
    x, _ = nearest_in_box(6, 4)(A, symbol, lower, upper)
    traced = ca.Function("traced", [symbol], [2.0 * x])
    assert traced.n_instructions() < 100
    wanted = np.array([3.0, -4.0, 12.0, 20.0])
    expected, iterations = solve(A, wanted, lower, upper)
    assert iterations > 0
    np.testing.assert_array_equal(traced(wanted).full().ravel(), 2.0 * expected)
    # Derivatives, which the analysis of stability takes: the free thrusts make up for the others.
    slope = ca.Function("slope", [symbol], [ca.jacobian(2.0 * x, symbol)])(wanted).full()
    step = 1e-5
    by_differences = np.array(
        [
            (traced(wanted + step * e) - traced(wanted - step * e)).full().ravel() / (2 * step)
            for e in np.eye(4)
        ]
    ).T
    np.testing.assert_allclose(slope, by_differences, atol=1e-6)
