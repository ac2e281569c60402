"""Events as an experiment's file has them: `[[events]]`, each with its kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from skylimb.base.config import from_mapping, to_mapping
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.keys.key import shown
from skylimb.flight.events.event import Event
from skylimb.flight.events.timeline import EVENTS

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
    kind = table.get(KIND)
    if kind is None:
        raise ConfigError(f"{where}: the key '{at}.{KIND}' is missing: one of {', '.join(sorted(EVENTS))}")
    if not isinstance(kind, str) or kind not in EVENTS:
        raise unknown_name(f"kind of {at}", str(kind), EVENTS)
    return from_mapping(EVENTS[kind], table, where, at)


def event_tables(events: Sequence[Event]) -> list[dict[str, Any]]:
    """Events as plain tables, which `events_from_mapping` reads back to equal ones."""
    return [to_mapping(event) for event in events]
