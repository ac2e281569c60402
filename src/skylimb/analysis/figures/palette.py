"""What a run is called in print, and the colour that it has in every figure and video.

Colours follow the Okabe-Ito palette, which people with the common kinds of colour blindness can tell apart. A
controller has the same colour everywhere.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import chain, repeat
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skylimb.analysis.recording import Run

CONTROLLER_COLOURS = {
    "pid": "#D55E00",
    "impedance": "#0072B2",
    "admittance": "#009E73",
    "hybrid": "#7A3E9D",
    "following": "#3A9FD8",
    "drawing": "#CC79A7",
    "task_frame": "#E69F00",
}
OTHER_COLOURS = ("#8C6D00", "#000000", "#B2182B", "#4D4D4D", "#66A61E")

LABELS = {
    "pid": "PID",
    "impedance": "Impedance",
    "admittance": "Admittance",
    "hybrid": "Hybrid",
    "following": "Following",
    "drawing": "Drawing",
    "task_frame": "Task frame",
}

CURVES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Curves that belong to no controller; Okabe and Ito's colours."""


def colours_of(controllers: Iterable[str]) -> list[str]:
    """A colour for each of some controllers beside each other.

    It is the controller's own, and another where it is there twice or is not one of ours.
    """
    others = chain.from_iterable(repeat(OTHER_COLOURS))
    found: list[str] = []
    for name in controllers:
        own = CONTROLLER_COLOURS.get(name)
        found.append(own if own and own not in found else next(others))
    return found


def colours(runs: Mapping[str, Run]) -> dict[str, str]:
    """The colour of each run: its controller's (`colours_of`)."""
    return dict(zip(runs, colours_of(run.controller for run in runs.values()), strict=True))


def label(name: str) -> str:
    """How a run is called in print."""
    return LABELS.get(name, name)
