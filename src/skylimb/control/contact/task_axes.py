"""What is felt, in the axes of the task."""

from __future__ import annotations

from typing import Any

from skylimb.control.estimation.records import Wrench
from skylimb.symbolic import Array, clip, dot, vector, where

Axes = tuple[Array, Array, Array]
"""Contact axis and sliding axes."""

_MOVES = 0.02
"""Speed of the path from which its direction can be trusted, m/s; less below it."""

_PRESSED = 0.3
"""Least push along the contact axis in which a slope shows, N: less divides by noise."""


def in_task(vector_W: Array, axes: Axes) -> Array:
    """A vector of W in the frame of the task, (3,)."""
    return vector(*(dot(axis, vector_W) for axis in axes))


def seen_across(wrench: Wrench, path: Array, speed: Any, axes: Axes) -> Array:
    """What the force shows of the slope across the path, where friction has no part in it.

    Returns:
        Direction across the path in the sliding plane, times how far it can be trusted, and the slope there.
    """
    a, u, v = axes
    along = path / (speed + 1e-9)
    moving = clip(speed / _MOVES, 0.0, 1.0)
    across = vector(-along[1], along[0])
    pressed = dot(a, wrench.force)
    sideways = across[0] * dot(u, wrench.force) + across[1] * dot(v, wrench.force)
    seen = sideways / where(pressed < -_PRESSED, pressed, -_PRESSED)
    known = moving * where(pressed < -_PRESSED, 1.0, 0.0)
    return vector(across[0] * known, across[1] * known, seen)


def normal_force_on(wrench: Wrench, slope: Array, axes: Axes) -> Any:
    """f_hat . n of the estimated surface, N: friction lies in the surface and drops out."""
    a, u, v = axes
    force = wrench.force
    length = (1.0 + slope[0] ** 2 + slope[1] ** 2) ** 0.5
    return -(dot(a, force) - slope[0] * dot(u, force) - slope[1] * dot(v, force)) / length
