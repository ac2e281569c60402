"""What was meant by a key that an experiment does not have: a key is often named by its end alone."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

from skylimb.base.errors import UnknownNameError, nearest, unknown_name
from skylimb.control.laws.slots import SLOTS, shipped_gains

_TABLE, _LONGEST = 0.8, 100
"""How alike a table's name is that was meant, and how many letters of a key are looked at."""


def unknown_key(
    where: str, key: str, value: Any, known: Iterable[str], whole: Iterable[str]
) -> UnknownNameError:
    """The error for a key that no experiment has; it names the whole keys that end in it.

    Args:
        where: it stands.
        key: as it was written.
        value: of it.
        known: keys that would be right there.
        whole: dotted keys of all experiments.
    """
    while isinstance(value, dict) and len(value) == 1:
        inside, value = next(iter(value.items()))
        key = f"{key}.{inside}"
    known = list(known)
    meant = sorted(_meant(key, list(whole), known), key=lambda name: (name.count("."), name))
    if not meant:
        return unknown_name(f"key of {where}", key, known)
    return UnknownNameError(
        f"unknown key '{key}' of {where}; did you mean {' or '.join(repr(name) for name in meant[:3])}? "
        f"(skylimb keys {key.rpartition('.')[2]} finds more)"
    )


def _meant(key: str, whole: list[str], known: list[str]) -> list[str]:
    """Keys of experiments and controllers that end in `key`; those that are spelled alike where none do.

    None where a table is more alike than they are: one of those keys that would be right there.
    """
    gains = [f"controller.{name}" for name in (*shipped_gains(), *(f"{slot}.law" for slot in SLOTS))]
    everything = dict.fromkeys([*whole, *gains])
    found = [name for name in everything if name.endswith(f".{key}")]
    if found:
        return found
    last = key.rpartition(".")[2]
    same = [name for name in everything if name.rpartition(".")[2] == last]
    if same and "." in key:  # its table was meant otherwise
        return [nearest(key, same) or same[0]]
    ends = {name.rpartition(".")[2] for name in whole}
    if difflib.get_close_matches(last[:_LONGEST], set(known) - ends, n=1, cutoff=_TABLE):
        return []
    guess = nearest(last, ends)
    return [name for name in whole if guess and name.rpartition(".")[2] == guess]
