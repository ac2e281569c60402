"""What a run is called in print, and the colour that it has in every figure and video.

Colours follow the Okabe-Ito palette, which people with the common kinds of colour blindness can tell apart. A
controller has the same colour everywhere.
"""

from __future__ import annotations

from collections.abc import Mapping

from skylimb.recording import Run

CONTROLLER_COLOURS = {
    "pid": "#D55E00",
    "impedance": "#0072B2",
    "admittance": "#009E73",
    "hybrid": "#7A3E9D",
    "following": "#3A9FD8",
}
OTHER_COLOURS = ("#CC79A7", "#8C6D00", "#000000", "#B2182B", "#4D4D4D", "#66A61E")

LABELS = {
    "pid": "PID",
    "impedance": "Impedance",
    "admittance": "Admittance",
    "hybrid": "Hybrid",
    "following": "Following",
}


def colours(runs: Mapping[str, Run]) -> dict[str, str]:
    """A colour for each run.

    It is its controller's own, and another where two runs share a controller or it is not one of ours.
    """
    others = iter(OTHER_COLOURS * (1 + len(runs) // len(OTHER_COLOURS)))
    found: dict[str, str] = {}
    for name, run in runs.items():
        own = CONTROLLER_COLOURS.get(run.controller)
        found[name] = own if own and own not in found.values() else next(others)
    return found


def label(name: str) -> str:
    """How a run is called in print."""
    return LABELS.get(name, name)
