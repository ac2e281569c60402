"""How hard the tip could have pushed, each way, at moments of a flight.

At a moment the robot has its posture, its heading, and rotors that point where they point. It could rest and
push with p at its tip if

    sum_i lambda_i d_i = R^T (m g z + p),        sum_i lambda_i (r_i x d_i + c_i d_i) = r x R^T p,

with thrusts lambda within their limits, d_i and r_i direction and lever of a rotor, c_i its drag, r the tip
from the centre of gravity, and R a lean from the level by a roll and a pitch, up to `LEAN` to every side. The
farthest p = t d along a direction d is a linear programme but for R. So it is a few of them, each linear
around the last and, after the first few, ever nearer to it; those of all directions are one, as they share
nothing.
"""

from __future__ import annotations

import json
from functools import cache
from typing import Any, NamedTuple

import mujoco
import numpy as np
import xarray as xr
from scipy.optimize import linprog
from scipy.sparse import bsr_array
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from skylimb.analysis.replay.packing import packed
from skylimb.analysis.replay.stance import Stance, stance_at

LEAN = 0.35
"""How far the body may lean into a push, rad (20 degrees)."""

MOMENTS = 6
"""Of a flight, at which pushes are worked out; a page interpolates between them."""

_ROUNDS, _FREE_ROUNDS = 12, 3
"""Linear programmes of a direction; those after the first few halve how far the lean may go from the last."""

_SETTLED = 1e-3
"""What may be left of the weight in force and, by the tip's lever, in torque."""

_PRICE, _SOLVED = 1e3, 1e-6
"""Of what a linear programme leaves over, beside 1 for a push of the weight; how much of it is none."""


