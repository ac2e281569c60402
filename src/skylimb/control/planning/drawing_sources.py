"""Where drawings come from: SVG files, and words in single-stroke fonts.

SVG is read by svgelements, the Hershey fonts (letters made for pen plotters) come with Hershey-Fonts. Both
are loaded when they are first used.
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from skylimb.base.errors import ConfigError, extra_module, unknown_name
from skylimb.base.sources import Source
from skylimb.base.xml_text import read_xml
from skylimb.control.planning.drawing import MOST_POINTS, Strokes, clean, require_drawable
from skylimb.control.planning.svg_limits import require_readable

_FLATNESS = 1e-4
"""How far a straight piece may be from its curve, as a part of the drawing's larger side."""
_LOOK = np.linspace(0.0, 1.0, 33)
"""Places on a curve at which its bend is looked at."""
_MOST_PIECES = 4096
_MOST_CURVES = 5_000
"""Curves of a drawing at most: each is looked at from near."""
_MOST_LETTERS = 500


def svg_strokes(source: Source, file: str) -> Strokes:
    """The outlines in an SVG file, in its units, x to the right and y up.

    Paths, lines, polylines, polygons, circles, ellipses and rectangles, under all transforms; filled shapes
    are drawn as their outlines, invisible ones (neither fill nor stroke) are left out. Curves become straight
    pieces.

    Args:
        source: the file as it was read.
        file: what it is called in messages.

    Raises:
        ConfigError: where the file is no SVG, has nothing to draw, or has text or pictures in it.
    """
    SVG: Any = extra_module("svgelements").SVG
    what = f"SVG file '{file}'"
    if not source.content:
        raise ConfigError(f"{what} is empty")
    try:
        require_readable(read_xml(source.content, document_type=True), what)
        document: Any = SVG.parse(io.BytesIO(source.content), reify=False)
    except (ValueError, TypeError, ArithmeticError, AttributeError, LookupError) as error:
        raise ConfigError(f"'{file}' is not a readable SVG file: {error or type(error).__name__}") from None
    if not isinstance(document, SVG):
        raise ConfigError(f"'{file}' is not a readable SVG file: it has no svg element")
    outlines = _outlines(document, what)
    _require_few(outlines, what)
    rough = [[_points(segment, _look(segment), place) for segment in outline] for outline, place in outlines]
    points = np.vstack([np.zeros((0, 2)), *(points for part in rough for points in part)])
    if not len(points):
        raise ConfigError(f"{what} has nothing to draw: no visible path or shape in it")
    if not np.isfinite(points).all():
        raise ConfigError(f"{what} has coordinates that are not finite")
    flatness = _FLATNESS * float(np.ptp(points, axis=0).max())
    lines, count = [], 0
    for (outline, place), looked in zip(outlines, rough, strict=True):
        line = []
        for each in zip(outline, looked, strict=True):
            line.append(_flattened(*each, flatness, place))
            count += len(line[-1])
            if count > 2 * MOST_POINTS:  # where pieces meet, a point stands twice
                require_drawable(what, 0, count // 2)
        if line:
            lines.append(np.vstack(line) * [1.0, -1.0])
    return clean(lines, what)


def text_strokes(text: str, font: str = "futural") -> Strokes:
    """One line of words in a Hershey font, in the font's units, x to the right and y up.

    Raises:
        MissingExtraError: where the extra for drawings is not installed.
        UnknownNameError: where there is no such font.
        ConfigError: where the font lacks a letter, or there is nothing to draw.
    """
    if len(text) > _MOST_LETTERS:
        raise ConfigError(
            f"trajectory.text = {text[:20]!r}... has {len(text)} letters, more than {_MOST_LETTERS}"
        )
    letters: Any = extra_module("HersheyFonts").HersheyFonts()
    known = list(letters.default_font_names)
    if font not in known:
        raise unknown_name("font", font, known)
    letters.load_default_font(font)
    missing = [letter for letter in text if letter not in letters.all_glyphs]
    if missing:
        raise ConfigError(
            f"font '{font}' has no {missing[0]!r}, which trajectory.text = {text!r} asks for; "
            "it has the printable ASCII characters"
        )
    lines = [np.array(stroke, dtype=float).reshape(-1, 2) for stroke in letters.strokes_for_text(text)]
    return clean([line * [1.0, -1.0] for line in lines], f"trajectory.text = {text!r}")


def _outlines(document: Any, what: str) -> list[tuple[list[Any], Any]]:
    """The visible outlines: the segments of each, and the transform that places them."""
    from svgelements import Image, Shape, Text
    from svgelements import Path as Outline

    found: list[tuple[list[Any], Any]] = []
    for element in document.elements():
        if isinstance(element, Text):
            words = " ".join(str(element.text or "").split())
            raise ConfigError(
                f"{what} has a text element ('{words[:30]}'), which has no single line to draw; turn it into "
                "paths in your editor, or draw words with --text (trajectory.text)"
            )
        if isinstance(element, Image):
            raise ConfigError(f"{what} has a picture in it, which a pen cannot draw; trace it to paths first")
        if isinstance(element, Shape) and _visible(element):
            outline: Any = Outline(element)
            found += [(list(part), outline.transform) for part in outline.as_subpaths()]
    return found


def _require_few(outlines: list[tuple[list[Any], Any]], what: str) -> None:
    require_drawable(what, 0, sum(len(outline) for outline, _ in outlines))
    curves = sum(len(_look(segment)) > 2 for outline, _ in outlines for segment in outline)
    if curves > _MOST_CURVES:
        raise ConfigError(f"{what} has {curves} curves, more than {_MOST_CURVES}; make it simpler")


def _look(segment: Any) -> np.ndarray:
    """Places at which a segment is looked at; of a straight one its ends are enough."""
    from svgelements import Close, Line, Move

    return _LOOK[[0, -1]] if isinstance(segment, (Line, Close, Move)) else _LOOK


def _visible(shape: Any) -> bool:
    # SVG fills with black where nothing is said; svgelements then gives a colour.
    return any(paint is not None and paint.value is not None for paint in (shape.fill, shape.stroke))


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
    turn = np.array([[transform.a, transform.b], [transform.c, transform.d]], dtype=float)
    return points @ turn + [float(transform.e), float(transform.f)]


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
