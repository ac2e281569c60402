"""Signals over time, one column of panels a run, with the contact shaded and events marked."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skylimb.analysis.figures import style
from skylimb.analysis.figures.panels import BRIDGE, Curve, Panel, Shades, contact_shade, panels_figure
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.axis_names import common_names
from skylimb.analysis.scores.signals import (
    adapting,
    around,
    contact_axis,
    contact_transitions,
    in_contact,
    off_mission,
    samples_within,
    sliding_axes,
    spans,
)

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
    colour = style.colours(runs)
    target = {"color": style.DARK, "linestyle": DOTTED, "linewidth": 0.9}

    def curves(name: str, which: int) -> list[Curve]:
        log = runs[name].log
        looks = {
            "cog_position_reference": style.AS_REFERENCE,
            "cog_position": {"color": colour[name]},
            TARGET: target,
        }
        along = sliding_axes(log)[which].along
        return [Curve(along(log[signal].values), look) for signal, look in looks.items() if signal in log]

    axes = common_names(run.log for run in runs.values())
    panels = [
        Panel(f"CoG {axis} (m)", {name: curves(name, which) for name in runs})
        for which, axis in enumerate((axes.u, axes.v))
    ]
    signs = [
        style.in_all_colours(runs, "CoG"),
        Line2D([], [], label="mission's reference", **style.AS_REFERENCE),
        *(
            [Line2D([], [], label="the law's own target", **target)]
            * any(TARGET in run.log for run in runs.values())
        ),
        style.swatch(style.CONTACT, "in contact"),
    ]
    return panels_figure(runs, panels, signs)


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
    colour = style.colours(runs)
    axis = common_names(run.log for run in runs.values()).n
    away = {name: off_mission(run.log, contact_axis(run.log)) for name, run in runs.items()}
    panels = [
        Panel(
            f"displacement {axis} (m)",
            {
                name: [
                    _zero(run.log),
                    Curve(away[name], {"color": colour[name]}),
                ]
                for name, run in runs.items()
            },
        ),
        Panel(f"force {axis} (N)", {name: _forces(run.log, colour[name]) for name, run in runs.items()}),
    ]
    lost = any(_looking(run.log) for run in runs.values())
    band = style.in_all_colours(
        runs, f"its range in {SMOOTHING:g} s", linewidth=5.0, alpha=0.25, solid_capstyle="butt"
    )
    signs = [
        style.in_all_colours(runs, "displacement, estimated force"),
        band,
        Line2D([], [], color=style.DARK, linewidth=0.8, label="true force"),
        style.swatch(style.CONTACT, "in contact"),
        style.swatch(style.ADAPTATION, "in contact, arm adapting"),
        *([style.swatch(style.LOST, "surface lost, looked for again")] * lost),
    ]
    return panels_figure(runs, panels, signs, _shades)


def _shades(log: xr.Dataset) -> Shades:
    adapts = spans(log.time.values, adapting(log) & in_contact(log), BRIDGE)
    yield from contact_shade(log)
    yield from ((*span, style.ADAPTATION) for span in adapts)
    yield from ((*span, style.LOST) for span in _looking(log))


def _looking(log: xr.Dataset) -> list[tuple[float, float]]:
    """When the controller held the touch for lost, from the loss to the next touch or to giving up."""
    changes = contact_transitions(log)
    if not changes:
        return []
    ends = [*(change.time for change in changes[1:]), float(log.time[-1])]
    return [(change.time, end) for change, end in zip(changes, ends, strict=True) if change.after in _AWAY]


def _zero(log: xr.Dataset) -> Curve:
    return Curve(np.zeros(log.sizes["time"]), {"color": style.REFERENCE, "linewidth": 0.5})


def _forces(log: xr.Dataset, colour: str) -> list[Curve]:
    """Forces along the contact axis, N, averaged over `SMOOTHING`, as far as they were recorded."""
    axis, count = contact_axis(log), samples_within(log.time.values, SMOOTHING)
    found = [_zero(log)]
    if "external_force_estimate" in log:
        near = around(axis.along(log.external_force_estimate.values), count)
        band = np.stack([near.min(axis=-1), near.max(axis=-1)], axis=1)
        found.append(Curve(band, {"color": colour, "alpha": 0.25, "linewidth": 0.0}))
        found.append(Curve(near.mean(axis=-1), {"color": colour}))
    if "contact_force" in log:
        truth = around(axis.along(log.contact_force.values), count).mean(axis=-1)
        found.append(Curve(truth, {"color": style.DARK, "linewidth": 0.8}))
    return found
