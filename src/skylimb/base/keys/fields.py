"""Types and keys of the fields of a configuration class."""

from __future__ import annotations

import dataclasses
import functools
import types
import typing
from typing import Any

from skylimb.base.keys.key import Key


@functools.cache
def fields_of(cls: type) -> dict[str, tuple[Any, Key | None]]:
    """Type and `Key` of every field that a dataclass is built from; None where a field has no key.

    A field that an heir declares again without a key, to give it another default, keeps its ancestor's key.
    """
    hints = typing.get_type_hints(cls, include_extras=True)
    ancestors = [fields_of(base) for base in cls.__mro__[1:] if dataclasses.is_dataclass(base)]
    found: dict[str, tuple[Any, Key | None]] = {}
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        if not field.init:
            continue
        kind: Any = hints[field.name]
        key: Key | None = None
        if typing.get_origin(kind) is typing.Annotated:
            kind, *notes = typing.get_args(kind)
            key = next((note for note in notes if isinstance(note, Key)), None)
        else:
            inherited = (fields[field.name][1] for fields in ancestors if field.name in fields)
            key = next(filter(None, inherited), None)
        found[field.name] = (kind, key)
    return found


@functools.cache
def section_of(kind: Any) -> type | None:
    """The dataclass that a field of type `X` or `X | None` holds, else None."""
    members = [member for member in members_of(kind) if member is not type(None)]
    alone = members[0] if len(members) == 1 else None
    return alone if isinstance(alone, type) and dataclasses.is_dataclass(alone) else None


@functools.cache
def entry_section(kind: Any) -> type | None:
    """The dataclass of the entries of dict[str, X] or tuple[X, ...], else None."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin is dict:
        return section_of(arguments[1])
    return section_of(arguments[0]) if origin is tuple and arguments[1:] == (...,) else None


def holds_configurations(kind: Any) -> bool:
    """Whether a field is a configuration, or a dict or tuple of some, so that it needs no key of its own."""
    return section_of(kind) is not None or entry_section(kind) is not None


def has_numbers(kind: Any) -> bool:
    """Whether a value of this type is or has numbers that a range can hold for."""
    if kind in (int, float):
        return True
    is_choice = typing.get_origin(kind) is typing.Literal
    return not is_choice and any(has_numbers(argument) for argument in typing.get_args(kind))


@functools.cache
def members_of(kind: Any) -> tuple[Any, ...]:
    """The types of a union; of any other type, that type alone."""
    is_union = typing.get_origin(kind) in (typing.Union, types.UnionType)
    return typing.get_args(kind) if is_union else (kind,)


def default_of(field: dataclasses.Field[Any]) -> Any:
    """The value of a field that is left out; `dataclasses.MISSING` where it cannot be."""
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default
