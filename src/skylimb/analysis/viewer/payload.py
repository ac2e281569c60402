"""Everything that a page needs to show flights again, as one document of plain values."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from skylimb.analysis.figures import palette, scene
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.board import board_of
from skylimb.analysis.scores.signals import contact_axis, sliding_axes, surface_of
from skylimb.analysis.viewer.believed import believed_frame
from skylimb.analysis.viewer.events import packed_events
from skylimb.analysis.viewer.moved import is_moved, moves_of, taken_back, where
from skylimb.analysis.viewer.packing import packed
from skylimb.analysis.viewer.pushes import packed_pushes
from skylimb.analysis.viewer.shapes import body_poses, meshes, shapes, shapes_with_surface, thrust_sites
from skylimb.analysis.viewer.signals import packed_panels, smoothed

RATE = 25.0
"""Poses a second; the page interpolates between them."""


def viewer_payload(runs: Mapping[str, Run]) -> dict[str, Any]:
    """Scenes, motions and plots of flights.

    Args:
        runs: by name; each with a scene in its log.

    Returns:
        Plain values, ready for JSON. Lengths in m, forces in N, times in s, vectors in W.
    """
    colours = palette.colours(runs)
    return {
        "flights": [
            {
                "name": palette.label(name),
                "colour": colours[name],
                "mark": run.mark,
                "cause": run.cause,
                **_scene(run),
                **packed_panels(run.log),
            }
            for name, run in runs.items()
        ]
    }


def _scene(run: Run) -> dict[str, Any]:
    log, times = run.log, run.log.time.values
    model = scene.load_model(str(log.attrs["scene"]), (640, 360))
    board = board_of(log)
    moments = np.arange(times[0], times[-1] + 0.5 / RATE, 1.0 / RATE)
    samples = np.clip(np.searchsorted(times, moments - 1e-9), 0, len(times) - 1)
    configuration = log.configuration.values
    poses = body_poses(model, configuration[samples])
    placed, bodies = shapes(model), model.nbody
    if is_moved(log):
        motion = moves_of(log)
        first = where(log)[0]
        placed, bodies = shapes_with_surface(model, first[:3], first[3:]), bodies + 1
        poses = np.concatenate([poses, where(log)[samples][:, None, :]], axis=1)
    else:
        slid = scene.surface_motion(model, configuration)
        motion = np.pad(slid, ((0, 0), (0, 4)))
        motion[:, 3] = 1.0
    moves = bool(np.any(motion != motion[:1]))
    return {
        "shapes": placed,
        "meshes": meshes(model),
        "bodies": bodies,
        "moments": packed(times[samples]),
        "poses": packed(poses.reshape(len(poses), -1)),
        "rotors": thrust_sites(model) if "thrusts" in log else [],
        "thrusts": packed(log.thrusts.values[samples]) if "thrusts" in log else None,
        "contact": packed(_touch(log)[samples]),
        **packed_events(model, log, samples),
        "pushes": packed_pushes(model, log),
        "surface": packed(motion[samples]) if moves else None,
        "nominal": _segments(scene.nominal_line(log, board), board, motion, times),
        "trace": _segments(scene.pen_trace(log, np.zeros(3)), board, motion, times),
        "camera": scene.eye_and_target(scene.camera_of(log, board)),
        "frame": _believed(log),
    }


def _believed(log: xr.Dataset) -> dict[str, Any] | None:
    """Where the flight believed its surface; None where the log does not know."""
    if "path_center" not in log.attrs:
        return None
    center = json.loads(str(log.attrs["path_center"]))
    return believed_frame(center, contact_axis(log), sliding_axes(log), (surface_of(log) or {}).get("size"))


def _touch(log: xr.Dataset) -> np.ndarray:
    """Place of the tip (m) and the force on it (N, mean over a moment) in W, (k, 6)."""
    if "contact_force" not in log:
        return np.pad(log.tip_position.values, ((0, 0), (0, 3)))
    force = smoothed(log, log.contact_force.values)
    return np.concatenate([log.tip_position.values, force], axis=1)


def _segments(line: scene.DrawnLine, board: Any, motion: np.ndarray, times: np.ndarray) -> dict[str, Any]:
    """Segments of a line with the time from which each is seen, where the surface was first."""
    normal = board.normal if board is not None else np.zeros(3)
    ends = taken_back(line.ends + scene.LIFT * normal, motion[line.since])
    return {"since": packed(times[line.since]), "ends": packed(ends.reshape(len(ends), 6))}
