"""Signals over time, one column of panels a run, with the contact shaded and events marked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from skylimb.analysis.figures import style
from skylimb.analysis.figures.marks import event_signs, mark_events
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.axis_names import common_names
from skylimb.analysis.scores.signals import (
    Direction,
    adapting,
    around,
    contact_axis,
    contact_transitions,
    in_contact,
    samples_within,
    sliding_axes,
    spans,
)

BRIDGE = 0.25
"""Seconds: shading is not interrupted by a shorter pause."""

SMOOTHING = 0.2
"""Seconds over which forces are averaged before they are drawn: the noise of an estimate hides the truth."""

_AWAY = ("lost", "recontact")
"""States of the contact in which a touch that there was is missed."""

DOTTED = ":"

TARGET = "cog_position_target"
"""Where a control law wants the centre of gravity that does not take the mission's reference as it is."""


@style.styled
def cog_tracking(runs: Mapping[str, Run]) -> Figure:
    """The CoG along the two sliding axes over time, with its reference dashed and the contact period shaded.

    Args:
        runs: by name, any number of them.

    Returns:
        A figure with two panels a run, one for each sliding axis; all panels of an axis share their scale.
        The reference is the mission's; where the control law had a target of its own, that is dotted.
    """
    figure, pairs = _grid(runs)
    colour = style.colours(runs)
    for which in (0, 1):
        values = [
            sliding_axes(run.log)[which].along(run.log[signal].values)
            for run in runs.values()
            for signal in ("cog_position", "cog_position_reference", TARGET)
            if signal in run.log
        ]
        span = style.limits(values)
        for (name, run), pair in zip(runs.items(), pairs, strict=True):
            ax, log = pair[which], run.log
            axis = sliding_axes(log)[which]
            style.shade(ax, _contact(log), style.CONTACT)
            _line(
                ax,
                log,
                "cog_position_reference",
                axis,
                **style.AS_REFERENCE,
            )
            _line(ax, log, "cog_position", axis, color=colour[name])
            if TARGET in log:
                _line(ax, log, TARGET, axis, color=style.INK, linestyle=DOTTED, linewidth=0.9)
            ax.set(ylim=span)
    axes = common_names(run.log for run in runs.values())
    _label_rows(pairs, f"CoG {axes.u} (m)", f"CoG {axes.v} (m)")
    target = Line2D([], [], color=style.INK, linestyle=DOTTED, linewidth=0.9, label="the law's own target")
    style.legend_below(
        figure,
        [
            style.in_all_colours(runs, "CoG"),
            Line2D([], [], label="mission's reference", **style.AS_REFERENCE),
            *([target] if any(TARGET in run.log for run in runs.values()) else []),
            style.swatch(style.CONTACT, "in contact"),
            *event_signs(runs),
        ],
    )
    return figure


@style.styled
def contact_direction(runs: Mapping[str, Run]) -> Figure:
    """Displacement of the CoG and force along the contact axis over time, with contact and adaptation shaded.

    Args:
        runs: by name, any number of them.

    Returns:
        A figure with two panels a run: displacement from the mission's reference (m) above; below, the
        estimated external force and, in black, the true contact force (N), both averaged over `SMOOTHING`.
        A pale band reaches from the smallest to the largest estimate within that time. Where a controller
        held the touch for lost, that is shaded too.
    """
    figure, pairs = _grid(runs)
    colour = style.colours(runs)
    displacements = {name: _displacement(run.log) for name, run in runs.items()}
    forces = {name: _forces(run.log) for name, run in runs.items()}
    upper = style.limits(list(displacements.values()))
    lower = style.limits([curve for curves in forces.values() for curve in curves.values()])
    for (name, run), (above, below) in zip(runs.items(), pairs, strict=True):
        log, axis = run.log, contact_axis(run.log)
        keep = style.thin(log.sizes["time"])
        time = log.time.values[keep]
        for ax in (above, below):
            style.shade(ax, _contact(log), style.CONTACT)
            style.shade(ax, spans(log.time.values, adapting(log) & in_contact(log), BRIDGE), style.ADAPTATION)
            style.shade(ax, _looking(log), style.LOST)
            ax.axhline(0.0, color=style.REFERENCE, linewidth=0.5)
        above.plot(time, displacements[name][keep], color=colour[name])
        drawn = {kind: curve[keep] for kind, curve in forces[name].items()}
        if "estimate" in drawn:
            band = {"color": colour[name], "alpha": 0.25, "linewidth": 0.0}
            below.fill_between(time, drawn["smallest"], drawn["largest"], **band)
            below.plot(time, drawn["estimate"], color=colour[name])
        if "truth" in drawn:
            below.plot(time, drawn["truth"], color=style.INK, linewidth=0.8)
        above.set(ylim=upper)
        below.set(ylim=lower)
    axis = common_names(run.log for run in runs.values()).n
    lost = any(_looking(run.log) for run in runs.values())
    looking = [style.swatch(style.LOST, "surface lost, looked for again")] if lost else []
    _label_rows(pairs, f"displacement {axis} (m)", f"force {axis} (N)")
    style.legend_below(
        figure,
        [
            style.in_all_colours(runs, "displacement, estimated force"),
            style.in_all_colours(
                runs, f"its range in {SMOOTHING:g} s", linewidth=5.0, alpha=0.25, solid_capstyle="butt"
            ),
            Line2D([], [], color=style.INK, linewidth=0.8, label="true force"),
            style.swatch(style.CONTACT, "in contact"),
            style.swatch(style.ADAPTATION, "in contact, arm adapting"),
            *looking,
            *event_signs(runs),
        ],
    )
    return figure


