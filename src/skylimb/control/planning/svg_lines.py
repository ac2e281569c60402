"""The lines in an SVG file, read in a process of its own: `python -m ...planning.svg_lines NAME`.

A `use` repeats what it names, and what it names may repeat again; a transform is applied by all that is in
there. So a file of a few lines can ask for more than any machine has, and nobody knows before it is read. The
process reads the file from its input and has limits of time and memory; what it prints is NumPy's.
"""

from __future__ import annotations

import contextlib
import io
import signal
import sys
from collections import Counter
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from skylimb.base.errors import ConfigError, SkylimbError, extra_module
from skylimb.control.planning.drawing import MOST_POINTS, require_drawable
from skylimb.control.planning.svg_dashes import Dashes, cut, dashes_of
from skylimb.control.planning.svg_plain import plain_svg
from skylimb.control.planning.svg_widths import stroke_width

SECONDS, MEGABYTES = 2, 1024
"""Time of the processor and memory that the process may take; the largest drawing takes 0.4 s."""

TOO_MUCH = f"takes more than {SECONDS} s or {MEGABYTES} MB to read: make it simpler"

_FLATNESS = 1e-4
"""How far a straight piece may be from its curve, as a part of the drawing's larger side."""
_LOOK = np.linspace(0.0, 1.0, 33)
"""Places on a curve at which its bend is looked at."""
_CORNER = {"0", "0px", "0%", "left", "top"}
"""Words for the place about which a transform turns anyhow."""
_MOST_PIECES = 4096
_MOST_CURVES = 5_000
"""Curves of a drawing at most: each is looked at from near."""


