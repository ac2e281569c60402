"""A drawing that people make on a surface, as an SVG file and the keys of the path that draws it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.files import first_free, replace_text, writing
from skylimb.base.sources import Source
from skylimb.control.missions.frame import ContactFrame
from skylimb.control.planning.drawing import clean
from skylimb.control.planning.drawing_sources import svg_strokes
from skylimb.simulation.surfaces import Surface

FOLDER = "drawings"
"""Below a session's folder."""

SHAPE, FILE, TEXT, FONT = (f"trajectory.{name}" for name in ("shape", "file", "text", "font"))
"""Keys of a path that is a drawing, and of what is drawn."""


def drawn_last(keys: Mapping[str, Any]) -> dict[str, Any]:
    """Keys that change, and what goes with them: a drawing is of a file or of words, whichever came last."""
    other = {FILE: TEXT, TEXT: FILE}
    return {**{other[key]: "" for key in other.keys() & keys.keys() if keys[key]}, **keys}


def without(keys: Mapping[str, Any], placed: Mapping[str, Any], first: Mapping[str, Any]) -> dict[str, Any]:
    """Keys of the experiment without the size and place that a drawing by hand had.

    Args:
        keys: that are flown; what was changed after the drawing stays.
        placed: those that the drawing gave.
        first: that were given when the studio began, and come back.
    """
    gone = {key for key, value in placed.items() if keys.get(key) == value}
    kept = {key: value for key, value in keys.items() if key not in gone}
    return kept | {key: first[key] for key in gone & first.keys()}


def require_svg(svg: str, name: str) -> None:
    """Check that an SVG text can be drawn; `name` is that of its file.

    Raises:
        ConfigError: where it cannot.
    """
    svg_strokes(Source(Path(name), svg.encode()), name)


def strokes_as_svg(
    strokes: Sequence[Sequence[Sequence[float]]], surface: Surface, frame: ContactFrame
) -> tuple[str, dict[str, Any]]:
    """Strokes on a surface as an SVG text, and keys that put them where they were drawn.

    Args:
        strokes: points (u, v) in the surface's axes, m.
        surface: on which they were drawn, where it is at take-off.
        frame: of the mission, in whose sliding plane a path lives.

    Raises:
        ConfigError: where there is nothing to draw, or too much.
    """
    try:
        given = [np.asarray(stroke, dtype=float).reshape(-1, 2) for stroke in strokes]
    except (TypeError, ValueError):
        raise ConfigError("strokes should be lists of points (u, v), in m") from None
    lines = clean(given, "the drawing").lines
    plane = np.stack([frame.sliding_u, frame.sliding_v], axis=1)
    moved = [line @ surface.R_WS[:, 1:].T @ plane for line in lines]
    points = np.vstack(moved)
    low, high = points.min(axis=0), points.max(axis=0)
    sides = high - low
    # In millimetres, x to the right and y down, as one sees it from the robot: u runs to the left.
    paths = ["M " + " L ".join(f"{-1e3 * u:.4f},{-1e3 * v:.4f}" for u, v in line) for line in moved]
    box = f"{-1e3 * high[0]:.4f} {-1e3 * high[1]:.4f} {1e3 * sides[0]:.4f} {1e3 * sides[1]:.4f}"
    body = "\n".join(f'  <path d="{path}"/>' for path in paths)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" fill="none" stroke="black">'
    svg = f"{head}\n{body}\n</svg>\n"
    wide = sides[0] >= sides[1]
    keys = {
        "trajectory.width": float(round(sides[0], 6)) if wide else 0.0,
        "trajectory.height": 0.0 if wide else float(round(sides[1], 6)),
        "trajectory.center": tuple(float(round(x, 6)) for x in 0.5 * (low + high)),
    }
    return svg, keys


def keep_drawing(svg: str, out: Path) -> Path:
    """Write an SVG text below a session's folder, and return its path.

    Raises:
        OutputError: when it cannot be written.
    """
    folder = out / FOLDER
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        path = first_free(folder, "drawing-{}.svg")
        replace_text(path, svg)
    return path
