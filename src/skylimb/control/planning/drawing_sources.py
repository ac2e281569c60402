"""Where drawings come from: SVG files, and words in single-stroke fonts.

SVG is read by svgelements, the Hershey fonts (letters made for pen plotters) come with Hershey-Fonts. Both
are loaded when they are first used.
"""

from __future__ import annotations

import functools
import io
import os
import subprocess
import sys
from contextlib import suppress
from typing import Any

import numpy as np

from skylimb.base.errors import ConfigError, extra_module, unknown_name
from skylimb.base.sources import Source
from skylimb.base.xml_text import read_xml
from skylimb.control.planning import svg_lines
from skylimb.control.planning.drawing import Strokes, clean

_PATIENCE = 10
"""How many times longer than it may work a process may take that reads an SVG, as others work beside it."""
_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""Threads of libraries that nobody needs there would take addresses."""
_MOST_LETTERS = 500


def svg_strokes(source: Source, file: str) -> Strokes:
    """The outlines in an SVG file, in its units, x to the right and y up, with the widths of their strokes.

    Paths, lines, polylines, polygons, circles, ellipses and rectangles, under all transforms; filled shapes
    are drawn as their outlines, invisible ones (neither fill nor stroke) are left out. Curves become straight
    pieces.

    Args:
        source: the file as it was read.
        file: what it is called in messages.

    Raises:
        ConfigError: where the file is no SVG, has nothing to draw, or has text or pictures in it.
    """
    extra_module("svgelements")
    if not source.content:
        raise ConfigError(f"SVG file '{file}' is empty")
    try:
        read_xml(source.content, document_type=True)
    except ValueError as error:
        raise ConfigError(f"'{file}' is not a readable SVG file: {error}") from None
    what = f"SVG file '{file}'"
    try:
        lines = _lines(source.content)
    except ConfigError as error:
        raise ConfigError(f"{what} {error}") from None
    return clean(lines, what)


@functools.lru_cache(maxsize=8)
def _lines(content: bytes) -> list[np.ndarray]:
    """What `svg_lines` finds, in a process whose time and memory are limited; its errors name no file."""
    command = [sys.executable, "-m", svg_lines.__name__, "", str(svg_lines.SECONDS)]
    environment = {**os.environ, **_ONE_THREAD, "PYTHONPATH": os.pathsep.join(sys.path)}
    words = svg_lines.TOO_MUCH
    with suppress(subprocess.TimeoutExpired):
        done = subprocess.run(
            command,
            input=content,
            capture_output=True,
            env=environment,
            timeout=_PATIENCE * svg_lines.SECONDS,
            check=False,
        )
        if done.returncode == 0:
            with np.load(io.BytesIO(done.stdout)) as found:
                return list(found.values())
        words = (done.stderr.decode(errors="replace").strip().splitlines() or [words])[-1]
    raise ConfigError(words)


def text_strokes(text: str, font: str = "futural") -> Strokes:
    """One line of words in a Hershey font, in the font's units, x to the right and y up.

    As with a pointed pen, what is drawn upward is thin, and what is drawn downward wide: 0 to 1.

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
    lines = [_with_widths(line * [1.0, -1.0]) for line in lines if len(line) > 1]
    return clean(lines, f"trajectory.text = {text!r}")


def _with_widths(line: np.ndarray) -> np.ndarray:
    sides = np.diff(line, axis=0)
    widths = 0.5 - 0.5 * sides[:, 1] / np.maximum(np.hypot(*sides.T), 1e-9)
    both = np.concatenate([widths[:1], widths]), np.concatenate([widths, widths[-1:]])
    return np.column_stack([line, np.mean(both, axis=0)])
