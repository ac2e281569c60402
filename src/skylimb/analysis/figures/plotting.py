"""One figure of some runs, asked for by name: what `run.plot()` and `compare(...).plot()` draw."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.analysis.figures.marks import event_signs, mark_events
from skylimb.analysis.figures.report_figures import REPORT_FIGURES
from skylimb.analysis.recording import Run
from skylimb.base.errors import unknown_name

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
    for plate in REPORT_FIGURES:
        if plate.name == (what or USUAL):
            return _showing_itself(plate.draw(runs))
    signals = {
        str(name) for run in runs.values() for name in run.log.data_vars if "time" in run.log[name].dims
    }
    if what not in signals:
        raise unknown_name("figure or signal", what, [*(plate.name for plate in REPORT_FIGURES), *signals])
    return _showing_itself(_over_time({name: run for name, run in runs.items() if what in run.log}, what))


def _showing_itself(figure: Figure) -> Figure:
    """The figure, which a notebook shows also where it has no plotting backend."""
    figure._repr_png_ = lambda: style.png(figure)  # type: ignore[attr-defined]
    return figure


@style.styled
def _over_time(runs: Mapping[str, Run], signal: str) -> Figure:
    """A panel a run, a curve an entry of the signal."""
    figure = Figure(figsize=(style.WIDTH, 1.6 * len(runs) + 0.4), layout="constrained")
    axes = figure.subplots(len(runs), 1, sharex=True, sharey=True, squeeze=False).flat
    for ax, (name, run) in zip(axes, runs.items(), strict=True):
        values = run.log[signal]
        flat = values.transpose("time", ...).values.reshape(len(values.time), -1)
        step = style.thin(len(flat))
        ax.plot(values.time.values[step], flat[step])
        name_of_reference = f"{signal.removesuffix('_normal')}_reference"
        if name_of_reference in run.log:
            reference = run.log[name_of_reference].transpose("time", ...).values.reshape(len(flat), -1)
            ax.set_prop_cycle(None)
            ax.plot(values.time.values[step], reference[step], linestyle=style.DASHED, linewidth=0.9)
        mark_events(ax, run.log, numbered=True)
        if values.ndim == 2 and values.dims[1] in values.coords:
            ax.legend(values[values.dims[1]].values, loc="upper right", ncols=flat.shape[1])
        unit = values.attrs.get("units", "")
        ax.set_ylabel(f"{signal} ({unit})" if unit else signal)
        style.title(ax, name, run)
    axes[-1].set_xlabel("time (s)")
    if signs := event_signs(runs):
        style.legend_below(figure, signs)
    return figure