@cache
def sphere(rounds: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Directions all around (k, 3) and the triangles between them (f, 3), outside counterclockwise.

    An icosahedron whose edges are halved so many times: 162 directions, 320 triangles.
    """
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    signs = np.array([(a, b) for a in (-1.0, 1.0) for b in (-golden, golden)])
    points = np.vstack([np.roll(np.pad(signs, ((0, 0), (1, 0))), k, axis=1) for k in range(3)])
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(rounds):
        faces = ConvexHull(points).simplices
        edges = {tuple(sorted((int(a), int(b)))) for face in faces for a in face for b in face if a != b}
        points = np.vstack([points, [points[a] + points[b] for a, b in sorted(edges)]])
        points = points / np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = np.sum(np.cross(b - a, c - a) * a, axis=1) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return points, faces


def well_spread(stance: Stance) -> np.ndarray:
    """Directions with the triangles of `sphere` that lie evenly on the pushes' own boundary, (k, 3).

    Few robots push alike in all directions: even directions would leave a flat set with a ragged rim.
    """
    coarse = sphere(1)[0]
    ends = greatest_pushes(stance, coarse).size[:, None] * coarse
    values, axes = np.linalg.eigh(ends.T @ ends + 1e-6 * stance.weight**2 * np.eye(3))
    spread = sphere()[0] @ (axes * np.sqrt(values)) @ axes.T
    return spread / np.linalg.norm(spread, axis=1, keepdims=True)


class Pushes(NamedTuple):
    """The farthest rests along some directions.

    Attributes:
        size: of the push, N; 0 where it cannot rest, (k,).
        lean: of the body, roll and pitch, rad, (k, 2).
    """

    size: np.ndarray
    lean: np.ndarray


def greatest_pushes(
    stance: Stance, directions: np.ndarray, near: Pushes | None = None, lean: float = LEAN
) -> Pushes:
    """The greatest push at rest along each direction.

    Args:
        stance: of the robot.
        directions: unit vectors, W, (k, 3).
        near: where the search begins, as for a stance that is much like this one.
        lean: how far the body may lean, rad.
    """
    count = len(directions)
    found = Pushes(np.zeros(count), np.zeros((count, 2))) if near is None else near
    scale = _scale(stance)
    size, leans = found.size.copy(), found.lean.copy()
    open_, settled = np.arange(count), np.zeros(count, dtype=bool)
    for k in range(_ROUNDS):
        step = 2.0 * lean * 0.5 ** max(k - _FREE_ROUNDS + 1, 0)
        last = Pushes(size[open_], leans[open_])
        thrusts, now = _linear(stance, directions[open_], last, (lean, step), scale)
        left = _left(stance, directions[open_], thrusts, now, scale)
        size[open_], leans[open_] = now
        outside = np.linalg.norm(now.lean, axis=1) - lean
        settled[open_] = np.maximum(left, outside) < _SETTLED
        open_ = np.flatnonzero(~settled)
        if len(open_) == 0:
            break
    return Pushes(np.where(settled, size, 0.0), leans)


def _scale(stance: Stance) -> np.ndarray:
    """1 over the weight, and over the torque that it makes at the tip's lever, (6,)."""
    length = max(float(np.linalg.norm(stance.lever)), 0.1)
    return 1.0 / stance.weight / np.array([1.0, 1.0, 1.0, length, length, length])


def _linear(
    stance: Stance, directions: np.ndarray, near: Pushes, leans: tuple[float, float], scale: np.ndarray
) -> tuple[np.ndarray, Pushes]:
    """Thrusts (k, n), pushes and leans of the programmes that are linear around `near`; zeros without any.

    `leans` are how far the body may lean, and how far about either axis beside the last lean, rad. Beside
    thrusts, lean and push each has what is left over of the wrench, at a price that only those without a
    solution pay. So one that has none leaves the others alone.
    """
    count, n = len(directions), stance.columns.shape[1]
    most = float(stance.high.sum()) + stance.weight
    lean, step = leans
    bounds = np.empty((count, n + 15, 2))
    bounds[:, :n] = np.stack([stance.low, stance.high], axis=1)
    bounds[:, n : n + 2, 0], bounds[:, n : n + 2, 1] = near.lean - step, near.lean + step
    bounds[:, n + 2 :] = 0.0, most
    bounds[:, n + 3 :] = 0.0, np.inf
    up, push = np.array([0.0, 0.0, stance.weight]), near.size[:, None] * directions
    back, slopes = _lean(near.lean, stance.heading)
    weight, along = back @ up, _applied(back, directions)
    turned = np.stack(
        [
            np.hstack([_applied(slope, up + push), np.cross(stance.lever, _applied(slope, push))])
            for slope in slopes
        ],
        axis=2,
    )
    pushed = np.hstack([along, np.cross(stance.lever, along)])[:, :, None]
    columns = np.broadcast_to(stance.columns, (count, *stance.columns.shape))
    wrenches = scale[:, None] * np.concatenate([columns, -turned, -pushed], axis=2)
    left = np.broadcast_to(np.hstack([np.eye(6), -np.eye(6)]), (count, 6, 12))
    blocks = np.concatenate([wrenches, left], axis=2)
    inside = np.zeros((count, 1, n + 15))
    inside[:, 0, n : n + 2] = near.lean
    # The lean itself is sought, not its change.
    sides = scale * (np.pad(weight, ((0, 0), (0, 3))) - _applied(turned, near.lean))
    found = linprog(
        np.tile([*[0.0] * (n + 2), -1.0 / stance.weight, *[_PRICE] * 12], count),
        A_eq=bsr_array((blocks, np.arange(count), np.arange(count + 1))).tocsr(),
        b_eq=sides.ravel(),
        # lean^2 <= limit^2, linear around the last lean as all else.
        A_ub=bsr_array((inside, np.arange(count), np.arange(count + 1))).tocsr(),
        b_ub=0.5 * (lean**2 + np.sum(near.lean**2, axis=1)),
        bounds=bounds.reshape(-1, 2),
    )
    if found.status != 0:
        return np.zeros((count, n)), Pushes(np.zeros(count), np.zeros((count, 2)))
    x = found.x.reshape(count, n + 15)
    x[x[:, n + 3 :].sum(axis=1) > _SOLVED] = 0.0
    return x[:, :n], Pushes(x[:, n + 2], x[:, n : n + 2])


def _applied(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Each matrix (k, m, j) times its vector (k, j), (k, m)."""
    return (matrices @ vectors[:, :, None])[:, :, 0]


def _left(
    stance: Stance, directions: np.ndarray, thrusts: np.ndarray, found: Pushes, scale: np.ndarray
) -> np.ndarray:
    """What is left over of force and torque, as a share of the weight, (k,)."""
    back = _back(found.lean, stance.heading)
    push = found.size[:, None] * directions
    force = _applied(back, push + np.array([0.0, 0.0, stance.weight]))
    torque = np.cross(stance.lever, _applied(back, push))
    return np.abs((thrusts @ stance.columns.T - np.hstack([force, torque])) * scale).max(axis=1)


def _lean(leans: np.ndarray, heading: float) -> tuple[np.ndarray, list[np.ndarray]]:
    """R^T of leans (k, 2), (k, 3, 3), and its derivatives by roll and by pitch."""
    step = 1e-6
    slopes = [
        (_back(leans + e, heading) - _back(leans - e, heading)) / (2.0 * step) for e in step * np.eye(2)
    ]
    return _back(leans, heading), slopes


def _back(leans: np.ndarray, heading: float) -> np.ndarray:
    """R^T of leans by roll and pitch (k, 2), rad, about the axes of a heading, (k, 3, 3)."""
    angles = np.pad(leans[:, ::-1], ((0, 0), (1, 0)), constant_values=heading)
    # Turned to the heading, leaned, and turned back.
    return (Rotation.from_euler("z", heading) * Rotation.from_euler("ZYX", angles).inv()).as_matrix()


def packed_pushes(model: mujoco.MjModel, log: xr.Dataset) -> dict[str, Any] | None:
    """The greatest pushes of a flight for a page; None where the log does not tell what they take.

    Returns:
        `moments` (s), `pushes` (N, a column for each direction), `directions` and `faces`.
    """
    if "thrust_limits" not in log.attrs or not {"tip_position", "attitude"} <= set(log):
        return None
    limits = np.asarray(json.loads(log.attrs["thrust_limits"]), dtype=float)
    samples = np.unique(np.linspace(0, log.sizes["time"] - 1, MOMENTS).astype(int))
    data, (directions, faces) = mujoco.MjData(model), sphere()
    found: list[np.ndarray] = []
    near: Pushes | None = None
    for k in samples:
        configuration = log.configuration.values[k]
        attitude, tip = log.attitude.values[k], log.tip_position.values[k]
        if not np.isfinite(configuration).all():
            return None
        stance = stance_at(model, data, configuration, attitude, tip, limits)
        if stance is None:
            return None
        if near is None:
            directions = well_spread(stance)
        near = greatest_pushes(stance, directions, near)
        found.append(near.size)
    return {
        "moments": packed(log.time.values[samples]),
        "pushes": packed(np.array(found)),
        "directions": directions.round(4).ravel().tolist(),
        "faces": faces.ravel().tolist(),
    }
