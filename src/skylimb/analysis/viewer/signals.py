"""The plots beside the view: which curves of a flight stand in which panel."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from skylimb.analysis.scores.signals import along_contact, contact_axis, samples_within, sliding_axes
from skylimb.analysis.scores.task import tools_of
from skylimb.analysis.viewer.packing import packed

if TYPE_CHECKING:
    import xarray as xr

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


Line = tuple[str, str, str, str]
"""A curve of one signal: label, role and when it is seen (see `Curve`), and the signal's name."""

_POSITION: tuple[Line, ...] = (
    ("reference", "reference", BOTH, "cog_position_reference"),
    ("truth", "truth", BOTH, "cog_position"),
    ("estimate", "estimate", ALONE, "cog_position_estimate"),
)
_FORCE: tuple[Line, ...] = (
    ("truth", "truth", BOTH, "contact_force"),
    ("estimate", "estimate", ALONE, "external_force_estimate"),
)
_REACH: tuple[Line, ...] = (
    ("reference", "reference", BOTH, "reach_reference"),
    ("command", "command", ALONE, "reach_command"),
    ("truth", "truth", BOTH, "reach"),
)
_LARGEST: tuple[Line, ...] = (("largest of all rotors", "truth", COMPARED, "thrusts"),)


def packed_panels(log: xr.Dataset) -> dict[str, Any]:
    """The panels of a flight, and the numbers of all their curves in one pack.

    Returns:
        `panels`: title, unit and curves, each with the number of its column; `signals`: time and columns.
    """
    keep = slice(None, None, samples_within(log.time.values, 1.0 / RATE))
    column = itertools.count(1)
    panels: list[dict[str, Any]] = []
    values = [log.time.values]
    for title, unit, found in _panels(log):
        curves = [
            {"label": each.label, "role": each.role, "seen": each.seen, "column": next(column)}
            for each in found
        ]
        values += [each.values for each in found]
        panels += [{"title": title, "unit": unit, "curves": curves}] if curves else []
    return {"panels": panels, "signals": packed(np.stack(values, axis=1)[keep])}


def _panels(log: xr.Dataset) -> Iterator[tuple[str, str, list[Curve]]]:
    for axis in (*sliding_axes(log), contact_axis(log)):
        yield f"Centre of gravity along {axis}", "m", _curves(log, _POSITION, axis.along)
    yield "Pressing force", "N", _curves(log, _FORCE, lambda force: -smoothed(log, along_contact(log, force)))
    for tool in tools_of(log):
        truth = log[tool.signal].values
        commanded = np.full(len(truth), tool.commanded(log))
        yield (
            tool.title,
            tool.unit,
            [
                Curve("commanded", "reference", BOTH, commanded),
                Curve("truth", "truth", BOTH, truth),
            ],
        )
    largest = _curves(log, _LARGEST, lambda thrusts: thrusts.max(axis=1))
    yield "Thrust", "N", [*largest, *_entries(log, "thrusts", "truth")]
    yield "Reach of the arm", "m", _curves(log, _REACH, np.asarray)
    for kind in ("joint", "vectoring"):
        angles = _entries(log, f"{kind}_angles", "truth")
        commands = _entries(log, f"{kind}_angles_command", "command") if angles else []
        yield f"{kind.capitalize()} angles", "rad", [*angles, *commands]


def _curves(log: xr.Dataset, lines: Iterable[Line], of: Callable[[np.ndarray], np.ndarray]) -> list[Curve]:
    """The lines of a panel that the log has signals for; `of` makes a number a sample of each."""
    there = [line for line in lines if line[3] in log]
    return [Curve(label, role, seen, of(log[signal].values)) for label, role, seen, signal in there]


def _entries(log: xr.Dataset, signal: str, role: str) -> list[Curve]:
    """A curve for each entry of a signal, by the name that its dimension has for it."""
    if signal not in log:
        return []
    suffix = " command" * (role == "command")
    names = log[log[signal].dims[1]].values
    return [
        Curve(f"{name}{suffix}", role, ALONE, values)
        for name, values in zip(names, log[signal].values.T, strict=True)
    ]


def smoothed(log: xr.Dataset, values: np.ndarray) -> np.ndarray:
    """Values, (k, ...), averaged over the last `SMOOTHING`, as a live flight shows them."""
    count = samples_within(log.time.values, SMOOTHING)
    first = np.repeat(values[:1], count - 1, axis=0)
    return sliding_window_view(np.concatenate([first, values]), count, axis=0).mean(axis=-1)
