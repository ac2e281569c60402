"""How well the pen drew its reference line, seen along the contact axis.

Everything here lives in the sliding plane: (u, v) along the log's sliding axes about its `path_center`, m. So
a line on a curved surface is judged as one sees it from the robot. A path around a post is unrolled from the
post that it is bent around: seen from before it, its back would lie on its front.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.board import nominal_path
from skylimb.analysis.scores.nearest import nearest
from skylimb.analysis.scores.score import PEN, Score, metric
from skylimb.analysis.scores.signals import (
    contact_axis,
    in_contact,
    in_phase,
    phase_names,
    post_axis,
    sliding_axes,
    stretches,
)

if TYPE_CHECKING:
    import xarray as xr

PITCH = 0.0005
"""Spacing at which a line is looked up, m."""


@metric(
    keys={
        "rms": Score(
            "Distance of the pen from its reference line, root mean square",
            "m",
            smaller_is_better=True,
            group=PEN,
            row="root mean square",
            ranked=False,
        ),
        "max": Score(
            "Largest distance of the pen from its reference line",
            "m",
            smaller_is_better=True,
            group=PEN,
            row="largest",
            ranked=False,
        ),
    }
)
def pen_line(run: Run) -> dict[str, float]:
    """Distance of the drawn line from the reference line, over the samples in touch of the sliding period.

    A lift between two strokes belongs to it: a pen that does not leave the surface draws there. No number
    where the pen touched nothing, or the log does not say where the tip or its reference was.
    """
    away = pen_deviation(run.log)
    if not len(away):
        return {"rms": np.nan, "max": np.nan}
    return {"rms": float(np.sqrt(np.mean(away**2))), "max": float(away.max())}


def pen_deviation(log: xr.Dataset) -> np.ndarray:
    """Distance of every drawn sample to the nearest point of the reference line, m, (n,); empty for none."""
    lines = [dense(line) for line in reference_line(log)]
    _, drawn = drawn_samples(log)
    if not lines or not len(drawn):
        return np.zeros(0)
    begins = np.vstack([line[:-1] for line in lines])
    ends = np.vstack([line[1:] for line in lines])
    # The pieces are so short that the nearest one has the nearest middle, or is a neighbour of that one.
    middle = nearest(drawn, 0.5 * (begins + ends))
    candidates = np.clip(middle[:, None] + np.arange(-1, 2), 0, len(begins) - 1)
    return _to_pieces(drawn[:, None, :], begins[candidates], ends[candidates]).min(axis=1)


def drawn_samples(log: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """The samples in touch of the sliding period, lifts included: numbers, and (u, v) of the tip (n, 2)."""
    samples, points = marks(log)
    drawing = in_phase(log, "slide")
    if "lift" in phase_names(log):
        drawing |= in_phase(log, "lift")
    return samples[drawing[samples]], points[drawing[samples]]


def marks(log: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """The samples of every touch, from the first to the last: numbers, and (u, v) of the tip (n, 2)."""
    if "tip_position" not in log:
        return np.zeros(0, dtype=int), np.zeros((0, 2))
    samples = np.flatnonzero(in_contact(log))
    points = in_plane(log, log.tip_position.values, samples)
    finite = np.isfinite(points).all(axis=1)
    return samples[finite], points[finite]


def reference_line(log: xr.Dataset) -> list[np.ndarray]:
    """The strokes that the pen is to draw, (n, 2) each, m; none where the log has no reference.

    A drawing's are in the log as `reference_line`. For any other path it is the tip's own reference, or in a
    log without one the line that a pen held still in the robot would draw if the centre of gravity kept to
    its.
    """
    if "reference_line" in log:
        return [part for part in between_gaps(log.reference_line.values) if len(part) > 1]
    if "tip_position_reference" in log:
        path = in_plane(log, log.tip_position_reference.values, in_phase(log, "slide"))
    elif {"tip_position", "cog_position", "cog_position_reference"} <= set(log.variables):
        path = in_plane(log, nominal_path(log, None))
    else:
        return []
    moved = np.concatenate([[True], np.linalg.norm(np.diff(path, axis=0), axis=1) > 0.0]) if len(path) else []
    path = path[np.asarray(moved, dtype=bool)]
    return [path] if len(path) > 1 else []


def between_gaps(points: np.ndarray) -> list[np.ndarray]:
    """The parts of a line (n, k) between rows that are no numbers."""
    return [points[begin:end] for begin, end in stretches(np.asarray(np.isfinite(points).all(axis=1)))]


def as_seen(log: xr.Dataset, points: np.ndarray) -> np.ndarray:
    """Points of the sliding plane as one sees them from the robot: to the right and up, (n, 2), m."""
    u, v = sliding_axes(log)
    right = np.cross(contact_axis(log).vector, v.vector)
    return points * [1.0 if u.vector @ right > 0.0 else -1.0, 1.0]


def in_plane(log: xr.Dataset, points: np.ndarray, samples: Any = slice(None)) -> np.ndarray:
    """(u, v) of points in W about the middle of the path, m, (n, 2).

    Args:
        log: a run's log.
        points: (k, 3), m; around a post those of every sample: their way tells in which turn they are.
        samples: that are asked for, as an index of `points`.
    """
    middle = log.attrs.get("path_center")
    offset = np.asarray(json.loads(middle) if middle else np.zeros(3), dtype=float)
    plane = np.stack([axis.along(points[samples] - offset) for axis in sliding_axes(log)], axis=1)
    post = post_axis(log)
    if post is not None:
        plane[:, 0] = float(log.attrs["wrap_radius"]) * _turned(log, points, post)[samples]
    return plane


def _turned(log: xr.Dataset, points: np.ndarray, post: np.ndarray) -> np.ndarray:
    """Angles of points (n, 3) around a post, rad, (n,); 0 at the middle of the path.

    They begin in the turn in which the reference begins, and that has its middle within half a turn of 0.
    """
    a, u = contact_axis(log).vector, sliding_axes(log)[0].vector

    def way(places: np.ndarray) -> np.ndarray:
        angles = np.arctan2((places - post) @ u, (post - places) @ a)
        known = np.isfinite(angles)
        angles[known] = np.unwrap(angles[known])
        return angles

    def in_turn(angles: np.ndarray, place: float) -> np.ndarray:
        return angles - 2.0 * np.pi * np.round(place / (2.0 * np.pi))

    wanted = way(log.tip_position_reference.values if "tip_position_reference" in log else points)
    wanted = in_turn(wanted, 0.5 * (np.nanmin(wanted) + np.nanmax(wanted)))
    found = way(points)
    return in_turn(found, found[np.isfinite(found)][0] - wanted[0]) if np.isfinite(found).any() else found


def dense(line: np.ndarray, pitch: float = PITCH) -> np.ndarray:
    """The same line with more points, `pitch` (m) apart at most."""
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    counts = np.maximum(np.ceil(lengths / pitch).astype(int), 1)
    piece = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(piece)) - np.repeat(np.cumsum(counts) - counts, counts)
    places = np.append(piece + within / counts[piece], len(line) - 1.0)
    return np.stack([np.interp(places, np.arange(len(line)), axis) for axis in line.T], axis=1)


def _to_pieces(points: np.ndarray, begins: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Distances of points (..., 2) to straight pieces between `begins` and `ends`."""
    sides = ends - begins
    lengths = np.maximum(np.sum(sides**2, axis=-1), 1e-300)
    along = np.clip(np.sum((points - begins) * sides, axis=-1) / lengths, 0.0, 1.0)
    return np.linalg.norm(points - begins - along[..., None] * sides, axis=-1)
