"""When the pen is where: a drawing's strokes on the clock.

The strokes are rounded by at most `ROUNDING` at gentle corners, and the pen stops at sharp ones. Along each
stretch between two stops the speed is the largest that keeps to the allowed speed and acceleration, bends
counted, found by one pass forward and one back. The motion in time is a cubic B-spline through the plane:
twice continuously differentiable, and no faster and no sharper than its control points.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skylimb.base.rotations import wrapped
from skylimb.control.planning.drawing import Strokes

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

SHARP = math.radians(60.0)
"""A corner that turns by more is a stop."""
ROUNDING = 0.001
"""How far the path may pass from a corner that it does not stop at, m."""
_PITCH = 0.0005
"""Spacing of the points at which speeds are found, m."""
_REACH = 6.0 * ROUNDING
"""Half the width of the triangular window that rounds: at a turn of one radian it is off by a sixth of it."""
_KNOT = 0.05
"""Time between two control points, s."""


@dataclass(frozen=True)
class PenMotion:
    """The motion of a pen.

    Attributes:
        duration: s.
        position: times within the duration to (u, v), m, and the width of the line there, if it has one.
        lifts: for each way between two strokes when the pen starts to leave the surface and when it starts to
            come back, s.
    """

    duration: float
    position: BSpline
    lifts: tuple[tuple[float, float], ...]


def pen_motion(strokes: Strokes, speed: float, acceleration: float, lift_time: float) -> PenMotion:
    """Strokes drawn one after another, at rest at both ends of each.

    Args:
        strokes: in the sliding plane, m. A width goes along, as smooth as the path.
        speed: largest, m/s.
        acceleration: largest, m/s^2.
        lift_time: how long the path rests before and after the way from stroke to stroke, s.
    """
    from scipy.interpolate import BSpline  # slow to import, and few flights draw

    lines = strokes.columns
    controls = [lines[0][:1]] * 3  # at rest to begin with
    steps = 1
    lifts = []
    for index, line in enumerate(lines):
        if index:
            before = lines[index - 1][-1]
            rest = math.ceil(lift_time / _KNOT - 1e-9)
            way = _timed(np.array([before, line[0]]), speed, acceleration)
            lifts.append((steps, steps + rest + len(way)))
            controls += [np.tile(before, (rest, 1)), way, np.tile(line[0], (rest, 1))]
            steps += 2 * rest + len(way)
        for stretch in _stretches(line):
            points = _timed(_rounded(stretch), speed, acceleration)
            controls.append(points)
            steps += len(points)
    points = np.vstack([*controls, *[lines[-1][-1:]] * 2])
    # The second control point is at time 0, the last but one at the end.
    knots = _KNOT * (np.arange(len(points) + 4) - 3.0)
    return PenMotion(
        _KNOT * (len(points) - 3),
        BSpline(knots, points, 3),
        tuple((_KNOT * leave, _KNOT * back) for leave, back in lifts),
    )


def _stretches(line: np.ndarray) -> list[np.ndarray]:
    """A stroke cut at its sharp corners."""
    sides = np.diff(line[:, :2], axis=0)
    headings = np.arctan2(sides[:, 1], sides[:, 0])
    turns = np.abs(wrapped(np.diff(headings)))
    cuts = [0, *(np.flatnonzero(turns > SHARP) + 1).tolist(), len(line) - 1]
    return [line[begin : end + 1] for begin, end in itertools.pairwise(cuts)]


def _rounded(line: np.ndarray) -> np.ndarray:
    """A stretch at an even pitch, its corners rounded by a triangular window over its length; ends stay."""
    from scipy.ndimage import uniform_filter1d  # slow to import, and few flights draw

    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1))])
    pieces = max(math.ceil(way[-1] / _PITCH), 2)
    even = np.linspace(0.0, way[-1], pieces + 1)
    points = np.stack([np.interp(even, way, axis) for axis in line.T], axis=1)
    window = min(round(_REACH / _PITCH), pieces // 2) // 2 * 2 + 1
    if len(line) < 3 or window < 3:
        return points
    padded = np.pad(points, ((window, window), (0, 0)), mode="reflect", reflect_type="odd")
    for _ in range(2):
        padded = uniform_filter1d(padded, window, axis=0)
    rounded = padded[window:-window]
    rounded[[0, -1]] = points[[0, -1]]
    return rounded


def _timed(points: np.ndarray, speed: float, acceleration: float) -> np.ndarray:
    """Positions along a stretch every `_KNOT` s, from rest to rest, without the first."""
    if len(points) == 2:
        points = _rounded(points)
    steps = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    speeds = _speeds(points[:, :2], steps, speed, acceleration)
    spent = np.zeros_like(steps)
    np.divide(2.0 * steps, speeds[1:] + speeds[:-1], out=spent, where=steps > 0.0)
    times = np.concatenate([[0.0], np.cumsum(spent)])
    count = max(math.ceil(times[-1] / _KNOT - 1e-9), 1)
    # Slowed down a little, so that it ends on a control point.
    ticks = np.linspace(0.0, times[-1], count + 1)[1:]
    cell = np.clip(np.searchsorted(times, ticks, side="right") - 1, 0, len(steps) - 1)
    since, whole = ticks - times[cell], np.where(spent[cell] > 0.0, spent[cell], 1.0)
    along = way[cell] + since * (speeds[cell] + 0.5 * (speeds[cell + 1] - speeds[cell]) * since / whole)
    return np.stack([np.interp(along, way, axis) for axis in points.T], axis=1)


def _speeds(points: np.ndarray, steps: np.ndarray, speed: float, acceleration: float) -> np.ndarray:
    """The largest speeds at the points (m/s), zero at both ends, whose acceleration stays within bounds.

    What a bend takes of the acceleration is not left for speeding up or slowing down.
    """
    bend = np.zeros(len(points))
    pitch = np.maximum(0.5 * (steps[1:] + steps[:-1]), 1e-9)
    bend[1:-1] = np.linalg.norm(np.diff(points, n=2, axis=0), axis=1) / pitch**2
    squares = np.minimum(speed**2, acceleration / np.maximum(bend, 1e-12))
    squares[[0, -1]] = 0.0
    found = squares.tolist()
    bends, lengths = bend.tolist(), steps.tolist()
    for there, here in [(i + 1, i) for i in range(len(lengths))] + [
        (i, i + 1) for i in reversed(range(len(lengths)))
    ]:
        along = math.sqrt(max(acceleration**2 - (found[here] * bends[here]) ** 2, 0.0))
        found[there] = min(found[there], found[here] + 2.0 * along * lengths[min(here, there)])
    return np.sqrt(found)
