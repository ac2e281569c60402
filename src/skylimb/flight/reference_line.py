"""The line that a drawing asks for, as the log keeps it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from skylimb.control.planning.trajectories import drawing_strokes
from skylimb.control.planning.trajectory_config import TrajectoryConfig


def with_reference_line(log: xr.Dataset, trajectory: TrajectoryConfig) -> xr.Dataset:
    """The log with the strokes of a drawing as the variable `reference_line`; other paths leave it as it is.

    `reference_line` (reference_point, plane) holds u and v about `path_center` along the sliding axes, m; a
    row of NaN stands between two strokes. So a log is read without the file that was drawn. Of a drawing with
    a force and a soft pen, `reference_width` holds the width of the line at each of these points, m.
    """
    if trajectory.shape != "drawing":
        return log
    gap = np.full((1, 2), np.nan)
    strokes = drawing_strokes(trajectory)
    rows = [row for line in strokes.lines for row in (line, gap)][:-1]
    attributes = {
        "units": "m",
        "frame": "sliding plane",
        "long_name": "reference line of the pen, about path_center; NaN between strokes",
        "kind": "reference",
    }
    line = xr.Variable(("reference_point", "plane"), np.vstack(rows), attributes)
    log = log.assign(reference_line=line).assign_coords(plane=["u", "v"])
    if not trajectory.brush:
        return log
    widths = [trajectory.brush * row for force in strokes.widths for row in (force, gap[0, :1])][:-1]
    attributes = {
        "units": "m",
        "long_name": "width of the reference line",
        "kind": "reference",
        "per_force": trajectory.brush,
    }
    return log.assign(reference_width=xr.Variable(("reference_point",), np.concatenate(widths), attributes))
