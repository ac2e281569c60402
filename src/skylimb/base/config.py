"""TOML tables into frozen dataclasses and back, strictly.

Every configuration of this package is a frozen dataclass whose fields carry a `skylimb.base.keys.Key`. This
module carries values between those dataclasses and TOML: an unknown key, a wrong type or a value out of range
raises a `ConfigError` that names the dotted key, the value it had, what was allowed, and the nearest right
name. Lists become tuples and whole numbers serve as floats; nothing else is converted. Every value is checked
once, by the dataclass that holds it (`skylimb.base.keys.checks`).
"""

from __future__ import annotations

import dataclasses
import json
import re
import tomllib
import typing
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from skylimb.base.errors import ConfigError, UnknownNameError, did_you_mean, nearest
from skylimb.base.keys.checks import RefusedError, check_values
from skylimb.base.keys.configuration import is_configuration
from skylimb.base.keys.fields import fields_of, members_of, section_of
from skylimb.base.keys.key import Key, shown
from skylimb.base.keys.listing import keys_of
from skylimb.base.sources import Source, read_source

T = TypeVar("T")

_SCALARS = {float, int, bool, str, type(None)}
_DEEPEST = 32
"""Tables and lists inside of each other at most, and parts of a dotted key; no configuration has ten."""
_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{_DEEPEST}}}")
"""A dotted key of too many parts: `tomllib` takes time with the square of their number."""


def read_toml(path: str | Path) -> dict[str, Any]:
    """The table in a TOML file; a `ConfigError` where it is missing, unreadable or not valid TOML."""
    return parse_toml(read_source(path), path)


def parse_toml(source: Source, path: str | Path = "") -> dict[str, Any]:
    """The table in a TOML file that was read; `path` is what it is called in messages."""
    path = path or source.path
    try:
        return toml_tables(source.content.decode("utf-8").replace("\r\n", "\n"))
    except UnicodeDecodeError as error:
        raise ConfigError(f"cannot read '{path}': it is not UTF-8 text") from error
    except ValueError as error:
        raise ConfigError(f"'{path}' is not valid TOML: {error}") from error


def toml_tables(text: str) -> dict[str, Any]:
    """The tables of a TOML text that nobody has looked at.

    Raises:
        ValueError: it is no TOML, nested deeper than any configuration, or has a number too long.
    """
    too_deep = f"more than {_DEEPEST} tables, lists or parts of a key inside of each other"
    if _LONG_KEY.search(text):
        raise ValueError(too_deep)
    try:
        tables = tomllib.loads(text)
    except RecursionError:
        raise ValueError(too_deep) from None
    level: list[Any] = [tables]
    for _ in range(_DEEPEST):
        inside = (node.values() if isinstance(node, dict) else node for node in level)
        level = [entry for entries in inside for entry in entries if isinstance(entry, dict | list)]
        if not level:
            return tables
    raise ValueError(too_deep)


def write_toml(config: Any) -> str:
    """The TOML text of a dataclass or mapping, which `from_mapping` reads back to an equal one."""
    import tomli_w  # only to write: who flies reads

    return tomli_w.dumps(to_mapping(config))


