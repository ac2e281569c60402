"""The board's own coordinates, and the lines on it: the one drawn and the one that was meant."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from skylimb.analysis.scores.signals import (
    contact_axis,
    in_contact,
    in_phase,
    sliding_axes,
    spans,
    surface_of,
)

if TYPE_CHECKING:
    import xarray as xr


class Relief(NamedTuple):
    """How a curved surface departs from its flat plane.

    Attributes:
        u: coordinates along the surface's u axis, m, shape (nu,).
        v: coordinates along its v axis, m, shape (nv,).
        height: how far it recedes from the plane, m, shape (nu, nv); NaN where there is no surface.
        unrolled_u: length along the surface from u = 0, m, shape (nu,).
    """

    u: np.ndarray
    v: np.ndarray
    height: np.ndarray
    unrolled_u: np.ndarray

    def at(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The height at (u, v), m, linear between the grid's points; beyond the grid, that at its edge."""
        i, j = np.interp(u, self.u, np.arange(len(self.u))), np.interp(v, self.v, np.arange(len(self.v)))
        a, b = (
            np.minimum(place.astype(int), size - 2) for place, size in ((i, len(self.u)), (j, len(self.v)))
        )
        along_u, along_v = i - a, j - b
        below = self.height[a, b] * (1.0 - along_u) + self.height[a + 1, b] * along_u
        above = self.height[a, b + 1] * (1.0 - along_u) + self.height[a + 1, b + 1] * along_u
        return below * (1.0 - along_v) + above * along_v


class Board(NamedTuple):
    """A surface's frame, and which way round one sees it from the robot.

    Attributes:
        origin: a point of the surface's flat plane in W, m.
        axis_u: unit vector across the surface, W.
        axis_v: unit vector up the surface, W.
        normal: unit vector out of the plane toward the robot, W.
        mirrored: whether u runs to the left for a viewer on the robot's side.
        relief: the shape of a curved surface.
    """

    origin: np.ndarray
    axis_u: np.ndarray
    axis_v: np.ndarray
    normal: np.ndarray
    mirrored: bool
    relief: Relief | None = None

    def coordinates(self, points: np.ndarray) -> np.ndarray:
        """Where points lie on the surface as the robot sees it: to the right, and up.

        Args:
            points: in W, m, shape (n, 3).

        Returns:
            Shape (n, 2), m. A curved surface is unrolled: lengths are those along it.
        """
        u, v = (points - self.origin) @ self.axis_u, (points - self.origin) @ self.axis_v
        if self.relief is not None:
            u = np.interp(u, self.relief.u, self.relief.unrolled_u)
        return np.stack([-u if self.mirrored else u, v], axis=1)

    def project(self, points: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Points in W, shape (n, 3), moved along `direction` onto the surface."""
        into = -float(direction @ self.normal)
        if abs(into) < 1e-9:
            return points
        for _ in range(1 if self.relief is None else 40):  # a gentle relief: each round shrinks the miss
            offset = points - self.origin
            depth = np.zeros(len(points))
            if self.relief is not None:
                depth = self.relief.at(offset @ self.axis_u, offset @ self.axis_v)
            points = points + ((depth + offset @ self.normal) / into)[:, None] * direction
        return points

    def cut(self, height: float, half_width: float = 0.5, count: int = 41) -> np.ndarray:
        """The surface's cut with the horizontal plane z = `height` (m): W, m, shape (count, 3)."""
        u = np.linspace(-half_width, half_width, count)
        v = np.full(count, height - self.origin[2])
        if abs(self.axis_v[2]) > 1e-6:
            v = (v - u * self.axis_u[2]) / self.axis_v[2]
        points = self.origin + u[:, None] * self.axis_u + v[:, None] * self.axis_v
        if self.relief is not None:
            points = points - self.relief.at(u, v)[:, None] * self.normal
        return points


def board_of(log: xr.Dataset) -> Board | None:
    """The surface that the log describes, or None where it describes none."""
    surface = surface_of(log)
    if surface is None:
        return None
    origin, axis_u, axis_v, normal, *shape = (
        np.asarray(surface[key], dtype=float)
        for key in (*Board._fields[:4], *Relief._fields)
        if key in surface
    )
    # Seen from the front, right x up points at the viewer.
    mirrored = bool(np.cross(axis_u, axis_v) @ normal < 0)
    relief = Relief(*shape) if len(shape) == len(Relief._fields) else None
    return Board(origin, axis_u, axis_v, normal, mirrored, relief)


def strokes(log: xr.Dataset, bridge: float = 0.05) -> list[slice]:
    """The stretches of samples in which the tip touched the surface.

    Args:
        log: a run's log.
        bridge: seconds; a shorter loss of touch doesn't break the line.
    """
    time = log.time.values
    found = [np.searchsorted(time, span) for span in spans(time, in_contact(log), bridge)]
    return [slice(int(first), int(last) + 1) for first, last in found if last > first]


def nominal_path(log: xr.Dataset, board: Board | None) -> np.ndarray:
    """The line that the pen would draw without any error.

    Of a law that leads the pen it is the pen's reference. Of any other it is the line that a pen held still
    in the robot would draw if the CoG kept to its reference. The pen's place beside the CoG is taken from
    free flight before the contact, and the path is carried along the contact axis onto the board. On a board
    that slopes, a circle of the CoG becomes an ellipse.

    Returns:
        W, m, shape (n, 3), one point a sample of the sliding period.
    """
    if {"cog_position_target", "tip_position_reference"} <= set(log.variables):
        # The law leads the pen along its reference, and the centre of gravity to where that takes it.
        path = log.tip_position_reference.values[in_phase(log, "slide")]
        return path if board is None else board.project(path, contact_axis(log).vector)
    free = in_phase(log, "hover") | in_phase(log, "tare")
    if not free.any():
        free = ~in_contact(log)
    offset = np.zeros(3)
    if free.any():
        offset = np.median(log.tip_position.values[free] - log.cog_position.values[free], axis=0)
    path = log.cog_position_reference.values[in_phase(log, "slide")] + offset
    if board is None:
        return path
    return board.project(path, contact_axis(log).vector)


def on_board(log: xr.Dataset, points: np.ndarray, board: Board | None) -> np.ndarray:
    """Coordinates on the board of points in W, or along the sliding axes without one, shape (n, 2), m."""
    if board is not None:
        return board.coordinates(points)
    return np.stack([axis.along(points) for axis in sliding_axes(log)], axis=1)
