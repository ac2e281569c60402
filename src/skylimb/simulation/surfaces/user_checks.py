"""What a surface of the user's own must be before anything flies: finite and smooth."""

from __future__ import annotations

import casadi as ca
import numpy as np

from skylimb.base.errors import UserCodeError

_SIDE = 41  # samples along u and v; odd, so that the origin is one
_FINER = 64  # parts into which a step is divided to see whether there is a jump in it
_STEEPEST = 10.0
_BEFORE = 0.05  # m before the flat plane
_TOLERANCE = 1e-6


def require_smooth(what: str, heights: ca.Function, numbers: np.ndarray, half: tuple[float, float]) -> None:
    """Raise a `UserCodeError` where a graph is not finite, too steep, or its height or slope jumps.

    Args:
        what: the surface in messages.
        heights: of numbers, u and v: h, h_u, h_v, h_uu, h_uv, h_vv.
        numbers: of the surface.
        half: of its extent along u and v, m.
    """

    def sampled(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        found = np.asarray(heights(numbers, u.reshape(1, -1), v.reshape(1, -1)).full())
        return found.reshape(6, *u.shape)

    u, v = np.meshgrid(*(np.linspace(-side, side, _SIDE) for side in half), indexing="ij")
    found = sampled(u, v)
    for rows, name in ((slice(0, 1), "height"), (slice(1, 3), "slope"), (slice(3, 6), "curvature")):
        bad = np.argwhere(~np.isfinite(found[rows]).all(axis=0))
        if len(bad):
            i, j = map(int, bad[np.argmin(np.hypot(u, v)[tuple(bad.T)])])
            raise UserCodeError(f"{what}: its {name} is no finite number at {_at(u[i, j], v[i, j])}")
    slope = np.hypot(found[1], found[2])
    i, j = np.unravel_index(np.argmax(slope), slope.shape)
    if slope[i, j] > _STEEPEST:
        at = _at(u[i, j], v[i, j])
        raise UserCodeError(f"{what}: its slope is {slope[i, j]:.3g} at {at}; {_STEEPEST:g} is the most")
    for axis in (0, 1):
        steps = np.abs(np.diff(found[:3], axis=axis + 1))
        for row, name in enumerate(("height", "slope along u", "slope along v")):
            i, j = np.unravel_index(np.argmax(steps[row]), steps[row].shape)
            k, m = (i + 1, j) if axis == 0 else (i, j + 1)
            line = (np.linspace(u[i, j], u[k, m], _FINER + 1), np.linspace(v[i, j], v[k, m], _FINER + 1))
            finer = np.abs(np.diff(sampled(*line)[row]))
            at = int(np.argmax(finer))
            if finer[at] > 0.5 * steps[row, i, j] > 1e-9:
                where = _at(line[0][at], line[1][at])
                raise UserCodeError(f"{what}: its {name} jumps by {finer[at]:.3g} at {where}: make it smooth")


def require_closest(what: str, touch: ca.Function, numbers: np.ndarray, half: tuple[float, float]) -> None:
    """Raise a `UserCodeError` unless feet and normals of a surface fit each other, and the origin lies on it.

    Args:
        what: the surface in messages.
        touch: of numbers and a point: outward normal at the closest one and signed distance, (4,).
        numbers: of the surface.
        half: of its extent along u and v, m.
    """

    def touched(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = np.asarray(touch(numbers, points.T).full())
        return found[:3].T, found[3]

    u, v = (x.ravel() for x in np.meshgrid(*(np.linspace(-side, side, _SIDE) for side in half)))
    points = np.stack([np.full(u.shape, -_BEFORE), u, v], axis=-1)
    normals, gaps = touched(points)
    _require(what, np.isfinite(gaps) & np.isfinite(normals).all(axis=1), points, "is no finite number")
    unit = np.abs(np.linalg.norm(normals, axis=1) - 1.0) < _TOLERANCE
    _require(what, unit, points, "gives a normal whose length is not 1")
    feet = points - gaps[:, None] * normals
    for lifted in (0.0, 1e-3):
        again, gap = touched(feet + lifted * normals)
        fits = np.abs(gap - lifted) < _TOLERANCE
        if lifted:
            fits &= np.abs(again - normals).max(axis=1) < 1e-3
        _require(what, fits, feet + lifted * normals, "is not the point that it gave of one farther out")
    # A normal that is the way from foot to point turns round behind the surface, where it must not.
    normals, gaps = touched(np.array([[-1e-3, 0.0, 0.0], [0.0, 0.0, 0.0], [1e-3, 0.0, 0.0]]))
    if not abs(gaps[1]) < _TOLERANCE:
        raise UserCodeError(
            f"{what}: the origin, w = u = v = 0, must lie on it; closest says that it is {gaps[1]:.3g} m away"
        )
    if not (gaps[2] < 0.0 < gaps[0] and np.abs(normals[2] - normals[0]).max() < 0.1):
        raise UserCodeError(f"{what}: the normal of closest must stay outward for a point behind the surface")


def _require(what: str, holds: np.ndarray, points: np.ndarray, problem: str) -> None:
    if not holds.all():
        w, u, v = points[np.argmin(holds)]
        raise UserCodeError(f"{what}: closest {problem}, at w = {w:.3g} m, {_at(u, v)}")


def _at(u: float, v: float) -> str:
    return f"u = {u:.3g} m, v = {v:.3g} m"
