"""Where searches over vectoring angles begin: everywhere alike, and the same every time."""

from __future__ import annotations

import math

import numpy as np

from skylimb.robots.model import Robot


def golden_steps(n: int) -> np.ndarray:
    """Steps (n,) of a low-discrepancy sequence in n dimensions, in turns.

    They are powers of 1 / x for the root of x^(n + 1) = x + 1, which is the golden ratio for n = 1.
    """
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (n + 1))
    return root ** -np.arange(1, n + 1)


def evenly(lower: np.ndarray, upper: np.ndarray, count: int) -> np.ndarray:
    """As many places (count, n) as asked, spread evenly between limits (n,)."""
    steps = np.outer(np.arange(1, count + 1), golden_steps(len(lower))) % 1.0
    return lower + (upper - lower) * steps


def vectoring_starts(robot: Robot, around: np.ndarray, count: int) -> np.ndarray:
    """Vectoring angles (count, nv) in rad: the given ones, then others all around; one row if it has none."""
    steps = np.outer(np.arange(count if robot.n_vectoring else 1), golden_steps(robot.n_vectoring))
    return within_limits(robot, around + 2.0 * math.pi * steps)


def within_limits(robot: Robot, angles: np.ndarray) -> np.ndarray:
    """Vectoring angles (..., nv) in rad, those of limited joints folded into their limits.

    A whole turn is the same angle, so it is taken off first. What still lies outside is reflected at the
    limits.
    """
    lower, upper = robot.vectoring_limits()
    folded = np.array(angles, dtype=float)
    for i in np.flatnonzero(np.isfinite(lower) & np.isfinite(upper)):
        turned = (folded[..., i] + math.pi) % (2.0 * math.pi) - math.pi
        away = (turned - lower[i]) % (2.0 * (upper[i] - lower[i]))
        folded[..., i] = lower[i] + np.minimum(away, 2.0 * (upper[i] - lower[i]) - away)
    return folded
