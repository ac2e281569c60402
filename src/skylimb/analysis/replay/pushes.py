"""How hard the tip could have pushed, each way, at moments of a flight.

At a moment the robot has its posture, its attitude, and rotors that point where they point. It could rest and
push with p at its tip if

    sum_i lambda_i d_i = R^T (m g z + p),        sum_i lambda_i (r_i x d_i + c_i d_i) = r x R^T p,

with thrusts lambda within their limits, d_i and r_i direction and lever of a rotor, c_i its drag, r the tip
from the centre of gravity, and R a lean about the two level axes, up to `LEAN` about each. The farthest
p = t d along a direction d is a linear programme but for R. So it is a few of them, each linear around the
last; those of all directions are one, as they share nothing.
"""

from __future__ import annotations

import json
from functools import cache
from typing import Any, NamedTuple

import mujoco
import numpy as np
import xarray as xr
from scipy.optimize import linprog
from scipy.sparse import block_diag, csr_matrix
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from skylimb.analysis.replay.packing import packed

LEAN = 0.35
"""How far the body may lean into a push about either level axis, rad (20 degrees)."""

MOMENTS = 6
"""Of a flight, at which pushes are worked out; a page interpolates between them."""

_ROUNDS = 8
_SETTLED = 1e-3
"""What may be left of the weight in force and, by the tip's lever, in torque."""

_GRAVITY = 9.80665


class Stance(NamedTuple):
    """A robot at a moment; vectors in W.

    Attributes:
        columns: force (N) and torque about the centre of gravity (N m) of each rotor for 1 N, (6, n).
        low: least thrusts, N, (n,).
        high: greatest thrusts, N, (n,).
        weight: N.
        lever: from the centre of gravity to the tip, m, (3,).
    """

    columns: np.ndarray
    low: np.ndarray
    high: np.ndarray
    weight: float
    lever: np.ndarray


