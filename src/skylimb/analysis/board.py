"""The board's own coordinates, and the lines on it: the one drawn and the one that was meant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from skylimb.analysis.signals import contact_axis, in_contact, in_phase, sliding_axes, spans, surface_of


@dataclass(frozen=True)
class Board:
    """A frame on the surface, as one sees it from the side on which the robot flies.

    Attributes:
        origin: a point of the surface in W, m.
        right: unit vector in W, to the right as seen from the robot.
        up: unit vector in W, upward along the surface.
        normal: unit vector in W, out of the surface toward the robot.
    """

    origin: np.ndarray
    right: np.ndarray
    up: np.ndarray
    normal: np.ndarray

    def coordinates(self, points: np.ndarray) -> np.ndarray:
        """Points in W, shape (n, 3), as coordinates (right, up) on the board, shape (n, 2), m."""
        offset = points - self.origin
        return np.stack([offset @ self.right, offset @ self.up], axis=1)

    def project(self, points: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Points in W moved along `direction` onto the board's plane: shape (n, 3)."""
        distance = (self.origin - points) @ self.normal / (direction @ self.normal)
        return points + distance[:, None] * direction

    def line_at_height(self, height: float, half_width: float) -> np.ndarray:
        """The board's cut with the horizontal plane z = height: two end points, shape (2, 3), m."""
        along = np.cross(self.normal, [0.0, 0.0, 1.0])
        along /= np.linalg.norm(along)
        slope = self.up[2]
        start = self.origin + self.up * ((height - self.origin[2]) / slope if abs(slope) > 1e-6 else 0.0)
        return np.stack([start - half_width * along, start + half_width * along])


def board_of(log: xr.Dataset) -> Board | None:
    """The board that the log describes as seen from the robot, or None where it describes none."""
    surface = surface_of(log)
    if surface is None:
        return None
    origin, right, up, normal = (
        np.asarray(surface[key], dtype=float) for key in ("origin", "axis_u", "axis_v", "normal")
    )
    if (viewer := _viewer(log)) is not None and (viewer - origin) @ normal < 0:
        normal = -normal
    if up[2] < 0:
        up = -up
    # Seen from the front, right x up points at the viewer.
    if np.cross(right, up) @ normal < 0:
        right = -right
    return Board(origin, right, up, normal)


def strokes(log: xr.Dataset, bridge: float = 0.05) -> list[np.ndarray]:
    """The stretches of the tip's path (W, m) in which it touched the surface, each of shape (n, 3).

    Args:
        log: a run's log.
        bridge: seconds; a shorter loss of touch doesn't break the line.
    """
    time, tip = log.time.values, log.tip_position.values
    found = []
    for begin, end in spans(time, in_contact(log), bridge):
        inside = (time >= begin) & (time <= end)
        if np.count_nonzero(inside) > 1:
            found.append(tip[inside])
    return found


def nominal_path(log: xr.Dataset, board: Board | None) -> np.ndarray:
    """The line that a pen held still in the robot would draw if the CoG kept to its reference.

    In W, m, shape (n, 3). The pen's place beside the CoG is taken from free flight before the contact, and
    the path is carried along the contact axis onto the board. On a board that slopes, a circle of the CoG
    becomes an ellipse.
    """
    sliding = in_phase(log, "slide")
    free = in_phase(log, "hover") | in_phase(log, "tare")
    if not free.any():
        free = ~in_contact(log)
    offset = np.zeros(3)
    if free.any():
        offset = np.median(log.tip_position.values[free] - log.cog_position.values[free], axis=0)
    path = log.cog_position_reference.values[sliding] + offset
    if board is None:
        return path
    direction = (np.array(["x", "y", "z"]) == contact_axis(log)).astype(float)
    return board.project(path, direction)


def on_board(log: xr.Dataset, points: np.ndarray, board: Board | None) -> np.ndarray:
    """Coordinates on the board of points in W, or along the sliding axes without one, shape (n, 2), m."""
    if board is not None:
        return board.coordinates(points)
    return points[:, ["xyz".index(axis) for axis in sliding_axes(log)]]


def _viewer(log: xr.Dataset) -> np.ndarray | None:
    return log.cog_position.values[0] if "cog_position" in log and log.sizes["time"] else None
