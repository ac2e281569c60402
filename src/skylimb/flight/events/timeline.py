"""What all events of a flight do, tick by tick; and what must hold of them before anything flies."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import brief
from skylimb.flight.events.body import BodyChange
from skylimb.flight.events.event import Event, EventContext, GainRows, ModelRows, TickRows
from skylimb.flight.events.gain import GainChange
from skylimb.flight.events.joint import JointFault
from skylimb.flight.events.push import Push, Wrench
from skylimb.flight.events.rotor import RotorChange
from skylimb.flight.events.sensor import SensorFault
from skylimb.flight.events.surface import SurfaceChange
from skylimb.flight.events.tick import LateTicks
from skylimb.flight.events.wind import Wind

_KINDS = (
    GainChange,
    Push,
    Wind,
    SurfaceChange,
    RotorChange,
    LateTicks,
    JointFault,
    BodyChange,
    SensorFault,
)
EVENTS: dict[str, type[Event]] = {cls.kind: cls for cls in _KINDS}
"""Every kind of event by its name in `[[events]]`; no two kinds write the same number of the model."""

ALL_KINDS = frozenset(EVENTS)
"""What a driver can apply that has controller and simulated plant at hand."""

CONTROLLER_KINDS = frozenset(kind for kind, cls in EVENTS.items() if cls.on == "controller")
"""What a driver can apply that has the controller alone."""

PLANT_KINDS = ALL_KINDS - CONTROLLER_KINDS
"""What a simulated robot can apply, whoever flies it."""


OWN_PLANT_KINDS = ALL_KINDS - {SurfaceChange.kind, BodyChange.kind}
"""What can happen in a simulator of a user's own: these change neither its bodies nor its surface."""


@dataclass(frozen=True)
class Timeline:
    """What the events of a flight do at every tick that it may have.

    Attributes:
        gains: numbers of the controller that change; None where none do.
        model: numbers of the engine's model that change; None where none do.
        rows: what is added to the rows of sensors; None where nothing is.
        wrenches: on the robot.
    """

    gains: GainRows | None = None
    model: ModelRows | None = None
    rows: TickRows | None = None
    wrenches: tuple[Wrench, ...] = ()


def timeline(events: Sequence[Event], context: EventContext, times: np.ndarray) -> Timeline:
    """What events do to a flight.

    Args:
        events: in the order of the experiment.
        context: what they act on; those on a plant are left out where it has none.
        times: of every tick that the flight may have, s.
    """
    found = Timeline()
    for kind, cls in EVENTS.items():
        own = [event for event in events if event.kind == kind]
        if not own or (cls.on == "plant" and context.plant is None):
            continue
        effect = cls.effect(own, context, times)
        found = Timeline(
            effect if isinstance(effect, GainRows) else found.gains,
            _beside(found.model, effect) if isinstance(effect, ModelRows) else found.model,
            _summed(found.rows, effect) if isinstance(effect, TickRows) else found.rows,
            (*found.wrenches, *effect) if isinstance(effect, tuple) else found.wrenches,
        )
    return found


def _summed(first: TickRows | None, second: TickRows) -> TickRows:
    """What two kinds of events add to the rows."""
    return second if first is None else TickRows(first.added + second.added)


def _beside(first: ModelRows | None, second: ModelRows) -> ModelRows:
    """Numbers of two kinds of events in one table."""
    if first is None:
        return second
    width = first.values.shape[1]
    moved = (place._replace(column=place.column + width) for place in second.places)
    return ModelRows((*first.places, *moved), np.hstack([first.values, second.values]))


def require_events(
    events: Sequence[Event], context: EventContext, end: float, known: Sequence[Event] = ()
) -> None:
    """Raise a `ConfigError` for an event of a thing or a time that is not there, or two that contradict.

    Args:
        events: of the experiment.
        context: what they act on.
        end: of the longest that the flight may take, s since take-off.
        known: events that were asked about such a context before, and are not asked again.
    """
    asked = {id(event) for event in known}
    for number, event in enumerate(events):
        for key, at in (("time", event.time), ("latest", event.latest or 0.0)):
            if at > end:
                raise ConfigError(
                    f"events.{number}.{key} = {at:g} s: {event}, {event.words}, comes after the flight's end "
                    f"at {end:g} s"
                )
        if event.lasts and 0.0 < event.duration < context.period - 1e-9:
            raise ConfigError(
                f"events.{number}.duration = {event.duration:g} s: {event} lasts shorter than a control "
                f"period of {context.period:g} s; it acts in whole ones"
            )
        if id(event) not in asked:
            event.require(context)
    given: dict[tuple[str, float, str], Any] = {}
    for event in events:
        for name, value in event.changed.items():
            before = given.setdefault((event.kind, event.time, name), value)
            if not np.array_equal(np.ravel(before), np.ravel(value)):
                raise ConfigError(
                    f"events: two of {event} contradict each other: {name} to {brief(value)} and to "
                    f"{brief(before)}"
                )


def require_applied(events: Sequence[Event], kinds: Collection[str], who: str) -> None:
    """Raise a `ConfigError` for an event of a kind that nobody can apply there.

    Args:
        events: of the experiment.
        kinds: that can be applied.
        who: flies, and cannot apply the others.
    """
    for number, event in enumerate(events):
        if event.kind not in kinds:
            able = f"applies events of kind {', '.join(sorted(kinds))}" if kinds else "applies none"
            raise ConfigError(f"events.{number}: {who} cannot apply '{event.kind}' ({event}); it {able}")
