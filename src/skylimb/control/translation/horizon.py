"""One axis over a horizon: what moves do to it, and which cost least where nothing limits them.

The axis has the state x = (y, v, w): what is regulated, its rate's cause, and what the rotors give. The robot
tilts to push, so w follows the commanded u with a lag,

    y' = c v,      v' = w - b y,      w' = (u - w) / lag.

With c = 1 and b = 0, y is a place and v its velocity. With b = 1, y is a contact force over the mass, which
pushes back, v the speed into the surface, and c the stiffness of the contact over the mass.

Moves u_0, ..., u_{n-1} are held for a stage of h seconds each. They cost, around the wanted path y_d,

    J = sum_k  q_y (y_k - y_d,k)^2 + q_v (v_k - v_d,k)^2 + (u_k - u_d,k)^2,      u_d = y_d'' + b y_d,

with the cost of going on for ever behind the last stage (the Riccati equation's P, on all of x). Everything
but the present x and the path is constant, so that what is least without limits is a few rows of numbers, and
J is |A (u - u_free)|^2 beyond its least value. `control.box_least_squares` keeps u within its limits.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.symbolic import Array

STAGES, STAGE = 10, 0.1
"""How many stages a plan has, and how long each is, s."""

TIMES = tuple((STAGE * np.arange(1, STAGES + 1)).round(6).tolist())
"""Ends of the stages, s from now."""


class Axis(NamedTuple):
    """The model of an axis, and what its errors cost.

    Attributes:
        lag: of w behind u, s.
        gain: c.
        back: b.
        cost: q_y and q_v, beside 1 for u.
    """

    lag: float
    gain: float
    back: float
    cost: tuple[float, float]


class Plan(NamedTuple):
    """Constants of an axis.

    Attributes:
        cost: A, upper triangular, (STAGES, STAGES).
        of_state: u_free for each entry of x, (STAGES, 3).
        of_path: u_free for the wanted y, now and at the end of each stage, (STAGES, STAGES + 1).
        of_rate: u_free for the wanted rate of y now, (STAGES,).
    """

    cost: Array
    of_state: Array
    of_path: Array
    of_rate: Array


def plan(axis: Axis) -> Plan:
    """The constants of an axis."""
    F, g = held(axis)
    Q, n = np.diag([*axis.cost, 0.0]), STAGES
    P = _cost_to_go(F, g, Q)
    free = np.vstack([np.linalg.matrix_power(F, k + 1) for k in range(n)])
    moved = np.zeros((3 * n, n))
    for k in range(n):
        for j in range(k + 1):
            moved[3 * k : 3 * k + 3, j] = np.linalg.matrix_power(F, k - j) @ g
    weights = np.kron(np.eye(n), Q)
    weights[-3:, -3:] = P
    wanted, effort = _wanted(axis)
    H = moved.T @ weights @ moved + np.eye(n)
    pulled = np.linalg.solve(H, np.hstack([moved.T @ weights @ wanted + effort, -moved.T @ weights @ free]))
    return Plan(np.linalg.cholesky(H).T, pulled[:, -3:], pulled[:, : n + 1], pulled[:, n + 1])


def held(axis: Axis) -> tuple[np.ndarray, np.ndarray]:
    """F (3, 3) and g (3,) of x_{k+1} = F x_k + g u_k, exact for a u that is held."""
    rates = np.zeros((4, 4))
    rates[0, 1], rates[1, 0], rates[1, 2] = axis.gain, -axis.back, 1.0
    rates[2, 2:] = -1.0 / axis.lag, 1.0 / axis.lag
    step = _exponential(STAGE * rates)
    return step[:3, :3], step[:3, 3]


def _exponential(A: np.ndarray) -> np.ndarray:
    """e^A by its series, of a small part of A that is then squared."""
    halvings = max(0, int(np.ceil(np.log2(np.abs(A).sum()))) + 3)
    term = total = np.eye(len(A))
    for k in range(1, 14):
        term = term @ A / (k * 2**halvings)
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def _cost_to_go(F: np.ndarray, g: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """P of the Riccati equation for a cost of 1 on u, by a horizon that doubles.

    The structure-preserving doubling algorithm (Chu, Fan, Lin, Wang, Int. J. Control 77, 2004).
    """
    A, G, P, one = F, np.outer(g, g), Q, np.eye(len(F))
    for _ in range(30):
        W = np.linalg.solve(one + G @ P, np.hstack([A, G]))
        V1, V2 = W[:, : len(F)], W[:, len(F) :]
        A, G, P = A @ V1, G + A @ V2 @ A.T, P + V1.T @ P @ A
    return 0.5 * (P + P.T)


def _wanted(axis: Axis) -> tuple[np.ndarray, np.ndarray]:
    """Wanted x at the stages' ends, (3 n, n + 2), and u, (n, n + 2), of n + 1 places and the rate now.

    A contact force is wanted as it is at each stage: there v is 0 and u the force.
    """
    n = STAGES
    place = np.hstack([np.eye(n + 1), np.zeros((n + 1, 1))])
    if axis.back:
        rate, push = np.zeros((n + 1, n + 2)), axis.back * place
    else:
        before = place[1] - 2.0 * STAGE * np.eye(n + 2)[-1]  # of the place a stage ago, by the rate now
        ahead = np.vstack([before, place, 2.0 * place[-1] - place[-2]])
        rate = (ahead[2:] - ahead[:-2]) / (2.0 * STAGE)
        push = (ahead[2:] - 2.0 * ahead[1:-1] + ahead[:-2]) / STAGE**2
        push[-1] = push[-2]
    wanted = np.stack([place[1:], rate[1:], push[1:]], axis=1).reshape(3 * n, n + 2)
    return wanted, push[:-1]


def free_moves(constants: Plan, state: Any, path: Any, rate: Any) -> Array:
    """u_free, (STAGES,).

    Args:
        constants: of the axis.
        state: x, (3,).
        path: wanted y, now and at the end of each stage, (STAGES + 1,).
        rate: of it, now.
    """
    return constants.of_state @ state + constants.of_path @ path + constants.of_rate * rate
