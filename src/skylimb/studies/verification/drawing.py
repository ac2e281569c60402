"""What the figures of the evidence are: lines over one parameter, on axes of one look."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from numpy.typing import ArrayLike

Line = tuple[ArrayLike, ArrayLike, str, str]
"""Places (n,), values (n,), matplotlib's format, and a label, which may be empty."""


def lines(
    drawn: Iterable[Line],
    xlabel: str,
    ylabel: str,
    *,
    band: float | None = None,
    limit: float | None = None,
    **settings: Any,
) -> Callable[[Any], None]:
    """What draws lines on given axes.

    Args:
        drawn: the lines.
        xlabel: of the axis of places, with its unit.
        ylabel: of the values, with its unit.
        band: half width of a shaded band around zero: the tolerance.
        limit: a dashed line at this value.
        settings: of the axes, as `Axes.set` takes them.
    """
    kept = list(drawn)

    def draw(axes: Any) -> None:
        for x, y, style, label in kept:
            axes.plot(x, y, style, label=label)
        if band is not None:
            axes.axhspan(-band, band, alpha=0.15, color="0.5", lw=0)
        if limit is not None:
            axes.axhline(limit, color="0.5", ls="--")
        axes.set(xlabel=xlabel, ylabel=ylabel, **settings)
        if any(label for *_, label in kept):
            axes.legend(fontsize="small")

    return draw


def family(x: ArrayLike, rows: Iterable[ArrayLike], labels: Iterable[str], style: str = "o-") -> list[Line]:
    """One line for each row of values over the same places."""
    return [(x, row, style, label) for row, label in zip(rows, labels, strict=True)]
