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
    figure = Figure((style.WIDTH, height * rows + 0.5), layout="constrained")
    shared = any(common)
    axes = figure.subplots(rows, columns, squeeze=False, sharex=shared, sharey=shared)
    for unused in axes.flat[len(names) :]:
        unused.set_axis_off()
    if shared:
        style.label_outer(axes, len(names), *common)
    return figure, dict(zip(names, axes.flat, strict=False))


def colours_of(scores: Scores) -> list[str]:
    """The colour of each controller."""
    return list(style.colours_of(scores.controllers))


def add_legend(figure: Figure, scores: Scores, *more: Artist) -> None:
    """A legend under the panels: the controllers' colours, and more signs."""
    names = [style.label(name) for name in scores.controllers]
    swatches = [style.swatch(*each) for each in zip(colours_of(scores), names, strict=True)]
    style.legend_below(figure, [*swatches, *more])