def svg_lines(content: bytes, what: str) -> list[np.ndarray]:
    """The outlines in an SVG, (n, 3) each, in its units: x to the right, y up, and the stroke's width.

    Args:
        content: of the file.
        what: it is called in messages.

    Raises:
        ConfigError: where it is no SVG, has nothing to draw, or has text or pictures in it.
    """
    SVG: Any = extra_module("svgelements").SVG
    try:
        document: Any = SVG.parse(io.BytesIO(plain_svg(content, what)), reify=False)
    except (ValueError, TypeError, ArithmeticError, AttributeError, LookupError) as error:
        raise ConfigError(f"{what} is not a readable SVG file: {error or type(error).__name__}") from None
    if not isinstance(document, SVG):
        raise ConfigError(f"{what} is not a readable SVG file: it has no svg element")
    outlines = _outlines(document, what)
    _require_few(outlines, what)
    rough = [[_points(segment, _look(segment), one.place) for segment in one.segments] for one in outlines]
    points = np.vstack([np.zeros((0, 2)), *(points for part in rough for points in part)])
    if not len(points):
        raise ConfigError(f"{what} has nothing to draw: no visible path or shape in it")
    if not np.isfinite(points).all():
        raise ConfigError(f"{what} has coordinates that are not finite")
    flatness = _FLATNESS * float(np.ptp(points, axis=0).max())
    lines: list[_Line] = []
    count = 0
    for one, looked in zip(outlines, rough, strict=True):
        line = []
        for each in zip(one.segments, looked, strict=True):
            line.append(_flattened(*each, flatness, one.place))
            count += len(line[-1])
            if count > 2 * MOST_POINTS:  # where pieces meet, a point stands twice
                require_drawable(what, 0, count // 2)
        if line:
            lines.append((one, np.vstack(line)))
    return [
        np.column_stack([points * [1.0, -1.0], np.full(len(points), one.width)])
        for one, points in _dashed(lines, what)
    ]


class _Outline(NamedTuple):
    """One outline of an element, and how it is drawn.

    Attributes:
        element: its number.
        segments: of svgelements.
        place: the transform that places them.
        width: of its stroke.
        dashes: of its stroke; None where that is drawn through.
    """

    element: int
    segments: list[Any]
    place: Any
    width: float
    dashes: Dashes | None


_Line = tuple[_Outline, np.ndarray]
"""An outline, and its points, (n, 2)."""


def _dashed(lines: list[_Line], what: str) -> list[_Line]:
    """The lines, those with dashes cut into them: their lengths are those before the transform."""
    along = [_lengths(points, _turn(one.place)) if one.dashes else np.zeros(1) for one, points in lines]
    whole = Counter[int]()
    for (one, _), lengths in zip(lines, along, strict=True):
        whole[one.element] += lengths[-1]
    found: list[_Line] = []
    for (one, points), lengths in zip(lines, along, strict=True):
        if one.dashes is None or lengths[-1] == 0.0:
            found.append((one, points))
            continue
        dashes = one.dashes.along(whole[one.element])
        require_drawable(what, len(found) + dashes.count(lengths[-1]), 0)
        found += [(one, part) for part in cut(points, lengths, dashes)]
    return found


def _lengths(points: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """How far along a transformed line its points are, before the transform; zeros where that is none."""
    if abs(np.linalg.det(turn)) < np.finfo(float).tiny:
        return np.zeros(len(points))
    ways = np.linalg.norm(np.diff(points, axis=0) @ np.linalg.inv(turn), axis=1)
    return np.concatenate([[0.0], np.cumsum(ways)])


def _outlines(document: Any, what: str) -> list[_Outline]:
    """The visible outlines."""
    from svgelements import Image, Shape, Text
    from svgelements import Path as Outline

    found: list[_Outline] = []
    box = document.viewbox or document
    unit = float(np.hypot(float(box.width or 0.0), float(box.height or 0.0)) / np.sqrt(2.0))
    for number, element in enumerate(_seen(document, what)):
        if isinstance(element, Text):
            words = " ".join(str(element.text or "").split())
            raise ConfigError(
                f"{what} has a text element ('{words[:30]}'), which has no single line to draw; turn it into "
                "paths in your editor, or draw words with --text (trajectory.text)"
            )
        if isinstance(element, Image):
            raise ConfigError(f"{what} has a picture in it, which a pen cannot draw; trace it to paths first")
        # SVG fills with black where nothing is said; svgelements then gives a colour.
        if not isinstance(element, Shape):
            continue
        width = stroke_width(element, what, _painted(element.stroke))
        stroked = _painted(element.stroke) and width > 0.0
        if _painted(element.fill) or stroked:
            outline: Any = Outline(element)
            dashes = dashes_of(element.values or {}, unit) if stroked else None
            look = outline.transform, width, dashes
            found += [_Outline(number, list(part), *look) for part in outline.as_subpaths()]
    return found


def _seen(element: Any, what: str) -> Iterator[Any]:
    """An element and all that is in it, in the file's order, without what is hidden or fully transparent."""
    from svgelements import Group, Use

    # What is in a transparent group is not seen either, whatever it says of itself; a hidden group may have
    # visible parts.
    if _number(element.values.get("opacity")) == 0.0:
        return
    own = element.values.get("attributes") or {}
    if "transform" in own and not _CORNER.issuperset(own.get("transform-origin", "0").split()):
        raise ConfigError(
            f"{what} turns about a point that is given apart (transform-origin = "
            f"'{own['transform-origin'][:30]}'), which is not read; say it in the transform itself"
        )
    if element.values.get("visibility") not in ("hidden", "collapse"):
        yield element
    if isinstance(element, (Group, Use)):
        for part in element:
            yield from _seen(part, what)


def _number(value: Any) -> float | None:
    """A number or a percentage of an SVG file; None for what is neither."""
    try:
        return float(str(value).removesuffix("%"))
    except ValueError:
        return None


def _require_few(outlines: list[_Outline], what: str) -> None:
    require_drawable(what, 0, sum(len(one.segments) for one in outlines))
    curves = sum(len(_look(segment)) > 2 for one in outlines for segment in one.segments)
    if curves > _MOST_CURVES:
        raise ConfigError(f"{what} has {curves} curves, more than {_MOST_CURVES}; make it simpler")


def _look(segment: Any) -> np.ndarray:
    """Places at which a segment is looked at; of a straight one its ends are enough."""
    from svgelements import Close, Line, Move

    return _LOOK[[0, -1]] if isinstance(segment, (Line, Close, Move)) else _LOOK


def _painted(paint: Any) -> bool:
    return paint is not None and paint.value is not None and paint.alpha != 0


def _points(segment: Any, places: np.ndarray, transform: Any) -> np.ndarray:
    """Points of one segment of a path, transformed; none for the move to its beginning.

    The points are transformed and not the segment: svgelements has no arcs that are skewed.
    """
    from svgelements import Move

    if isinstance(segment, Move) or segment.start is None or segment.end is None:
        return np.zeros((0, 2))
    found = segment.npoint(places)
    given = found if isinstance(found, np.ndarray) else [tuple(point) for point in found]
    points = np.array(given, dtype=float)
    if not np.isfinite(points).all():
        return np.full_like(points, np.nan)
    return points @ _turn(transform) + [float(transform.e), float(transform.f)]


def _turn(transform: Any) -> np.ndarray:
    """The linear part of a transform, that rows of points are multiplied with, (2, 2)."""
    return np.array([[transform.a, transform.b], [transform.c, transform.d]], dtype=float)


def _flattened(segment: Any, looked: np.ndarray, flatness: float, transform: Any) -> np.ndarray:
    """A segment as straight pieces that keep within `flatness` of it."""
    from svgelements import Close, Line

    if not len(looked):
        return looked
    if isinstance(segment, (Line, Close)):
        return looked[[0, -1]]
    # A chord is off by an eighth of the second derivative times its step squared.
    bend = float(np.linalg.norm(np.diff(looked, n=2, axis=0), axis=1).max()) * (len(_LOOK) - 1) ** 2
    pieces = int(np.clip(np.ceil(np.sqrt(bend / (8.0 * flatness))), 1, _MOST_PIECES)) if flatness > 0 else 1
    return _points(segment, np.linspace(0.0, 1.0, pieces + 1), transform)


def _limit(seconds: float) -> None:
    """Of this process; systems without such limits have that of the time alone, which its maker keeps."""
    with contextlib.suppress(ImportError):
        import resource

        signal.setitimer(signal.ITIMER_PROF, seconds)  # its signal ends the process
        resource.setrlimit(resource.RLIMIT_AS, (MEGABYTES << 20, MEGABYTES << 20))


def _main(what: str, seconds: str) -> None:
    _limit(float(seconds))
    try:
        lines = svg_lines(sys.stdin.buffer.read(), what)
    except RecursionError:
        sys.exit(f"{what} has elements that repeat themselves, or too many inside of each other")
    except MemoryError:
        sys.exit(f"{what} {TOO_MUCH}")
    except SkylimbError as error:
        sys.exit(str(error))
    np.savez(sys.stdout.buffer, *lines)


if __name__ == "__main__":
    _main(*sys.argv[1:])
