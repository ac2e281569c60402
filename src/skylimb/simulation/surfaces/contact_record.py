"""What a contact was, tick by tick: forces, slip, friction's work, gaps, and the trace on the surface."""

from __future__ import annotations

import numpy as np

from skylimb.simulation.surfaces.touched import Touched


def record_contact(
    surface: Touched,
    time: np.ndarray,
    force: np.ndarray,
    duty: np.ndarray,
    tip: np.ndarray,
    tip_velocity: np.ndarray,
) -> dict[str, np.ndarray]:
    """The record of a contact from what a run logs, one row a tick; vectors in W.

    The true outward `normal` where the tip is closest to the surface; `normal_force` on the tip along it and
    the rest of the force, `tangential_force`, N; `slip_velocity` of the tip relative to and along the
    surface, m/s, zero without touch; `friction_work`, what friction has taken up to each tick, J, which never
    falls; and `trace`, unrolled coordinates of the touch on the surface, m, NaN without one.

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
    along = relative - np.sum(relative * normal, axis=1, keepdims=True) * normal
    pressing = np.sum(force * normal, axis=1)
    tangential = force - pressing[:, None] * normal
    tick = float(time[1] - time[0]) if len(time) > 1 else 0.0
    # The force is a mean over the tick, so the slip is taken at the tick's middle, also of the last touch.
    middle = np.concatenate([0.5 * (along[1:] + along[:-1]), along[-1:]])
    taken = np.maximum(-np.sum(tangential * middle, axis=1), 0.0) * tick
    trace = np.stack(surface.trace(tip, time), axis=1)
    return {
        "normal": normal,
        "normal_force": pressing,
        "tangential_force": tangential,
        "slip_velocity": np.where(touching[:, None], along, 0.0),
        "friction_work": np.cumsum(taken),
        "trace": np.where(touching[:, None], trace, np.nan),
    }


def contact_gaps(time: np.ndarray, touching: np.ndarray, tick: float) -> list[list[float]]:
    """Start and duration (s) of every run of ticks (s) without touch between two touches, however short."""
    there = np.flatnonzero(touching)
    ends = np.flatnonzero(np.diff(there) > 1)
    return [[float(time[there[k] + 1]), float((there[k + 1] - there[k] - 1) * tick)] for k in ends]
