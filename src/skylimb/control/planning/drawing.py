"""A drawing: the strokes of a pen, fitted into the sliding plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skylimb.base.errors import ConfigError

_MEETING = 1e-4
"""Ends nearer than this part of the drawing's larger side count as one point."""
_SOON = 1e-3
"""Part of a piece of line after which it has its own width, where it goes on from another."""
_LONGEST = 200.0
"""Length of line, m, above which a width is a mistake rather than meant."""
MOST_STROKES, MOST_POINTS = 1_000, 20_000
"""Strokes of a drawing and points of its lines at most: each stroke takes seconds of flight."""
SMALLEST, LARGEST = 0.01, 5.0
"""Allowed for the larger side of a fitted drawing, m."""


@dataclass(frozen=True)
class Strokes:
    """Lines that a pen draws without leaving the surface, in the order in which it draws them.

    Attributes:
        lines: one array of points a stroke, (n, 2) with n of 2 or more, no point twice in a row.
        widths: of the line at each of these points, (n,) a stroke, in any unit; none of a drawing without.
    """

    lines: tuple[np.ndarray, ...]
    widths: tuple[np.ndarray, ...] = ()

    def __post_init__(self) -> None:
        if not self.lines:
            raise ConfigError("a drawing has no stroke: nothing to draw")
        for number, line in enumerate(self.lines, start=1):
            if line.ndim != 2 or line.shape[1] != 2 or len(line) < 2:
                raise ConfigError(
                    f"stroke {number} of a drawing has the shape {line.shape}; (2 or more, 2) is needed"
                )
            if not np.isfinite(line).all():
                raise ConfigError(f"stroke {number} of a drawing has coordinates that are not finite")

    @property
    def length(self) -> float:
        """Length of all strokes together, without the way between them."""
        return float(sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in self.lines))

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner of the box around all points, (2,) each."""
        points = np.vstack(self.lines)
        return points.min(axis=0), points.max(axis=0)

    @property
    def columns(self) -> list[np.ndarray]:
        """Points and widths of each stroke side by side, (n, 3); (n, 2) without widths."""
        beside = [self.widths] if self.widths else []
        return [np.column_stack(parts) for parts in zip(self.lines, *beside, strict=True)]

    def reversed(self) -> Strokes:
        """The same lines drawn backwards, the last one first."""
        lines, widths = (tuple(part[::-1] for part in reversed(parts)) for parts in (self.lines, self.widths))
        return Strokes(lines, widths)

    def pressed(self, low: float, high: float) -> Strokes:
        """With the forces that draw them in place of the widths: `low` the thinnest, `high` the widest, N.

        Raises:
            ConfigError: where two forces are asked for, and all strokes are as wide.
        """
        if low == high:
            return replace(self, widths=tuple(np.full(len(line), low) for line in self.lines))
        widths = np.concatenate([np.zeros(0), *self.widths])
        if not len(widths) or not np.ptp(widths) > 0.0:
            raise ConfigError(
                f"trajectory.force = [{low:g}, {high:g}]: all strokes of the drawing have one width, so "
                f"nothing says where to press how hard; [{high:g}, {high:g}] presses evenly"
            )
        slope = (high - low) / float(np.ptp(widths))
        return replace(self, widths=tuple(low + slope * (each - widths.min()) for each in self.widths))


def require_drawable(what: str, strokes: int, points: int) -> None:
    """Raise a `ConfigError` where a drawing has more strokes or points than a flight can draw."""
    for count, most, name in ((strokes, MOST_STROKES, "strokes"), (points, MOST_POINTS, "points")):
        if count > most:
            raise ConfigError(f"{what} has {count} {name}, more than {most}; make it simpler")


def clean(lines: Sequence[np.ndarray], what: str) -> Strokes:
    """Strokes without repeated points, joined where one begins at the end of the one before.

    Args:
        lines: (n, 2) each, in any unit; (n, 3) with widths beside the points.
        what: the drawing's name for the error.

    Raises:
        ConfigError: where a coordinate is not finite, nothing has a length, or there is too much to draw.
    """
    lines = [np.asarray(line, dtype=float) for line in lines]
    lines = [line if line.shape[1:] == (3,) else line.reshape(-1, 2) for line in lines]
    if any(not np.isfinite(line).all() for line in lines):
        raise ConfigError(f"{what} has coordinates that are not finite")
    points = np.vstack([np.zeros((0, 2)), *(line[:, :2] for line in lines)])
    near = _MEETING * float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    joined: list[np.ndarray] = []
    for given in lines:
        if len(given) < 2 or not np.ptp(given[:, :2], axis=0).max() > near:
            continue
        line = given[np.concatenate([[True], (given[1:, :2] != given[:-1, :2]).any(axis=1)])]
        if joined and np.linalg.norm(joined[-1][-1, :2] - line[0, :2]) <= near:
            # A width of its own begins where its line does.
            soon = line[:1] + _SOON * (line[1:2] - line[:1]) * (line[0, 2:] != joined[-1][-1, 2:]).any()
            joined[-1] = np.vstack([joined[-1], *[soon] * bool((soon != line[0]).any()), line[1:]])
        else:
            joined.append(line)
    if not joined:
        raise ConfigError(f"{what} has nothing to draw: no line in it has a length")
    require_drawable(what, len(joined), sum(len(line) for line in joined))
    return Strokes(
        tuple(line[:, :2] for line in joined), tuple(line[:, 2] for line in joined if line.shape[1] > 2)
    )


def nearest_first(strokes: Strokes) -> Strokes:
    """The strokes in an order with short ways between them, ends exchanged where that is nearer.

    Greedy: from the end of the first to the nearest end of those left, and so on.
    """
    left = strokes.columns
    order = [left.pop(0)]
    while left:
        here = order[-1][-1, :2]
        ends = np.array([(line[0, :2], line[-1, :2]) for line in left])
        index, end = np.unravel_index(int(np.argmin(np.linalg.norm(ends - here, axis=2))), (len(left), 2))
        line = left.pop(int(index))
        order.append(line[::-1] if end else line)
    return clean(order, "the drawing")


def fitted(strokes: Strokes, width: float, height: float = 0.0) -> Strokes:
    """A drawing in the sliding plane, in m, in the middle of it.

    Args:
        strokes: x to the right and y up, in any unit.
        width: of the box that it is to fill, m; 0 for no limit.
        height: of that box, m; 0 for no limit. Proportions are kept: the tighter of both decides.

    Returns:
        Points (u, v). Who stands behind the robot and looks along the contact axis has u to the left and v
        up, so u = -x, and the drawing reads as its file does.

    Raises:
        ConfigError: where the size asked for cannot be had, or is out of range.
    """
    low, high = strokes.bounds
    sides = high - low
    scales = [
        limit / side for limit, side in zip((width, height), sides, strict=True) if limit > 0.0 and side > 0.0
    ]
    if not scales:
        flat = "height" if width > 0.0 else "width"
        raise ConfigError(
            f"trajectory.{'width' if width > 0.0 else 'height'} = {max(width, height):g} m says nothing of a "
            f"drawing of {sides[0]:.4g} x {sides[1]:.4g} units; give its {flat} (trajectory.{flat})"
        )
    scale = min(scales)
    size = scale * sides
    if not SMALLEST <= float(size.max()) <= LARGEST:
        larger = ("width", "height")[int(np.argmax(size))]
        way = "limit" if size.max() > LARGEST else "change"
        raise ConfigError(
            f"the drawing would be {size[0]:.4g} m wide and {size[1]:.4g} m high; its larger side must be "
            f"{SMALLEST:g} .. {LARGEST:g} m: {way} its {larger} (trajectory.{larger})"
        )
    if scale * strokes.length > _LONGEST:
        raise ConfigError(
            f"the drawing has {scale * strokes.length:.4g} m of line, more than {_LONGEST:g} m; "
            "make it smaller or simpler"
        )
    middle = 0.5 * (low + high)
    return replace(strokes, lines=tuple((line - middle) * [-scale, scale] for line in strokes.lines))
