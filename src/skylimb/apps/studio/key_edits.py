"""What a change of a gain or key comes to: other experiments that are flown on with, or another take-off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from skylimb.apps.studio.changes import with_gain
from skylimb.apps.studio.controls import IN_FLIGHT, PREFIX, values_of
from skylimb.apps.studio.drawings import TEXT, drawn_last
from skylimb.apps.studio.flight_setup import FlightSetup
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.apps.studio.live_flights import LiveFlights
from skylimb.apps.studio.surface_edits import DURATION, surface_now, with_surface
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.keys import brief
from skylimb.flight.events import SurfaceChange
from skylimb.flight.experiments.experiment import Experiment

Values = Mapping[tuple[str, int | None], Any]
"""Values of keys: of each flight that has such a gain, or one for all (None)."""


@dataclass(frozen=True)
class Edit:
    """A change of keys.

    Attributes:
        words: what it is.
        setup: of the next take-off.
        experiments: that are flown on with; None where the flights have to take off anew.
    """

    words: str
    setup: FlightSetup
    experiments: Mapping[LiveFlight, Experiment] | None = None


def values_at_takeoff(live: LiveFlights) -> dict[tuple[str, int | None], Any]:
    """Of all keys."""
    known = live.known.items()
    return {(key, number): value for key, control in known for number, value in values_of(control)}


def value_now(live: LiveFlights, key: str, number: int | None = None) -> Any:
    """What a key is now, of one flight where it is a gain."""
    control = live.known[key]
    if number is not None:
        first = dict(values_of(control))
        return live.gains_now(number).get(key.removeprefix(PREFIX), first[number])
    surface = surface_now(live.shown.experiment, live.shown.time)
    return surface.get(key.removeprefix("surface."), control["value"])


def key_edit(live: LiveFlights, key: str, value: Any, flight: int | None, entry: int | None) -> Edit:
    """A key of the experiment gets a value, or a gain of one flight or of all that have it (None).

    Args:
        live: the flights.
        key: of a control.
        value: of the key, or of one entry of it.
        flight: whose gain.
        entry: of a vector, from 0; the others stay what they are now.

    Raises:
        ConfigError: when there is no such key, flight or entry, or the value names a file.
    """
    control = live.known.get(key)
    if control is None:
        raise unknown_name("key that can be set here", key, live.known)
    if isinstance(value, str) and value not in control["choices"] and key != TEXT and _names_a_file(value):
        raise ConfigError(f"{key} = '{value[:60]}' names a file; name it on the command line with --set")
    having = control.get("flights", [None])
    chosen = having if flight is None else [flight]
    if not set(chosen) <= set(having):
        gain = key.removeprefix(PREFIX)
        raise ConfigError(f"flight {flight} has no gain '{gain}'; those that have it are {having}")
    values = {(key, one): _with_entry(value_now(live, key, one), entry, value, key) for one in chosen}
    words = f"{key.removeprefix(PREFIX)} to {brief(value)}"
    # A key is kept by the next take-off; a gain is for as long as its flight has it.
    setup = live.setup if "flights" in control else live.setup.with_keys(drawn_last({key: values[key, None]}))
    if _acts_in_flight(live, values):
        return Edit(words, setup, _experiments(live, values))
    gains = [dict(own) for own in live.gains()]
    for (_, number), to in values.items():
        if number is not None:
            gain = key.removeprefix(PREFIX)
            gains[number] = {**_without_law(gains[number], gain), gain: to}
    return Edit(words, replace(setup, gains=tuple(gains)))


def back_edit(live: LiveFlights, preset: Values | None, first: Mapping[str, Any], key: str | None) -> Edit:
    """A key, or every key (None), gets back a value that it had.

    Args:
        live: the flights.
        preset: the values of what nobody has changed; None for those at take-off.
        first: keys of the experiment that were given when the studio began.
        key: that is brought back.

    Raises:
        ConfigError: when nothing of it has changed.
    """
    names, to_preset = list(live.known) if key is None else [key], preset is not None
    to = values_at_takeoff(live) if preset is None else preset
    values = {
        at: value
        for at, value in to.items()
        if at[0] in names and as_value(value) != as_value(value_now(live, *at))
    }
    # Keys that are no controls, such as files, go with all others.
    unseen = {name for name in live.begun.keys.keys() - live.known.keys() if key is None and to_preset}
    unseen -= {name for name in unseen if live.begun.keys[name] == first.get(name)}
    words = f"{key or 'everything'} back to {'the preset' if to_preset else 'take-off'}"
    if not unseen and _acts_in_flight(live, values):
        return Edit(words, live.setup, _experiments(live, values))
    gains = [dict(own) for own in live.gains()]
    for name, number in values:
        if number is not None:
            gain = name.removeprefix(PREFIX)
            gains[number] = _without_law(gains[number], gain)
            gains[number].pop(gain, None)
    changed = unseen | {name for name, number in values if number is None}
    keys = {name: value for name, value in live.setup.keys.items() if name not in changed}
    keys |= {name: first[name] for name in changed & first.keys()}
    return Edit(words, replace(live.setup, keys=keys, gains=tuple(gains)))


def _acts_in_flight(live: LiveFlights, values: Values) -> bool:
    """Whether keys can get these values while a flight that they concern goes on."""
    numbers = {number for _, number in values}
    going = [flight for n, flight in enumerate(live.flights) if {n, None} & numbers and not flight.over]
    return bool(going) and all(live.known[key]["acts"] == IN_FLIGHT for key, _ in values)


def _experiments(live: LiveFlights, values: Values) -> dict[LiveFlight, Experiment]:
    """The experiments in which keys that act in flight have these values from now on."""
    found = {flight: flight.experiment for flight in live.going}
    surface: dict[str, Any] = {}
    for (name, number), to in values.items():
        if number is None:
            surface[name.removeprefix("surface.")] = as_value(to)
        elif (flight := live.flights[number]) in found:
            found[flight] = with_gain(found[flight], flight.time, name.removeprefix(PREFIX), as_value(to))
    if surface:
        change = SurfaceChange(live.time, duration=DURATION, **surface)
        found = {flight: with_surface(experiment, change) for flight, experiment in found.items()}
    return found


def as_value(value: Any) -> Any:
    """A value from a page as a configuration has it."""
    return tuple(map(as_value, value)) if isinstance(value, list | tuple) else value


def _with_entry(now: Any, entry: int | None, value: Any, key: str) -> Any:
    """A value, or what is now with one entry changed to it."""
    if entry is None:
        return as_value(value)
    if not isinstance(now, tuple | list) or entry >= len(now):
        raise ConfigError(f"{key} = {brief(now)} has no entry {entry + 1}")
    return tuple(value if i == entry else one for i, one in enumerate(as_value(now)))


def _names_a_file(text: str) -> bool:
    """Whether a text reads like a path or a file's name, with or without a function behind it."""
    stem, dot, ending = text.partition(":")[0].rpartition(".")
    return "/" in text or "\\" in text or bool(stem and dot and ending.isalnum() and not ending.isdigit())


def _without_law(gains: Mapping[str, Any], key: str) -> dict[str, Any]:
    """The gains without those of a slot whose law `key` changes: another law has other gains."""
    slot, _, name = key.partition(".")
    return {old: value for old, value in gains.items() if name != "law" or old.partition(".")[0] != slot}
