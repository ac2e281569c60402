"""The keys of a configuration as a list: for tables, sliders and logs."""

from __future__ import annotations

import dataclasses
import inspect
import sys
import typing
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from skylimb.base.keys.fields import (
    default_of,
    entry_section,
    fields_of,
    has_numbers,
    holds_configurations,
    members_of,
    section_of,
)
from skylimb.base.keys.key import Key

REQUIRED: Any = dataclasses.MISSING
"""The default of a key that has none."""

ANY_NAME, ANY_NUMBER = "<name>", "<n>"
"""What stands in a dotted key for the name of an entry of a dict, and for the place in a tuple."""


@dataclass(frozen=True)
class KeyInfo:
    """A key of a configuration class: its `Key`, its type and its default (`REQUIRED` where it has none)."""

    key: Key
    type: Any
    default: Any = REQUIRED

    @property
    def unit(self) -> str:
        """Unit, empty for a pure number, a text or a switch."""
        return self.key.unit

    @property
    def meaning(self) -> str:
        """What it is, in a few words."""
        return self.key.meaning

    @property
    def choices(self) -> tuple[Any, ...]:
        """The values allowed where they can be listed, else empty."""
        for kind in members_of(self.type):
            if typing.get_origin(kind) is typing.Literal:
                return typing.get_args(kind)
        return ()

    @property
    def range(self) -> str:
        """What is allowed, in words without the unit; empty where every value of the type is."""
        if self.choices:
            return ", ".join(str(choice) for choice in self.choices)
        return self.key.range if has_numbers(self.type) else ""


@dataclass(frozen=True)
class Table:
    """One table of a configuration, without the tables inside it.

    Attributes:
        path: its dotted key, one entry a part; empty for the whole.
        meaning: the first line of its class's docstring.
        rows: name, value and description of each key.
        given: false for an optional table that the configuration does not have; its values are defaults.
    """

    path: tuple[str, ...]
    meaning: str
    rows: tuple[tuple[str, Any, KeyInfo], ...]
    given: bool = True


def summary(thing: Any) -> str:
    """The first line of what is said of a class, a function or a module.

    Nothing where Python leaves docstrings out (-OO): of a dataclass it would be its signature.
    """
    return "" if sys.flags.optimize > 1 else (inspect.getdoc(thing) or "").partition("\n")[0]


def tables_of(config: Any, at: tuple[str, ...] = (), given: bool = True) -> Iterator[Table]:
    """Every table of a configuration, the outer ones first; of a class, with the keys' defaults as values."""
    cls = config if isinstance(config, type) else type(config)
    rows, parts = [], []
    for field in dataclasses.fields(cls):
        kind, key = fields_of(cls)[field.name]
        default = default_of(field)
        value = default if config is cls else getattr(config, field.name)
        if key is None and holds_configurations(kind):
            parts += _parts(kind, value, (*at, field.name))
        else:
            rows.append((field.name, value, KeyInfo(key or Key(), kind, default)))
    yield Table(at, summary(cls), tuple(rows), given)
    for part, path, here in parts:
        yield from tables_of(part, path, given and here)


def keys_of(cls: type) -> dict[str, KeyInfo]:
    """Every key of a configuration class and of those inside it, by dotted key.

    `<name>` stands for the name of an entry of a dict of configurations, `<n>` for the place in a tuple.
    """
    return {".".join((*table.path, name)): info for table in tables_of(cls) for name, _, info in table.rows}


def described(config: Any, at: str = "") -> Iterator[tuple[str, Any, KeyInfo]]:
    """Dotted key, value and description of every value that a configuration has."""
    return rows_of(tables_of(config, tuple(filter(None, at.split(".")))))


def files_of(config: Any, at: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted key of every file that a configuration names (`Key.file`), and the part of it that names it."""
    for name, (kind, key) in fields_of(type(config)).items():
        value = getattr(config, name)
        if key is not None and key.file:
            if value:
                yield f"{at}{name}", config
        elif value is not None and key is None and holds_configurations(kind):
            for part, path, given in _parts(kind, value, (name,)):
                if given:
                    yield from files_of(part, f"{at}{'.'.join(path)}.")


def rows_of(tables: Iterable[Table]) -> Iterator[tuple[str, Any, KeyInfo]]:
    """Dotted key, value and description of every value in the tables that are there."""
    for table in tables:
        if table.given:
            yield from ((".".join((*table.path, name)), value, info) for name, value, info in table.rows)


def units_of(tables: Iterable[Table]) -> dict[str, str]:
    """Unit of every value that has one, by dotted key."""
    return {name: info.unit for name, _, info in rows_of(tables) if info.unit}


def _parts(kind: Any, value: Any, path: tuple[str, ...]) -> list[tuple[Any, tuple[str, ...], bool]]:
    """The configurations in a field: each, or its class where there is none, its path, and whether it is."""
    section = section_of(kind)
    if value is REQUIRED:
        value = None
    if section is not None:
        return [(section, path, False) if value is None else (value, path, True)]
    named = typing.get_origin(kind) is dict
    entries: dict[Any, Any] = dict(value or {}) if named else dict(enumerate(value or ()))
    if not entries:
        return [(entry_section(kind), (*path, ANY_NAME if named else ANY_NUMBER), False)]
    return [(part, (*path, str(name)), True) for name, part in entries.items()]


def brief(value: Any) -> str:
    """A value as TOML has it, numbers with few digits; "-" where there is none."""
    if value is None or value is REQUIRED:
        return "-"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(brief, value))}]"
    return f'"{value}"' if isinstance(value, str) else str(value)
