"""The keys of a configuration as a list: for tables, sliders and logs."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from skylimb.keys.fields import default_of, entry_section, fields_of, has_numbers, members_of, section_of
from skylimb.keys.key import Key

REQUIRED: Any = dataclasses.MISSING
"""The default of a key that has none."""


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


def keys_of(cls: type, at: str = "") -> dict[str, KeyInfo]:
    """Every key of a configuration class and of those inside it, by dotted name.

    `<name>` stands for the name of an entry of a dict of configurations, `<n>` for the place in a tuple.
    """
    found: dict[str, KeyInfo] = {}
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        kind, key = fields_of(cls)[field.name]
        name = f"{at}.{field.name}" if at else field.name
        section = section_of(kind)
        if key is None and section is not None:
            found |= keys_of(section, name)
        elif key is None and entry_section(kind) is not None:
            mark = "<name>" if typing.get_origin(kind) is dict else "<n>"
            found |= keys_of(typing.cast(type, entry_section(kind)), f"{name}.{mark}")
        else:
            found[name] = KeyInfo(key or Key(), kind, default_of(field))
    return found


def described(config: Any, at: str = "") -> Iterator[tuple[str, Any, KeyInfo]]:
    """Dotted key, value and description of every value in a configuration, in the order of its fields."""
    for field in dataclasses.fields(config):
        kind, key = fields_of(type(config))[field.name]
        name, value = (f"{at}.{field.name}" if at else field.name), getattr(config, field.name)
        if key is None and dataclasses.is_dataclass(value):
            yield from described(value, name)
        elif key is None and entry_section(kind) is not None:
            entries = value.items() if isinstance(value, Mapping) else enumerate(value)
            for place, part in entries:
                yield from described(part, f"{name}.{place}")
        elif value is not None or section_of(kind) is None:
            yield name, value, KeyInfo(key or Key(), kind, default_of(field))


def units_of(config: Any) -> dict[str, str]:
    """Unit of every value in a configuration that has one, by dotted key."""
    return {name: info.unit for name, _, info in described(config) if info.unit}
