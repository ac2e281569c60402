"""What happened to live flights, as a page marks it: one gesture of a hand, of many events, is one mark."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np

from skylimb.apps.studio.branches import TOGETHER
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.flight.events import Event, GainChange, Push, SurfaceChange


def marks_of(flights: Sequence[LiveFlight], held: Push | None) -> list[dict[str, Any]]:
    """What happens to the flights in the order of time; what happens to several is listed once.

    Args:
        flights: beside each other.
        held: the push by hand that lasts until it is let go: its mark ends where it begins.
    """
    told: dict[tuple[Any, ...], tuple[Event, bool]] = {}
    for flight in flights:
        for event in flight.experiment.events:
            by_hand = event not in flight.first.events
            told.setdefault((event.time, event.kind, event.words), (event, by_hand))
    gestures: list[list[Event]] = []
    last: dict[Hashable, list[Event]] = {}
    for _, (event, by_hand) in sorted(told.items(), key=lambda item: item[0]):
        of = _subject(event) if by_hand else None
        if of in last and _goes_on(last[of][-1], event):
            last[of].append(event)
        else:
            gestures.append([event])
            if of is not None:
                last[of] = gestures[-1]
    return [_mark(gesture, held) for gesture in gestures]


def _subject(event: Event) -> Hashable:
    """What a hand changes; None for events of which no hand makes many."""
    match event:
        case Push():
            return event.kind, event.link
        case GainChange():
            return event.kind, event.key
        case SurfaceChange():
            return event.kind, *sorted(event.changed)
    return None


def _goes_on(event: Event, following: Event) -> bool:
    """Whether another event of one subject belongs to the same gesture."""
    if isinstance(event, Push):
        return following.time <= event.time + event.duration + 1e-6
    return following.time <= event.time + TOGETHER


def _mark(gesture: Sequence[Event], held: Push | None) -> dict[str, Any]:
    first, last = gesture[0], gesture[-1]
    end = last.time + (0.0 if held is not None and last == held else last.duration)
    words = last.words
    if len(gesture) > 1 and isinstance(last, Push):
        pushes = [event for event in gesture if isinstance(event, Push)]
        words = f"up to {max(pushes, key=lambda push: float(np.linalg.norm(push.force))).words}"
    return {"kind": first.kind, "time": first.time, "duration": round(end - first.time, 9), "words": words}