@cache
def sphere(rounds: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Directions all around (k, 3) and the triangles between them (f, 3), outside counterclockwise.

    An icosahedron whose edges are halved so many times: 162 directions, 320 triangles.
    """
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    signs = np.array([(a, b) for a in (-1.0, 1.0) for b in (-golden, golden)])
    points = np.vstack([np.roll(np.pad(signs, ((0, 0), (1, 0))), k, axis=1) for k in range(3)])
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
        lean: of the body, rotation vector about x and y, rad, (k, 2).
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
        lean: how far the body may lean about either level axis, rad.
    """
    count = len(directions)
    found = Pushes(np.zeros(count), np.zeros((count, 2))) if near is None else near
    scale = _scale(stance)
    size, leans = found.size.copy(), found.lean.copy()
    open_, settled = np.arange(count), np.zeros(count, dtype=bool)
    for _ in range(_ROUNDS):
        thrusts, now = _linear(stance, directions[open_], Pushes(size[open_], leans[open_]), lean, scale)
        left = _left(stance, directions[open_], thrusts, now, scale)
        size[open_], leans[open_] = now
        settled[open_] = left < _SETTLED
        open_ = np.flatnonzero(~settled)
        if len(open_) == 0:
            break
    return Pushes(np.where(settled, size, 0.0), leans)


def _scale(stance: Stance) -> np.ndarray:
    """1 over the weight, and over the torque that it makes at the tip's lever, (6,)."""
    length = max(float(np.linalg.norm(stance.lever)), 0.1)
    return 1.0 / stance.weight / np.array([1.0, 1.0, 1.0, length, length, length])


def _linear(
    stance: Stance, directions: np.ndarray, near: Pushes, lean: float, scale: np.ndarray
) -> tuple[np.ndarray, Pushes]:
    """Thrusts (k, n), pushes and leans of the programmes that are linear around `near`; zeros without any."""
    count, n = len(directions), stance.columns.shape[1]
    one = [*zip(stance.low, stance.high, strict=True), (-lean, lean), (-lean, lean)]
    one.append((0.0, float(stance.high.sum()) + stance.weight))
    up, blocks, sides = np.array([0.0, 0.0, stance.weight]), [], []
    for d, push, tilt in zip(directions, near.size, near.lean, strict=True):
        back, slopes = _lean(tilt)
        force = np.stack([slope @ (up + push * d) for slope in slopes], axis=1)
        torque = np.stack([np.cross(stance.lever, slope @ (push * d)) for slope in slopes], axis=1)
        along = np.concatenate([back @ d, np.cross(stance.lever, back @ d)])
        turned = np.vstack([force, torque])
        blocks.append(csr_matrix(scale[:, None] * np.column_stack([stance.columns, -turned, -along])))
        # The lean itself is sought, not its change.
        sides.append(scale * (np.concatenate([back @ up, np.zeros(3)]) - turned @ tilt))
    found = linprog(
        np.tile([*[0.0] * (n + 2), -1.0 / stance.weight], count),
        A_eq=block_diag(blocks, format="csr"),
        b_eq=np.concatenate(sides),
        bounds=one * count,
    )
    if found.status != 0:
        # One of them has no solution near there, so the others are sought without it.
        if count == 1:
            return np.zeros((1, n)), Pushes(np.zeros(1), np.zeros((1, 2)))
        half = count // 2
        parts = [
            _linear(stance, directions[part], Pushes(near.size[part], near.lean[part]), lean, scale)
            for part in (slice(half), slice(half, None))
        ]
        (thrusts, first), (more, second) = parts
        joined = Pushes(*(np.concatenate(pair) for pair in zip(first, second, strict=True)))
        return np.concatenate([thrusts, more]), joined
    x = found.x.reshape(count, n + 3)
    return x[:, :n], Pushes(x[:, n + 2], x[:, n : n + 2])


def _left(
    stance: Stance, directions: np.ndarray, thrusts: np.ndarray, found: Pushes, scale: np.ndarray
) -> np.ndarray:
    """What is left over of force and torque, as a share of the weight, (k,)."""
    back = Rotation.from_rotvec(np.pad(found.lean, ((0, 0), (0, 1)))).inv()
    push = found.size[:, None] * directions
    force = back.apply(push + np.array([0.0, 0.0, stance.weight]))
    torque = np.cross(stance.lever, back.apply(push))
    return np.abs((thrusts @ stance.columns.T - np.hstack([force, torque])) * scale).max(axis=1)


def _lean(tilt: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """R^T of a lean (rotation vector about x and y, rad), and its derivatives by both."""
    step = 1e-6

    def back(lean: np.ndarray) -> np.ndarray:
        return Rotation.from_rotvec([*lean, 0.0]).as_matrix().T

    slopes = [(back(tilt + e) - back(tilt - e)) / (2.0 * step) for e in step * np.eye(2)]
    return back(tilt), slopes


def stance_at(
    model: mujoco.MjModel, data: mujoco.MjData, configuration: np.ndarray, tip: np.ndarray, limits: np.ndarray
) -> Stance | None:
    """The robot of a scene at a configuration; None where it has no rotors.

    Args:
        model: of the scene.
        data: of the model; it is written into.
        configuration: generalised positions, (nq,).
        tip: W, m, (3,).
        limits: least and greatest thrusts, N, (2, n).
    """
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    rotors = np.flatnonzero(model.actuator_trntype == mujoco.mjtTrn.mjTRN_SITE)
    if len(free) == 0 or len(rotors) == 0 or limits.shape != (2, len(rotors)):
        return None
    root = int(model.jnt_bodyid[free[0]])
    data.qpos[:] = configuration
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    cog, columns = data.subtree_com[root].copy(), []
    for actuator in rotors:
        site, gear = model.actuator_trnid[actuator, 0], model.actuator_gear[actuator]
        R = data.site_xmat[site].reshape(3, 3)
        force, drag = R @ gear[:3], R @ gear[3:]
        columns.append(np.concatenate([force, np.cross(data.site_xpos[site] - cog, force) + drag]))
    weight = float(model.body_subtreemass[root]) * _GRAVITY
    return Stance(np.array(columns).T, limits[0], limits[1], weight, tip - cog)


def packed_pushes(model: mujoco.MjModel, log: xr.Dataset) -> dict[str, Any] | None:
    """The greatest pushes of a flight for a page; None where the log does not tell what they take.

    Returns:
        `moments` (s), `pushes` (N, a column for each direction), `directions` and `faces`.
    """
    if "thrust_limits" not in log.attrs or "tip_position" not in log:
        return None
    limits = np.asarray(json.loads(log.attrs["thrust_limits"]), dtype=float)
    samples = np.unique(np.linspace(0, log.sizes["time"] - 1, MOMENTS).astype(int))
    data, (directions, faces) = mujoco.MjData(model), sphere()
    found: list[np.ndarray] = []
    near: Pushes | None = None
    for k in samples:
        configuration = log.configuration.values[k]
        stance = stance_at(model, data, configuration, log.tip_position.values[k], limits)
        if stance is None or not np.isfinite(configuration).all():
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
