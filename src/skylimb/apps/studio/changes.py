"""What people do to a flight, as events of its experiment."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, TypeVar

from skylimb.flight.events import Event, GainChange, Push
from skylimb.flight.experiments.experiment import Experiment

E = TypeVar("E", bound=Event)

DURATION = 0.1
"""How long a gain takes to its new value, s."""


def with_events(experiment: Experiment, *more: Event, without: Sequence[Event] = ()) -> Experiment:
    """The experiment with some events more, and without others of it."""
    kept = tuple(one for one in experiment.events if not any(one is other for other in without))
    return dataclasses.replace(experiment, events=(*kept, *more))


def with_gain(experiment: Experiment, time: float, key: str, value: Any) -> Experiment:
    """The experiment with a gain that changes at `time` (s); one of the same moment is replaced."""
    same = [
        one for one in experiment.events if isinstance(one, GainChange) and (one.time, one.key) == (time, key)
    ]
    return with_events(experiment, GainChange(time, key, value, duration=DURATION), without=same)


def with_push(experiment: Experiment, first: Experiment, time: float, *push: Push) -> Experiment:
    """The experiment in which a push by hand ends at `time` (s), and another may begin there.

    Args:
        experiment: in which a push by hand lasts until it is let go.
        first: of the take-off, whose own pushes are nobody's.
        time: since take-off, s.
        push: that takes the place of the one that is held; none to push no more.
    """
    by_hand = [one for one in experiment.events if isinstance(one, Push) and one not in first.events]
    held = [one for one in by_hand if one.time + one.duration > time + 1e-9]
    shorter = [(one, round(time - one.time, 9)) for one in held]
    ended = [dataclasses.replace(one, duration=duration) for one, duration in shorter if duration > 0.0]
    return with_events(experiment, *ended, *push, without=held)


def settled(
    kind: type[E], experiment: Experiment, until: float = math.inf, first: Experiment | None = None
) -> list[E]:
    """Its changes of a kind that have begun by `until` (s), in order; without those of `first`."""
    own = first.events if first else ()
    found = [one for one in experiment.events if isinstance(one, kind) and one not in own]
    return sorted((one for one in found if one.time <= until), key=lambda change: change.time)


def settled_gains(
    experiment: Experiment, until: float = math.inf, first: Experiment | None = None
) -> dict[str, Any]:
    """What every gain comes to that has begun to change by `until` (s), without changes of `first`."""
    return {change.key: change.value for change in settled(GainChange, experiment, until, first)}


def as_of(experiment: Experiment, first: Experiment, time: float) -> Experiment:
    """The experiment without what people did from `time` (s) on: a push that they held ends there.

    Args:
        experiment: with all that they did.
        first: of the take-off, whose own events stay.
        time: since take-off, s.
    """
    before = with_push(experiment, first, time)
    later = [one for one in before.events if one.time > time - 1e-9 and one not in first.events]
    return with_events(before, without=later)


def alike_until(one: Experiment, other: Experiment) -> float:
    """Time up to which flights of two experiments are alike that differ in their events, s."""
    apart = [*_missing(one, other), *_missing(other, one)]
    times = []
    for event in apart:
        pushes = [twin for twin in apart if isinstance(twin, Push) and twin is not event]
        same = [twin for twin in pushes if dataclasses.replace(twin, duration=event.duration) == event]
        shared = min([event.duration, *(twin.duration for twin in same)]) if same else 0.0
        times.append(event.time + shared)
    return min(times, default=math.inf)


def _missing(one: Experiment, other: Experiment) -> list[Event]:
    """Events of one experiment that another one doesn't have."""
    known = set(map(id, other.events))
    return [event for event in one.events if id(event) not in known and event not in other.events]
