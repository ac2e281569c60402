"""The dashes of an SVG file's strokes: an outline cut where its pattern has gaps.

Lengths are those of the element, before its transform (SVG 2, "stroke-dasharray"); each outline begins the
pattern anew. What is no pattern (`none`, negative, all zero, no number) leaves the outline whole, as in a
browser.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np


class Dashes(NamedTuple):
    """The pattern of a stroke.

    Attributes:
        lengths: of dash, gap, dash, ..., in units of the element; an even number of them.
        offset: how far into the pattern an outline begins.
        whole: length that all outlines of the element have by its own word (`pathLength`); 0 without it.
    """

    lengths: np.ndarray
    offset: float
    whole: float = 0.0

    def along(self, length: float) -> Dashes:
        """The pattern in units of the element, whose outlines have this length together."""
        if not self.whole:
            return self
        scale = length / self.whole
        return Dashes(scale * self.lengths, scale * self.offset)

    def count(self, length: float) -> int:
        """How many dashes an outline of this length has at most."""
        return round(0.5 * len(self.lengths) * (2.0 + length / float(np.sum(self.lengths))))


def dashes_of(values: Mapping[str, Any], unit: float) -> Dashes | None:
    """The pattern that an element says; None where it draws through.

    Args:
        values: attributes and style of the element.
        unit: that a percentage is of.
    """
    words = str(values.get("stroke-dasharray") or "none").replace(",", " ").split()
    lengths = np.array([_length(word, unit) for word in words])
    if not len(lengths) or not np.isfinite(lengths).all() or (lengths < 0.0).any() or not lengths.any():
        return None
    offset, whole = (_length(values.get(name) or 0, unit) for name in ("stroke-dashoffset", "pathLength"))
    offset, whole = (value if np.isfinite(value) else 0.0 for value in (offset, whole))
    return Dashes(np.tile(lengths, 1 + len(lengths) % 2), offset, max(whole, 0.0))


def cut(points: np.ndarray, lengths: np.ndarray, dashes: Dashes) -> list[np.ndarray]:
    """The dashes of a line.

    Args:
        points: of the line, (n, m).
        lengths: along it to each of them, in the pattern's units, (n,), rising.
        dashes: the pattern.

    Returns:
        The points of each dash; places between two points are on their straight line.
    """
    ends = np.cumsum(dashes.lengths)
    first = -(dashes.offset % ends[-1])
    periods = first + ends[-1] * np.arange(np.ceil((lengths[-1] - first) / ends[-1]))
    begins = (periods[:, None] + np.concatenate([[0.0], ends[1:-1:2]])).ravel()
    stops = (periods[:, None] + ends[::2]).ravel()
    begins, stops = np.clip(begins, 0.0, lengths[-1]), np.clip(stops, 0.0, lengths[-1])
    return [_between(points, lengths, *ends) for ends in zip(begins, stops, strict=True) if ends[1] > ends[0]]


def _between(points: np.ndarray, lengths: np.ndarray, begin: float, stop: float) -> np.ndarray:
    inside = points[(lengths > begin) & (lengths < stop)]
    at = np.column_stack([np.interp([begin, stop], lengths, column) for column in points.T])
    return np.vstack([at[:1], inside, at[1:]])


def _length(word: Any, unit: float) -> float:
    """A length of an SVG file in its units; NaN where it is none."""
    from svgelements import Length

    try:
        return float(Length(str(word)).value(relative_length=unit))
    except (ValueError, TypeError, AttributeError):
        return np.nan
