"""The decorator that makes a class of keys a configuration."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, TypeVar, dataclass_transform

from skylimb.base.keys.checks import RefusedError, check_keys
from skylimb.base.keys.fields import fields_of, has_numbers, holds_configurations
from skylimb.base.keys.key import shown

T = TypeVar("T")


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def configuration(cls: type[T]) -> type[T]:
    """Make `cls` a frozen dataclass that checks its keys, then calls its own `check`, when it is built.

    Raises:
        TypeError: a field has no `Key` or a number no range; both are mistakes in the class.
    """
    if "__post_init__" in vars(cls):
        raise TypeError(f"{cls.__name__}: write `check` in place of `__post_init__`")
    cls.__post_init__ = check_keys  # type: ignore[attr-defined]
    cls = dataclass(frozen=True)(cls)
    for name, (kind, key) in fields_of(cls).items():
        if key is None:
            if not holds_configurations(kind):
                raise TypeError(f"{cls.__name__}.{name} has no Key")
        elif not key.meaning:
            raise TypeError(f"{cls.__name__}.{name}: its Key has no meaning")
        elif has_numbers(kind) and not key.bounded:
            raise TypeError(f"{cls.__name__}.{name}: its Key needs a range; an end may be infinite")
    return cls


def is_configuration(cls: Any) -> bool:
    """Whether a class was made by `configuration`."""
    return isinstance(cls, type) and getattr(cls, "__post_init__", None) is check_keys


def refused(config: Any, key: str, problem: str) -> RefusedError:
    """The error for a value that does not go with others; for a configuration's own `check`.

    Args:
        config: the configuration.
        key: the field to change.
        problem: what is wrong, as a sentence after "key = value unit".
    """
    note = fields_of(type(config))[key][1]
    unit = f" {note.unit}" if note is not None and note.unit else ""
    return RefusedError(type(config).__name__, key, f"= {shown(getattr(config, key))}{unit} {problem}")
