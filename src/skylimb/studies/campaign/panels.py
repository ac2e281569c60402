"""What the report's figures share: a panel for each metric, the controllers' colours, and the legend."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.studies.campaign.statistics import Scores


def panels(
    names: Sequence[str], height: float, common: tuple[str, str] = ("", "")
) -> tuple[Figure, dict[str, Axes]]:
    """A figure with a panel for each name.

    Args:
        names: of metrics or controllers.
        height: of a row, inches.
        common: what lies along the two axes, where all panels have the same.
    """
    rows, columns = style.panels(len(names), 4)
    shared = any(common)
    settings = {"squeeze": False, "sharex": shared, "sharey": shared}
    figure, axes = style.sheet(height * rows + 0.5, rows, columns, **settings)
    for unused in axes.flat[len(names) :]:
        unused.set_axis_off()
    if shared:
        style.label_outer(axes, len(names), *common)
    return figure, dict(zip(names, axes.flat, strict=False))


def add_legend(figure: Figure, scores: Scores, *more: Artist) -> None:
    """A legend under the panels: the controllers' colours, and more signs."""
    names = [style.label(name) for name in scores.controllers]
    swatches = [style.swatch(*each) for each in zip(style.colours_of(scores.controllers), names, strict=True)]
    style.legend_below(figure, [*swatches, *more])
