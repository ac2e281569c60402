"""Where a surface was that was moved in flight, and what is drawn on it where the surface was first."""

from __future__ import annotations

import mujoco
import numpy as np
import xarray as xr

from skylimb.analysis.viewer.shapes import OUT_OF_SIGHT

POSITION, QUATERNION, PRESENT = "surface_position", "surface_quaternion", "surface_present"


def is_moved(log: xr.Dataset) -> bool:
    """Whether a log tells where its surface was over time."""
    return all(name in log for name in (POSITION, QUATERNION, PRESENT))


def where(log: xr.Dataset) -> np.ndarray:
    """Position (m) and quaternion of the surface's axes in W, (time, 7); out of sight while it is away."""
    found = np.concatenate([log[POSITION].values, log[QUATERNION].values], axis=1)
    found[:, 2] -= np.where(log[PRESENT].values > 0.0, 0.0, OUT_OF_SIGHT)
    turned = np.concatenate([[1.0], np.sum(found[1:, 3:] * found[:-1, 3:], axis=1)])
    found[:, 3:] *= np.cumprod(np.where(turned < 0.0, -1.0, 1.0))[:, None]
    return found


def moves_of(log: xr.Dataset) -> np.ndarray:
    """How the surface has moved since the first sample: x -> R x + d, as d (m) and the quaternion of R.

    Returns:
        (time, 7).
    """
    poses = where(log)
    back, found = np.zeros(4), np.empty_like(poses)
    mujoco.mju_negQuat(back, poses[0, 3:])
    turn, place = np.zeros(4), np.zeros(3)
    for pose, move in zip(poses, found, strict=True):
        mujoco.mju_mulQuat(turn, pose[3:], back)
        mujoco.mju_rotVecQuat(place, poses[0, :3], turn)
        move[:3], move[3:] = pose[:3] - place, turn
    return found


def taken_back(ends: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Points on a surface that has moved, where they are on the surface as it was first.

    Args:
        ends: W, m, (n, 2, 3).
        moves: of each segment, (n, 7); see `moves_of`.
    """
    found, back = np.empty_like(ends), np.zeros(4)
    for segment, move, out in zip(ends, moves, found, strict=True):
        mujoco.mju_negQuat(back, move[3:])
        for point, place in zip(segment, out, strict=True):
            mujoco.mju_rotVecQuat(place, point - move[:3], back)
    return found
