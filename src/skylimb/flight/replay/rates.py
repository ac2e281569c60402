"""Velocities from poses, for logs that hold poses alone."""

from __future__ import annotations

import numpy as np

CUTOFF = 20.0
"""Hz: of the low pass behind the differences, as the lab's own estimator has it."""

SAME = 1e-9
"""Metres, or parts of a quaternion, by which a pose that is held may be off by rounding."""


def velocities(times: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Velocity at every tick, m/s, (k, 3): differences between frames, through a low pass.

    Args:
        times: s, (k,).
        positions: m, (k, 3); a position that repeats the one before is no new frame.
    """
    fresh = _fresh(positions)
    return _filtered(times, fresh, np.diff(positions[fresh], axis=0))


def angular_velocities(times: np.ndarray, quaternions: np.ndarray) -> np.ndarray:
    """Angular velocity at every tick in the body's own axes, rad/s, (k, 3).

    Args:
        times: s, (k,).
        quaternions: w x y z, (k, 4); one that repeats the one before is no new frame.
    """
    fresh = _fresh(quaternions)
    before, after = quaternions[fresh][:-1], quaternions[fresh][1:]
    # The turn in between, conj(before) * after, as a rotation vector; a quaternion and its negative are one.
    w = np.sum(before * after, axis=1, keepdims=True)
    turn = before[:, :1] * after[:, 1:] - after[:, :1] * before[:, 1:] - np.cross(before[:, 1:], after[:, 1:])
    size = np.linalg.norm(turn, axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(size, abs(w)) * np.where(w < 0.0, -1.0, 1.0)
    return _filtered(times, fresh, turn * (angle / np.where(size > 0.0, size, 1.0)))


def _fresh(rows: np.ndarray) -> np.ndarray:
    """The rows that differ from the one before them by more than rounding."""
    changed = np.any(abs(np.diff(rows, axis=0)) > SAME, axis=1)
    return np.flatnonzero(np.concatenate([[True], changed]))


def _filtered(times: np.ndarray, fresh: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """The rate of steps between frames, held between them, (k, 3); `steps` is (frames - 1, 3)."""
    elapsed = np.diff(times[fresh])[:, None]
    decay, rates = np.exp(-2.0 * np.pi * CUTOFF * elapsed), np.zeros((len(fresh), 3))
    for i, rate in enumerate(steps / elapsed):
        rates[i + 1] = decay[i] * rates[i] + (1.0 - decay[i]) * rate
    return rates[np.searchsorted(fresh, np.arange(len(times)), side="right") - 1]
