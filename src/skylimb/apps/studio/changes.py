"""What people do to a flight, as events of its experiment."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from skylimb.flight.events import Event, GainChange, Push
from skylimb.flight.experiments.experiment import Experiment

DURATION = 0.1
"""How long a gain takes to its new value, s."""


def with_events(experiment: Experiment, *more: Event, without: Sequence[Event] = ()) -> Experiment:
    """The experiment with some events more, and without others of it."""
    kept = tuple(one for one in experiment.events if not any(one is other for other in without))
    return dataclasses.replace(experiment, events=(*kept, *more))


def with_gain(experiment: Experiment, time: float, key: str, value: Any) -> Experiment:
    """The experiment with a gain that changes at `time` (s); one of the same moment is replaced."""
    if isinstance(value, Sequence):
        value = tuple(map(float, value))
    same = [
        one for one in experiment.events if isinstance(one, GainChange) and (one.time, one.key) == (time, key)
    ]
    return with_events(experiment, GainChange(time, key, value, duration=DURATION), without=same)


def without_push(experiment: Experiment, held: Push, time: float) -> Experiment:
    """The experiment with a push that ends at `time` (s), or never was where it would begin then."""
    shorter = round(time - held.time, 9)
    ended = (dataclasses.replace(held, duration=shorter),) if shorter > 0.0 else ()
    return with_events(experiment, *ended, without=(held,))
