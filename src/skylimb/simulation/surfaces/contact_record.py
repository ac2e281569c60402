"""What a contact was, tick by tick: forces, slip, friction's work, gaps, and the trace on the surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np


class TouchedSurface(Protocol):
    """What the record of a contact has to know of a surface; points (n, 3) in W, m, times (n,) in s."""

    def velocity(self, time: Any) -> np.ndarray:
        """Its velocity, (n, 3), W, m/s."""
        ...

    def normal(self, points: np.ndarray, time: Any) -> np.ndarray:
        """Outward unit normals nearest to the points, (n, 3), W."""
        ...

    def signed_distance(self, points: np.ndarray, time: Any) -> np.ndarray:
        """Distances of the points, (n,), m; negative behind it."""
        ...

    def trace(self, points: np.ndarray, time: Any) -> tuple[np.ndarray, np.ndarray]:
        """Unrolled coordinates (s, t), m, of the nearest points."""
        ...


@dataclass(frozen=True)
class ContactRecord:
    """A contact over n ticks; vectors in the world.

    Attributes:
        normal: (n, 3) true outward normal where the tip is closest to the surface.
        normal_force: (n,) force on the tip along it, N.
        tangential_force: (n, 3) the rest of the force, N.
        slip_velocity: (n, 3) of the tip relative to and along the surface, m/s; zero without touch.
        friction_work: (n,) energy that friction has taken up to each tick, J; it never falls.
        trace: (n, 2) unrolled coordinates of the touch on the surface, m; NaN in ticks without touch.
        gaps: start and duration (s) of every gap between the first touch and the last, however short.
    """

    normal: np.ndarray
    normal_force: np.ndarray
    tangential_force: np.ndarray
    slip_velocity: np.ndarray
    friction_work: np.ndarray
    trace: np.ndarray
    gaps: list[list[float]]


def record_contact(
    surface: TouchedSurface,
    time: np.ndarray,
    force: np.ndarray,
    duty: np.ndarray,
    tip: np.ndarray,
    tip_velocity: np.ndarray,
) -> ContactRecord:
    """The record of a contact from what a run logs.

    Args:
        surface: what was touched.
        time: (n,) beginning of each tick, s, evenly spaced.
        force: (n, 3) mean force on the tip over each tick, W, N.
        duty: (n,) fraction of each tick's physics steps that touched.
        tip: (n, 3) tip centre at the beginning of each tick, W, m.
        tip_velocity: (n, 3) its velocity, W, m/s.
    """
    touching = duty > 0.0
    normal = surface.normal(tip, time)
    relative = tip_velocity - surface.velocity(time)
    slip = relative - np.sum(relative * normal, axis=1, keepdims=True) * normal
    slip = np.where(touching[:, None], slip, 0.0)
    pressing = np.sum(force * normal, axis=1)
    tangential = force - pressing[:, None] * normal
    tick = float(time[1] - time[0]) if len(time) > 1 else 0.0
    # The force is a mean over the tick, so the slip is taken at the tick's middle.
    middle = np.concatenate([0.5 * (slip[1:] + slip[:-1]), slip[-1:]])
    taken = np.maximum(-np.sum(tangential * middle, axis=1), 0.0) * tick
    trace = np.stack(surface.trace(tip, time), axis=1)
    return ContactRecord(
        normal=normal,
        normal_force=pressing,
        tangential_force=tangential,
        slip_velocity=slip,
        friction_work=np.cumsum(taken),
        trace=np.where(touching[:, None], trace, np.nan),
        gaps=contact_gaps(time, touching, tick),
    )


def contact_gaps(time: np.ndarray, touching: np.ndarray, tick: float) -> list[list[float]]:
    """Start and duration (s) of every run of ticks (s) without touch that lies between two touches."""
    there = np.flatnonzero(touching)
    ends = np.flatnonzero(np.diff(there) > 1)
    return [[float(time[there[k] + 1]), float((there[k + 1] - there[k] - 1) * tick)] for k in ends]
