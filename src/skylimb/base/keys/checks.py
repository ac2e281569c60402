"""Whether a value is what its field's type and `Key` allow, and the message where it is not."""

from __future__ import annotations

import functools
import typing
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from skylimb.base.errors import ConfigError, did_you_mean, nearest
from skylimb.base.keys.fields import fields_of, members_of
from skylimb.base.keys.key import Key, is_number, shown


class RefusedError(ConfigError):
    """A key whose value cannot be used, inside of a configuration that does not know where it stands.

    Attributes:
        owner: the configuration: the name of its class, or its dotted key where that is known.
        key: the key, relative to the configuration.
        problem: the rest of the message, from the value on.
    """

    def __init__(self, owner: str, key: str, problem: str) -> None:
        super().__init__(f"{owner}.{key} {problem}" if owner else f"{key} {problem}")
        self.owner, self.key, self.problem = owner, key, problem

    def __reduce__(self) -> tuple[Any, ...]:
        return RefusedError, (self.owner, self.key, self.problem)

    def under(self, owner: str) -> RefusedError:
        """The same, with the dotted key of the configuration in front."""
        return RefusedError(owner, self.key, self.problem)


def check_values(config: Any) -> None:
    """Raise a `RefusedError` for the first field of a dataclass whose value its type and key do not allow."""
    for name, (kind, key) in fields_of(type(config)).items():
        found = _find(kind, getattr(config, name), key or _WITHOUT_KEY)
        if found is not None:
            value, problem, places = found
            where = f" (entry {', '.join(places)})" if places else ""
            raise RefusedError(type(config).__name__, name, f"= {value}{where} {problem}")


def check_keys(self: Any) -> None:
    """Check all values of a configuration; then call its own `check` where there is one."""
    check_values(self)
    check = getattr(self, "check", None)
    if check is not None:
        check()


_WITHOUT_KEY = Key(finite=False)
"""For a field of a plain dataclass: any number."""

_Found = tuple[str, str, tuple[str, ...]]
"""The value in words, what is wrong with it, and where in a tuple or table it stands."""


def _find(kind: Any, value: Any, key: Key) -> _Found | None:
    """What is wrong with `value` as the type `kind` under `key`; None when nothing is."""
    if kind is float is type(value) and key.allows(value):  # nearly all that is asked
        return None
    if isinstance(value, (str, Mapping)) and not _is_unicode(value):
        return ascii(shown(value)), "is no Unicode text: it has half of a character", ()
    members = members_of(kind)
    if value is None and type(None) in members:
        return None
    found = [_find_one(member, value, key) for member in members if member is not type(None)]
    # Of a number or a list of them, the one that the value looks like has the better words.
    return None if None in found else max(found, key=lambda one: len(one[2]) if one else 0)


@functools.cache
def _parts_of(kind: Any) -> tuple[Any, tuple[Any, ...]]:
    """What a type is of, and its arguments."""
    return typing.get_origin(kind) or kind, typing.get_args(kind)


def _find_one(kind: Any, value: Any, key: Key) -> _Found | None:
    origin, arguments = _parts_of(kind)
    if origin is typing.Literal:
        problem = choice_problem(value, arguments)
        return None if problem is None else (shown(value), problem, ())
    if origin in (float, int):
        return _find_number(origin, value, key)
    if origin is tuple and isinstance(value, tuple | list):
        return _find_in_tuple(arguments, value, key)
    if origin is dict and isinstance(value, Mapping):
        return _first(((f"'{name}'", arguments[1], entry) for name, entry in value.items()), key)
    if kind is Any or not isinstance(origin, type) or isinstance(value, origin):
        return None
    return shown(value), _wrong_type(origin, value), ()


def _is_unicode(value: str | Mapping[Any, Any]) -> bool:
    """Whether a text, or a table's names, can be written: a shell's bytes that are no UTF-8 cannot."""
    try:
        "".join(map(str, value)).encode()
    except UnicodeEncodeError:
        return False
    return True


def _find_in_tuple(arguments: tuple[Any, ...], value: Sequence[Any], key: Key) -> _Found | None:
    kinds = [arguments[0]] * len(value) if arguments[1:] == (...,) else arguments
    if len(kinds) != len(value):
        return shown(value), f"has {len(value)} entries, it needs {len(kinds)}", ()
    entries = enumerate(zip(kinds, value, strict=True), start=1)
    return _first(((f"{place} of {len(value)}", *pair) for place, pair in entries), key)


def _first(entries: Iterable[tuple[str, Any, Any]], key: Key) -> _Found | None:
    for place, kind, entry in entries:
        found = _find(kind, entry, key)
        if found is not None:
            return found[0], found[1], (place, *found[2])
    return None


def _find_number(kind: type, value: Any, key: Key) -> _Found | None:
    if not is_number(value) or (kind is int and not isinstance(value, int | np.integer)):
        return shown(value), _wrong_type(kind, value), ()
    if key.allows(value):
        return None
    text = shown(value)
    if not isinstance(value, int | np.integer) and key.allows(float(text)):
        text = repr(float(value))  # the few digits of the short form would look allowed
    return (f"{text} {key.unit}" if key.unit else text), key.problem(value), ()


TYPES_IN_WORDS = {
    "float": "a number",
    "int": "a whole number",
    "bool": "true or false",
    "str": "text",
    "list": "a list",
    "tuple": "a list",
    "array": "a list",
    "dict": "a table",
    "object": "a table",
    "NoneType": "nothing",
    "null": "nothing",
}
"""Names of types in Python and in JSON, and what a TOML file's writer would call them."""


def _wrong_type(kind: type, value: Any) -> str:
    wanted, got = (TYPES_IN_WORDS.get(name, name) for name in (kind.__name__, type(value).__name__))
    return f"has the wrong type: expected {wanted}, got {got}"


def choice_problem(value: Any, choices: Sequence[Any]) -> str | None:
    """What is wrong with a value that must be one of `choices`, with the nearest right name; None if good."""
    if any(value == choice and type(value) is type(choice) for choice in choices):
        return None
    guess = nearest(value, [str(choice) for choice in choices]) if isinstance(value, str) else None
    return f"is not one of {', '.join(map(repr, choices))}{did_you_mean(guess)}"
