"""The plots beside a replay: which curves of a flight stand in which panel."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from skylimb.analysis.scores.signals import around, contact_axis, samples_within, sliding_axes
from skylimb.analysis.scores.task import tools_of
from skylimb.analysis.viewer.packing import packed

RATE = 50.0
"""Samples a second of every curve."""

SMOOTHING = 0.1
"""Forces are averaged over this time, s: single ticks are noise to the eye."""

COMPARED, ALONE, BOTH = "compared", "alone", "both"
"""When a curve is seen: with several flights in the panel, with one alone, or always."""


class Curve(NamedTuple):
    """A curve of a panel.

    Attributes:
        label: for the legend.
        role: `truth`, `reference`, `estimate`, `command` or `limit`; says how it is drawn.
        seen: `COMPARED`, `ALONE` or `BOTH`.
        values: at every sample of the log, (k,).
    """

    label: str
    role: str
    seen: str
    values: np.ndarray


def packed_panels(log: xr.Dataset) -> dict[str, Any]:
    """The panels of a flight, and the numbers of all their curves in one pack.

    Returns:
        `panels`: title, unit and curves, each with the number of its column; `signals`: time and columns.
    """
    times = log.time.values
    every = samples_within(times, 1.0 / RATE)
    keep = slice(None, None, every)
    panels: list[dict[str, Any]] = []
    columns: list[np.ndarray] = [times[keep]]
    for title, unit, curves in _panels(log):
        entries = []
        for curve in curves:
            entries.append(
                {"label": curve.label, "role": curve.role, "seen": curve.seen, "column": len(columns)}
            )
            columns.append(curve.values[keep])
        if entries:
            panels.append({"title": title, "unit": unit, "curves": entries})
    return {"panels": panels, "signals": packed(np.stack(columns, axis=1))}


def _panels(log: xr.Dataset) -> Iterator[tuple[str, str, list[Curve]]]:
    for axis in (*sliding_axes(log), contact_axis(log)):
        curves = [
            Curve(label, role, seen, axis.along(log[name].values))
            for label, role, seen, name in (
                ("reference", "reference", BOTH, "cog_position_reference"),
                ("truth", "truth", BOTH, "cog_position"),
                ("estimate", "estimate", ALONE, "cog_position_estimate"),
            )
            if name in log
        ]
        yield f"Centre of gravity along {axis}", "m", curves
    yield "Pressing force", "N", list(_forces(log))
    for tool in tools_of(log):
        truth = log[tool.signal].values
        commanded = np.full(len(truth), tool.commanded(log))
        wanted = Curve("commanded", "reference", BOTH, commanded)
        yield tool.title, tool.unit, [wanted, Curve("truth", "truth", BOTH, truth)]
    yield "Thrust", "N", list(_thrusts(log))
    yield "Reach of the arm", "m", list(_reach(log))
    yield "Joint angles", "rad", list(_angles(log, "joint"))
    yield "Vectoring angles", "rad", list(_angles(log, "vectoring"))


def _forces(log: xr.Dataset) -> Iterator[Curve]:
    axis = contact_axis(log)
    for label, role, seen, name in (
        ("truth", "truth", BOTH, "contact_force"),
        ("estimate", "estimate", ALONE, "external_force_estimate"),
    ):
        if name in log:
            yield Curve(label, role, seen, -smoothed(log, axis.along(log[name].values)))


def _thrusts(log: xr.Dataset) -> Iterator[Curve]:
    if "thrusts" not in log:
        return
    thrusts = log.thrusts.values
    yield Curve("largest of all rotors", "truth", COMPARED, thrusts.max(axis=1))
    for name, values in zip(log.rotor.values, thrusts.T, strict=True):
        yield Curve(str(name), "truth", ALONE, values)


def _angles(log: xr.Dataset, kind: str) -> Iterator[Curve]:
    truth, command = f"{kind}_angles", f"{kind}_angles_command"
    if truth not in log:
        return
    for i, name in enumerate(log[kind].values):
        yield Curve(str(name), "truth", ALONE, log[truth].values[:, i])
        if command in log:
            yield Curve(f"{name} command", "command", ALONE, log[command].values[:, i])


def _reach(log: xr.Dataset) -> Iterator[Curve]:
    for label, role, seen, name in (
        ("reference", "reference", BOTH, "reach_reference"),
        ("command", "command", ALONE, "reach_command"),
        ("truth", "truth", BOTH, "reach"),
    ):
        if name in log:
            yield Curve(label, role, seen, log[name].values)


def smoothed(log: xr.Dataset, values: np.ndarray) -> np.ndarray:
    """Values, (k, ...), averaged over `SMOOTHING`."""
    return around(values, samples_within(log.time.values, SMOOTHING)).mean(axis=-1)