def _grid(runs: Mapping[str, Run]) -> tuple[Figure, list[tuple[Axes, Axes]]]:
    """A figure with a pair of panels, one above the other, for each run."""
    blocks, columns = style.panels(len(runs))
    wide = style.WIDTH * max(columns, 3) / 4
    figure = Figure(figsize=(wide, 3.3 * blocks + 0.3), layout="constrained")
    axes = figure.subplots(2 * blocks, columns, squeeze=False, sharex=True)
    pairs: list[tuple[Axes, Axes]] = []
    for index in range(blocks * columns):
        block, column = divmod(index, columns)
        pair = axes[2 * block, column], axes[2 * block + 1, column]
        if index >= len(runs):
            for ax in pair:
                ax.set_axis_off()
            continue
        pairs.append(pair)
        if column:
            for ax in pair:
                ax.tick_params(labelleft=False)
        lowest = index + columns >= len(runs)
        pair[0].tick_params(labelbottom=False)
        pair[1].tick_params(labelbottom=lowest)
        if lowest:
            pair[1].set_xlabel("time (s)")
        pair[1].xaxis.set_major_locator(MaxNLocator(5, integer=True))
    end = max((float(run.log.time[-1]) for run in runs.values()), default=1.0)
    for (name, run), pair in zip(runs.items(), pairs, strict=True):
        style.title(pair[0], name, run)
        pair[0].set(xlim=(0.0, end))
        for ax in pair:
            mark_events(ax, run.log, numbered=ax is pair[0])
    return figure, pairs


def _label_rows(pairs: list[tuple[Axes, Axes]], upper: str, lower: str) -> None:
    """Say beside the first column what the two rows of panels show."""
    columns = style.panels(len(pairs))[1]
    for above, below in pairs[::columns]:
        above.set_ylabel(upper)
        below.set_ylabel(lower)


def _line(ax: Axes, log: xr.Dataset, signal: str, axis: Direction, **options: Any) -> None:
    keep = style.thin(log.sizes["time"])
    ax.plot(log.time.values[keep], axis.along(log[signal].values[keep]), **options)


def _contact(log: xr.Dataset) -> list[tuple[float, float]]:
    return spans(log.time.values, in_contact(log), BRIDGE)


def _looking(log: xr.Dataset) -> list[tuple[float, float]]:
    """When the controller held the touch for lost, from the loss to the next touch or to giving up."""
    changes = contact_transitions(log)
    if not changes:
        return []
    ends = [*(change.time for change in changes[1:]), float(log.time[-1])]
    return [(change.time, end) for change, end in zip(changes, ends, strict=True) if change.after in _AWAY]


def _displacement(log: xr.Dataset) -> np.ndarray:
    return contact_axis(log).along(log.cog_position.values - log.cog_position_reference.values)


def _forces(log: xr.Dataset) -> dict[str, np.ndarray]:
    """Forces along the contact axis, N, as far as they were recorded.

    Returns:
        "estimate" and "truth", averaged over `SMOOTHING`, and the "smallest" and "largest" estimate within.
    """
    axis, time = contact_axis(log), log.time.values
    count = samples_within(time, SMOOTHING)
    found: dict[str, np.ndarray] = {}
    if "external_force_estimate" in log:
        estimate = axis.along(log.external_force_estimate.values)
        windows = around(estimate, count)
        found["estimate"], found["smallest"], found["largest"] = (
            reduce(windows, axis=-1) for reduce in (np.mean, np.min, np.max)
        )
    if "contact_force" in log:
        found["truth"] = around(axis.along(log.contact_force.values), count).mean(axis=-1)
    return found
