"""One figure of some runs, asked for by name: what `run.plot()` and `compare(...).plot()` draw."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.analysis.figures.panels import Curve, Panel, panels_figure
from skylimb.analysis.figures.report_figures import REPORT_FIGURES
from skylimb.analysis.recording import Run
from skylimb.base.errors import unknown_name

_REFERENCE = {"linestyle": style.DASHED, "linewidth": 0.9}

USUAL = "cog_tracking"
"""What is drawn where no name is given."""


def plotted(runs: Mapping[str, Run], what: str = "") -> Figure:
    """A figure of the report, or a signal over time with its reference dashed.

    Args:
        runs: by name.
        what: a figure's name (`cog_tracking`, `pen_traces`, `contact_direction`, ...) or a signal's.

    Raises:
        UnknownNameError: when it is neither.
    """
    for picture in REPORT_FIGURES:
        if picture.name == (what or USUAL):
            return _showing_itself(picture.draw(runs))
    signals = {
        str(name) for run in runs.values() for name in run.log.data_vars if "time" in run.log[name].dims
    }
    if what not in signals:
        raise unknown_name(
            "figure or signal", what, [*(picture.name for picture in REPORT_FIGURES), *signals]
        )
    return _showing_itself(_over_time({name: run for name, run in runs.items() if what in run.log}, what))


def _showing_itself(figure: Figure) -> Figure:
    """The figure, which a notebook shows also where it has no plotting backend."""
    figure._repr_png_ = lambda: style.png(figure)  # type: ignore[attr-defined]
    return figure


@style.styled
def _over_time(runs: Mapping[str, Run], signal: str) -> Figure:
    """A curve for each entry of the signal, and its reference dashed."""
    unit = next(iter(runs.values())).log[signal].attrs.get("units", "")
    curves = {name: _curves(run.log, signal) for name, run in runs.items()}
    panel = Panel(f"{signal} ({unit})" if unit else signal, curves)
    return panels_figure(runs, [panel], shades=lambda _: ())


def _curves(log: xr.Dataset, signal: str) -> list[Curve]:
    reference = entries(log, f"{signal.removesuffix('_normal')}_reference", _REFERENCE)
    return [*entries(log, signal), *(Curve(each.values, each.look | {"label": None}) for each in reference)]


def entries(log: xr.Dataset, signal: str, look: Mapping[str, Any] = {}) -> list[Curve]:
    """A curve for each entry of a signal, labelled as its dimension calls it; none where there is no signal.

    Args:
        log: of a flight.
        signal: its name.
        look: besides the label, and the colours that tell entries apart.
    """
    if signal not in log:
        return []
    values = log[signal].transpose("time", ...)
    flat = values.values.reshape(len(values.time), -1)
    named = values.ndim == 2 and values.dims[1] in values.coords
    labels = values[values.dims[1]].values if named else [None] * flat.shape[1]
    return [
        Curve(flat[:, k], {"color": f"C{k % 7}", "label": label, **look}) for k, label in enumerate(labels)
    ]