def toml_value(value: Any) -> str:
    """A value as TOML writes it on one line, which `parse_assignment` reads back to an equal one."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{json.dumps(key)} = {toml_value(entry)}' for key, entry in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(toml_value, value))}]"
    return repr(value) if isinstance(value, float) else json.dumps(value, ensure_ascii=False)


def from_mapping(cls: type[T], mapping: Mapping[str, Any], where: str, at: str = "") -> T:
    """Build the dataclass `cls` from nested tables; keys left out take their defaults.

    Args:
        cls: a dataclass whose fields are scalars, Literals, tuples, dataclasses or dict[str, dataclass],
            any of them optional.
        mapping: tables as TOML gives them; NumPy scalars, arrays and tuples are welcome too.
        where: the source for error messages, such as a file name.
        at: dotted key of `mapping` itself, where it is a part of a larger table.

    Raises:
        ConfigError: a value of the wrong type or out of range, or a required key that is missing.
        UnknownNameError: a key that `cls` does not have.
    """
    try:
        return _build(cls, to_mapping(mapping, keep_none=True), tuple(filter(None, at.split("."))))
    except ConfigError as error:
        kind = ConfigError if isinstance(error, RefusedError) else type(error)
        raise kind(f"{where}: {error}") from None


def to_mapping(config: Any, *, keep_none: bool = False) -> Any:
    """Nested tables, lists and Python scalars of a configuration, as TOML can hold them; None is left out."""
    if type(config) in _SCALARS:  # nearly all that there is, and the questions below take time
        return config
    if dataclasses.is_dataclass(config) and not isinstance(config, type):
        config = {field.name: getattr(config, field.name) for field in dataclasses.fields(config)}
    if isinstance(config, Mapping):
        return {
            str(key): to_mapping(value, keep_none=keep_none)
            for key, value in config.items()
            if keep_none or value is not None
        }
    if isinstance(config, (list, tuple)):
        return [to_mapping(value, keep_none=keep_none) for value in config]
    if isinstance(config, (np.ndarray, np.generic)):
        return config.tolist()
    if isinstance(config, Path):
        return str(config)
    return config


def flatten(config: Any) -> dict[str, Any]:
    """Every value of a configuration under its dotted key, for example `{"trajectory.radius": 0.3, ...}`."""
    return {".".join(path): value for path, value in _leaves(to_mapping(config), ())}


def with_overrides(config: T, overrides: Mapping[str, Any], where: str = "override", at: str = "") -> T:
    """A copy of `config` with the values under some dotted keys replaced, checked like a file's.

    Args:
        config: a dataclass.
        overrides: dotted key to value; a table as value overrides only the keys it has, None empties an
            optional key.
        where: the source of the values, for error messages.
        at: dotted key of `config` itself, where it is a part of a larger table; for error messages.
    """
    tables = to_mapping(config)
    for key, value in overrides.items():
        for path, leaf in _leaves(to_mapping({key: value}, keep_none=True), ()):
            put(tables, ".".join(path), leaf)
    return from_mapping(type(config), tables, where, at)


def parse_assignment(text: str, example: str = "trajectory.radius=0.25") -> tuple[str, Any]:
    """Split `a.b=0.3` into the dotted key and its TOML value; a bare word is a string.

    A number may be any that `float` takes, as elsewhere on the command line: TOML has no `-2.` and no `.5`.

    Args:
        text: the assignment.
        example: of one, for messages.

    Raises:
        ConfigError: when it is none.
    """
    key, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not key or not value or not all(key.split(".")):
        raise ConfigError(f"cannot read the setting '{text}': expected KEY=VALUE, for example {example}")
    if key.count(".") >= _DEEPEST:
        raise ConfigError(f"the key '{key[:60]}...' has {key.count('.') + 1} parts, more than {_DEEPEST}")
    try:
        table = toml_tables(f"value = {value}")
    except ValueError:
        if value[0] in "[{\"'" or "\n" in value:
            raise ConfigError(f"cannot read the value of '{text}': '{value}' is not a TOML value") from None
        try:
            return key, float(value)
        except ValueError:
            return key, value
    if len(table) != 1:
        raise ConfigError(f"cannot read the setting '{text}': one KEY=VALUE at a time")
    return key, table["value"]


def _build(cls: type[T], table: Any, path: tuple[str, ...]) -> T:
    if not isinstance(table, dict):
        raise ConfigError(f"{'.'.join(path) or 'this'} = {shown(table)} should be a table of keys")
    known = fields_of(cls)
    for key in table:
        if key not in known:
            raise _unknown_key((*path, key), cls)
    for key, value in table.items():
        _refuse_unit(known[key][1], value, (*path, key))
    values = {key: _convert(known[key][0], value, (*path, key)) for key, value in table.items()}
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        if field.init and required and field.name not in values:
            raise ConfigError(f"the key '{'.'.join((*path, field.name))}' is missing")
    try:
        made = cls(**values)
        if not is_configuration(cls):
            check_values(made)
        return made
    except RefusedError as error:
        raise error.under(".".join(path)) from None


def _refuse_unit(key: Key | None, value: Any, path: tuple[str, ...]) -> None:
    """Refuse a number with a unit, as in "20deg", with the number that it would be."""
    reading = key.reading_of(value) if key is not None and isinstance(value, str) else ""
    if reading:
        number = reading.partition(" = ")[2].partition(" ")[0]
        raise ConfigError(
            f"{'.'.join(path)} = {shown(value)} is a text, it takes a number: {reading}, so write {number}"
        )


def _convert(kind: Any, value: Any, path: tuple[str, ...]) -> Any:
    """A TOML value in the form of a type: tables as dataclasses, lists as tuples, whole numbers as floats.

    Whether it is of that type is left to the check of the dataclass that holds it.
    """
    members = members_of(kind)
    if value is None and type(None) in members:
        return None
    section = section_of(kind)
    if section is not None:
        return _build(section, value, path)
    if isinstance(value, int) and not isinstance(value, bool) and float in members and int not in members:
        with suppress(OverflowError):  # the check refuses a number that is too large
            return float(value)
    for member in members:
        origin, arguments = typing.get_origin(member), typing.get_args(member)
        if origin is dict and isinstance(value, dict):
            return {key: _convert(arguments[1], entry, (*path, key)) for key, entry in value.items()}
        if origin is tuple and isinstance(value, list):
            kinds = arguments[:1] * len(value) if arguments[1:] == (...,) else arguments
            if len(kinds) == len(value):
                pairs = enumerate(zip(kinds, value, strict=True))
                return tuple(_convert(of, entry, (*path, str(place))) for place, (of, entry) in pairs)
    return value


def _unknown_key(path: tuple[str, ...], cls: type) -> UnknownNameError:
    """Names the key of this name in a table below, else the nearest beside it, else the nearest below."""
    known, below = sorted(fields_of(cls)), list(keys_of(cls))
    same_name = [key for key in below if key.rpartition(".")[2] == path[-1]]
    guess = same_name[0] if same_name else nearest(path[-1], known) or nearest(path[-1], below)
    hint = did_you_mean(guess and ".".join((*path[:-1], guess)))
    return UnknownNameError(f"unknown key '{'.'.join(path)}'{hint} (known here: {', '.join(known)})")


def _leaves(table: Any, path: tuple[str, ...]) -> list[tuple[tuple[str, ...], Any]]:
    if not isinstance(table, dict):
        return [(path, table)]
    return [leaf for key, value in table.items() for leaf in _leaves(value, (*path, key))]


def value_of(tables: Any, key: str) -> Any:
    """The value under a dotted key of nested tables and lists; None where there is none."""
    found: Any = tables
    for name in key.split("."):
        if isinstance(found, list | tuple) and name.isdecimal() and int(name) < len(found):
            found = found[int(name)]
        else:
            found = found.get(name) if isinstance(found, Mapping) else None
    return found


def put(tables: dict[str, Any], key: str, value: Any) -> None:
    """Write one value into nested tables; whether the dotted key is known is checked when they are read.

    A number in the key is the place of an entry of a list, from 0.
    """
    path = key.split(".")
    here: Any = tables
    for depth, name in enumerate(path):
        parent, last = ".".join(path[:depth]), depth + 1 == len(path)
        place: Any = name
        if isinstance(here, list):
            place = _entry(here, name, key, parent)
        elif not isinstance(here, dict):
            raise ConfigError(f"override: '{parent}' is a single value, it has no key '{name}'")
        if last:
            here[place] = value
        else:
            here = here.setdefault(name, {}) if isinstance(here, dict) else here[place]


def _entry(values: list[Any], name: str, key: str, here: str) -> int:
    """The place of a list's entry that a key names."""
    if not name.isdecimal() or int(name) >= len(values):
        known = (
            f"0 .. {len(values) - 1}"
            if values
            else "none, it is empty: set the whole list, or vary it with size = N"
        )
        raise ConfigError(f"key '{key}': '{here}' is a list without an entry '{name}' (entries: {known})")
    return int(name)
