"""The class of the settings in a user's own file: a dataclass, of types that a TOML file can say."""

from __future__ import annotations

import dataclasses
import types
import typing
from typing import Any

from skylimb.base.errors import UserCodeError
from skylimb.base.keys.fields import fields_of, section_of
from skylimb.base.user_code import described

_SAID = (float, int, bool, str, list, tuple, dict, type(None))
_NOT_SAID = (
    "is of type {}, which no TOML file can say; write float, int, bool, str or, for an array, "
    "tuple[float, float, float]"
)


def settings_class(found: Any, name: str, what: str) -> type:
    """What a user's file has as the class of its settings.

    Args:
        found: what stands there.
        name: of it in the file.
        what: the file's part in messages, for example "translation law 'spring.py'".

    Raises:
        UserCodeError: when it is no dataclass, or a type of a field is none that a TOML file can say: the run
            could not be flown again from its config.toml.
    """
    if not isinstance(found, type) or not dataclasses.is_dataclass(found):
        known = f"a class {found.__name__} without it" if isinstance(found, type) else type(found).__name__
        raise UserCodeError(
            f"{what}: {name} should be a class with @configuration or @dataclass(frozen=True); it is {known}"
        )
    try:
        fields = fields_of(found)
    except Exception as error:  # whatever an annotation does when it is evaluated
        raise UserCodeError(f"{what}: a type in {name} cannot be read: {described(error)}") from error
    for key, (kind, _) in fields.items():
        if section := section_of(kind):
            settings_class(section, f"{name}.{key}", what)
        elif odd := _odd(kind):
            raise UserCodeError(f"{what}: {name}.{key} {odd}")
    return found


def _odd(kind: Any) -> str:
    """Why a TOML file cannot say a value of this type; empty where it can."""
    origin, arguments = typing.get_origin(kind) or kind, typing.get_args(kind)
    if origin is tuple and not arguments:
        return "is a tuple of what? Write tuple[float, float, float], or tuple[float, ...] for any number"
    if origin is dict and len(arguments) != 2:
        return "is a dict of what? Write dict[str, float]"
    if origin in (tuple, dict, typing.Union, types.UnionType):
        return next(filter(None, map(_odd, arguments)), "")
    if kind is Any or not isinstance(origin, type) or dataclasses.is_dataclass(origin):
        return ""
    # Whatever a plain value is an instance of will do, such as Sequence.
    return "" if any(issubclass(said, origin) for said in _SAID) else _NOT_SAID.format(origin.__name__)
