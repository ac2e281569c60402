"""Marks of what happened to a flight, in every figure over time: where it began, and how long it lasted.

Events have numbers in the order of time, as in the report's list. Their kinds differ by the line's style.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from skylimb.analysis.figures import style
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.signals import HappenedEvent, common_events, events_of

LOOKS = {
    "push": ((0, (4, 2)), "#1F4E9E"),
    "gain": ((0, (5, 1.5, 1, 1.5)), "#00695C"),
    "surface": ((0, (1, 1.3)), "#7A4B00"),
}
"""Style and colour of the lines of each kind that is known here."""

OTHER = ((0, (7, 2)), style.REFERENCE)
"""Of every other kind."""

FEW, SHORT = 3, 40
"""Events that a legend tells one by one, and letters that it has room for."""

_BAND = 0.13
"""How much of its colour a band has."""

_LINE, _EDGES, _LETTER = 0.06, 0.07, 0.055
"""Inches from one line of a kind to the next, and of a number: around it, and for each letter."""

_TO = "\N{EN DASH}"


def mark_events(ax: Axes, log: xr.Dataset, numbered: bool = False) -> None:
    """Draw a thin line where each event began, and a pale band while it lasted; nothing where there was none.

    Lines and numbers that would lie on each other become one: "3-7" stands for five events.

    Args:
        ax: panel with the time of the flight from left to right.
        log: of the flight.
        numbered: whether the events' numbers stand at the upper edge, as in one of a flight's panels.
    """
    events = events_of(log)
    if not events:
        return
    begin, end = (float(log.time.values[k]) for k in (0, -1))
    spec, figure = ax.get_subplotspec(), ax.get_figure(root=True)
    assert spec is not None
    assert figure is not None
    inch = (end - begin) * spec.get_gridspec().ncols / figure.get_figwidth()
    for kind in dict.fromkeys(event.kind for event in events):
        line, colour = LOOKS.get(kind, OTHER)
        own = [event for event in events if event.kind == kind]
        for first, last in _stretches(own, end):
            ax.axvspan(first, last, color=colour, alpha=_BAND, linewidth=0, zorder=0.5)
        for time, _ in _heaps(own, lambda _: _LINE * inch):
            ax.axvline(time, color=colour, linestyle=line, linewidth=0.7, zorder=1.5)
    for time, text in _heaps(events, lambda text: (_EDGES + _LETTER * len(text)) * inch) if numbered else ():
        late = time > end - 0.1 * (end - begin)
        ax.annotate(
            text,
            (time, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(-1.5 if late else 1.5, -0.5),
            textcoords="offset points",
            ha="right" if late else "left",
            va="top",
            fontsize=6,
            bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.4},
        )


def event_signs(runs: Mapping[str, Run]) -> list[Patch]:
    """Signs for the legend: of few events one for each, with number and words, else one for each kind."""
    events = common_events(run.log for run in runs.values())
    if events is not None and len(events) <= FEW and all(len(event.words) <= SHORT for event in events):
        return [_sign(event.kind, f"{k}: {event.words}") for k, event in enumerate(events, 1)]
    kinds = dict.fromkeys(event.kind for run in runs.values() for event in events_of(run.log))
    return [_sign(kind, f"event: {kind}") for kind in kinds]


def _sign(kind: str, text: str) -> Patch:
    line, colour = LOOKS.get(kind, OTHER)
    return Patch(facecolor=(colour, _BAND), edgecolor=colour, linestyle=line, linewidth=0.7, label=text)


def _stretches(events: Iterable[HappenedEvent], end: float) -> Iterator[tuple[float, float]]:
    """The stretches of time, s, in which one of some events went on, none twice."""
    last = -1.0
    for event in events:
        first, last = max(event.time, last), max(last, min(event.time + event.duration, end))
        if first < last:
            yield first, last


def _heaps(events: Sequence[HappenedEvent], room: Callable[[str], float]) -> list[tuple[float, str]]:
    """Where marks of events stand, s, and their numbers; one mark for those that would lie on each other.

    Args:
        events: in the order of time.
        room: that a mark with some numbers takes, s.
    """
    heaps: list[tuple[float, str]] = []
    for number, event in enumerate(events, 1):
        time, text = heaps[-1] if heaps else (-math.inf, "")
        if event.time - time < room(text):
            heaps[-1] = time, f"{text.partition(_TO)[0]}{_TO}{number}"
        else:
            heaps.append((event.time, f"{number}"))
    return heaps
