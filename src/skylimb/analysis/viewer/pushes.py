"""How hard the tip could have pushed, each way, at moments of a flight.

At a moment the robot has its posture, its heading, and rotors that point where they point. It could rest and
push with p at its tip if forces and torques balance (`skylimb.base.statics`), with thrusts and the torques
of its servos within their limits, leaning up to `LEAN` to any side. The farthest p = t d along a direction d
is a linear programme but for the lean. So it is a few of them, each linear around the last and, after the
first few, ever nearer to it; those of all directions are one, as they share nothing. `robots.equilibrium`
asks the same of one direction, with joints and vectoring angles that move.
"""

from __future__ import annotations

import json
from functools import cache
from itertools import combinations
from typing import Any, NamedTuple

import casadi as ca
import mujoco
import numpy as np
import xarray as xr

from skylimb.analysis.viewer.packing import packed
from skylimb.analysis.viewer.stance import Stance, stance_at
from skylimb.base.statics import rest_function

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

_LEFT = np.hstack([np.eye(6), -np.eye(6), np.zeros((6, 1))])
"""How what is left over of the wrench, both ways, and of the servos stands in the wrench's rows."""


@cache
def sphere(rounds: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Directions all around (k, 3) and the triangles between them (f, 3), outside counterclockwise.

    An icosahedron whose edges are halved so many times: 162 directions, 320 triangles.
    """
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    signs = np.array([(a, b) for a in (-1.0, 1.0) for b in (-golden, golden)])
    points = np.vstack([np.roll(np.pad(signs, ((0, 0), (1, 0))), k, axis=1) for k in range(3)])
    beside = np.linalg.norm(points[:, None] - points, axis=2) < 2.1  # an edge is 2 long
    three = (
        face for face in combinations(range(12), 3) if all(beside[a, b] for a, b in combinations(face, 2))
    )
    faces = np.array([face if np.linalg.det(points[list(face)]) > 0.0 else face[::-1] for face in three])
    for _ in range(rounds):
        sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        edges, numbers = np.unique(sides, axis=0, return_inverse=True)
        (a, b, c), (ab, bc, ca_) = faces.T, len(points) + numbers.reshape(-1, 3).T
        quarters = (a, ab, ca_), (ab, b, bc), (ca_, bc, c), (ab, bc, ca_)
        faces = np.vstack([np.stack(quarter, axis=1) for quarter in quarters])
        points = points / np.linalg.norm(points, axis=1, keepdims=True)
        points = np.vstack([points, points[edges].sum(axis=1)])
    return points / np.linalg.norm(points, axis=1, keepdims=True), faces


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
        state: thrusts (N), roll and pitch (rad), and size, (k, n + 3).
    """

    size: np.ndarray
    state: np.ndarray


def greatest_pushes(stance: Stance, directions: np.ndarray, near: Pushes | None = None) -> Pushes:
    """The greatest push at rest along each direction.

    Args:
        stance: of the robot.
        directions: unit vectors, W, (k, 3).
        near: where the search begins, as for a stance that is much like this one.
    """
    count = len(directions)
    state = np.zeros((count, len(stance.low) + 3)) if near is None else near.state.copy()
    open_, settled = np.arange(count), np.zeros(count, dtype=bool)
    for k in range(_ROUNDS):
        step = 2.0 * LEAN * 0.5 ** max(k - _FREE_ROUNDS + 1, 0)
        state[open_] = _linear(stance, directions[open_], state[open_], step)
        settled[open_] = _missed(stance, directions[open_], state[open_]) < _SETTLED
        open_ = np.flatnonzero(~settled)
        if len(open_) == 0:
            break
    return Pushes(np.where(settled, state[:, -1], 0.0), state)


@cache
def _around(rotors: int, servos: int) -> ca.Function:
    """(state, d, C, V, J_c, J_r, r, m g) -> what is left over, the servos' torques, and both by the state."""
    rest = rest_function(rotors, servos)
    given = [ca.SX.sym(rest.name_in(i), rest.size1_in(i), rest.size2_in(i)) for i in range(6)]
    state, d = ca.SX.sym("state", rotors + 3), ca.SX.sym("d", 3)
    values = ca.vertcat(*rest(*given, state[rotors : rotors + 2], state[:rotors], state[-1] * d))
    outputs = [values, ca.densify(ca.jacobian(values, state))]
    return ca.Function("around", [state, d, *given], outputs, {"cse": True})


def _evaluated(stance: Stance, directions: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Left over (of the weight) and torques (of the limits), (k, 6 + m), and what they are by the state."""
    sin, cos = np.sin(stance.heading), np.cos(stance.heading)
    turned = directions @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    function = _around(len(stance.low), len(stance.torques)).map(len(state))
    parts = stance.columns, stance.loads, stance.cog_jacobian, stance.tip_jacobian, stance.lever
    values, slopes = (part.full() for part in function(state.T, turned.T, *parts, stance.weight))
    length = max(float(np.linalg.norm(stance.lever)), 0.1)
    scale = 1.0 / np.concatenate([stance.weight * np.array([1.0, 1.0, 1.0, *[length] * 3]), stance.torques])
    slopes = slopes.reshape(len(scale), len(state), -1).transpose(1, 0, 2)
    return values.T * scale, slopes * scale[:, None]


def _linear(stance: Stance, directions: np.ndarray, near: np.ndarray, step: float) -> np.ndarray:
    """The solutions of the programmes that are linear around `near`; zeros without any.

    `step` is how far the body may lean about either axis beside the last lean. Beside its state each has what
    is left over of the wrench, and of the servos, at a price that only those without a solution pay. So one
    that has none leaves the others alone.
    """
    (count, size), n, servos = near.shape, len(stance.low), len(stance.torques)
    values, slopes = _evaluated(stance, directions, near)
    held = (slopes @ near[:, :, None])[:, :, 0] - values
    most = float(stance.high.sum()) + stance.weight
    low, high = np.zeros((count, size + 13)), np.full((count, size + 13), np.inf)
    low[:, :n], high[:, :n] = stance.low, stance.high
    low[:, n : n + 2], high[:, n : n + 2] = near[:, n : n + 2] - step, near[:, n : n + 2] + step
    high[:, n + 2] = most
    # Of each: the wrench, the lean's square linear around the last lean as all else, and the torques.
    rows = np.zeros((count, 7 + 2 * servos, size + 13))
    rows[:, :6] = np.concatenate([slopes[:, :6], np.tile(_LEFT, (count, 1, 1))], axis=2)
    rows[:, 6, n : n + 2] = near[:, n : n + 2]
    rows[:, 7 : 7 + servos, :size], rows[:, 7 + servos :, :size] = slopes[:, 6:], -slopes[:, 6:]
    rows[:, 7:, -1] = -1.0
    within = 0.5 * (LEAN**2 + np.sum(near[:, n : n + 2] ** 2, axis=1))
    most_of_rows = np.column_stack([held[:, :6], within, 1.0 + held[:, 6:], 1.0 - held[:, 6:]])
    least_of_rows = np.where(np.arange(7 + 2 * servos) < 6, most_of_rows, -np.inf)
    together = ca.diagcat(*map(ca.DM, rows))
    shapes = {"a": together.sparsity(), "h": ca.Sparsity(count * (size + 13), count * (size + 13))}
    solver = ca.conic("pushes", "highs", shapes, {"error_on_fail": False, "highs": {"output_flag": False}})
    found = solver(
        g=np.tile([*[0.0] * (n + 2), -1.0 / stance.weight, *[_PRICE] * 13], count),
        a=together,
        lba=least_of_rows.ravel(),
        uba=most_of_rows.ravel(),
        lbx=low.ravel(),
        ubx=high.ravel(),
    )
    if not solver.stats()["success"]:
        return np.zeros((count, size))
    x = found["x"].full().reshape(count, size + 13)
    x[x[:, size:].sum(axis=1) > _SOLVED] = 0.0
    return x[:, :size]


def _missed(stance: Stance, directions: np.ndarray, state: np.ndarray) -> np.ndarray:
    """By how much each is beyond what it may be: of the weight, of a servo's torque, of the lean, (k,)."""
    values, _ = _evaluated(stance, directions, state)
    over = np.abs(values[:, 6:]).max(axis=1, initial=0.0) - 1.0
    outside = np.linalg.norm(state[:, -3:-1], axis=1) - LEAN
    return np.max([np.abs(values[:, :6]).max(axis=1), over, outside], axis=0)


def packed_pushes(model: mujoco.MjModel, log: xr.Dataset) -> dict[str, Any] | None:
    """The greatest pushes of a flight for a page; None where the log does not tell what they take.

    Returns:
        `moments` (s), `pushes` (N, a column for each direction), `directions` and `faces`.
    """
    if "thrust_limits" not in log.attrs:
        return None
    limits = np.asarray(json.loads(log.attrs["thrust_limits"]), dtype=float)
    samples = np.unique(np.linspace(0, log.sizes["time"] - 1, MOMENTS).astype(int))
    data, (directions, faces) = mujoco.MjData(model), sphere()
    found: list[np.ndarray] = []
    near: Pushes | None = None
    for k in samples:
        configuration = log.configuration.values[k]
        finite = np.isfinite(configuration).all()
        stance = stance_at(model, data, configuration, limits) if finite else None
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
