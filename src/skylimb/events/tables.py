"""Events as an experiment's file has them: `[[events]]`, each with its kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from skylimb.config import from_mapping, to_mapping
from skylimb.errors import ConfigError, unknown_name
from skylimb.events.event import Event
from skylimb.events.timeline import EVENTS
from skylimb.keys.key import shown

KIND = "kind"


def events_from_mapping(tables: Any, where: str) -> tuple[Event, ...]:
    """The events of a list of tables; each one's `kind` selects among `EVENTS`.

    Raises:
        ConfigError: a key of the wrong type, or a value out of range.
        UnknownNameError: a kind or key that does not exist.
    """
    if not isinstance(tables, Sequence) or isinstance(tables, str):
        raise ConfigError(f"{where}: events = {shown(tables)} should be a list of tables, [[events]]")
    return tuple(_event(table, f"events.{number}", where) for number, table in enumerate(tables))


def _event(table: Any, at: str, where: str) -> Event:
    if isinstance(table, Event):
        return table
    if not isinstance(table, Mapping):
        raise ConfigError(f"{where}: {at} = {shown(table)} should be a table of keys")
    rest = dict(table)
    kind = rest.pop(KIND, None)
    if kind is None:
        raise ConfigError(f"{where}: the key '{at}.{KIND}' is missing: one of {', '.join(sorted(EVENTS))}")
    if not isinstance(kind, str) or kind not in EVENTS:
        raise unknown_name(f"kind of {at}", str(kind), EVENTS)
    return from_mapping(EVENTS[kind], rest, where, at)


def event_tables(events: Sequence[Event]) -> list[dict[str, Any]]:
    """Events as plain tables, which `events_from_mapping` reads back to equal ones."""
    return [{KIND: event.kind, **to_mapping(event)} for event in events]
