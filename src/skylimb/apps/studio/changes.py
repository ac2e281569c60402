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


def settled_gains(experiment: Experiment, first: Experiment | None = None) -> dict[str, Any]:
    """What every gain that changes in flight comes to, without those that change in `first` as well."""
    own = first.events if first else ()
    gains = (one for one in experiment.events if isinstance(one, GainChange) and one not in own)
    return {change.key: change.value for change in sorted(gains, key=lambda change: change.time)}
