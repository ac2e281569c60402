"""Every key of every kind under its whole name, and a search through them."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

from skylimb.apps.catalogue.entries import entries, tables_of_entry
from skylimb.base.keys import ANY_NUMBER, KeyInfo, Table, tables_of
from skylimb.flight.experiments.experiment import Settings

_MOST = 30
_ALIKE = 0.6
"""How alike two words are that a search takes for the same: 1 is equal."""


@dataclass(frozen=True)
class FoundKey:
    """A key.

    Attributes:
        key: whole, as `--set` takes it; as it stands in its file for a campaign and a robot.
        info: unit, range, meaning and default.
        of: what has it: "experiment", "surface.cylinder", "event.push", "translation.pid", "flight", ...
    """

    key: str
    info: KeyInfo
    of: tuple[str, ...]


@cache
def all_keys() -> tuple[FoundKey, ...]:
    """Every key, those of an experiment first; a key that several kinds share stands once."""
    found: dict[tuple[str, str], FoundKey] = {}
    for of, prefix, table in _tables():
        for name, _, info in table.rows:
            key = ".".join((*filter(None, (prefix,)), *table.path, name))
            known = found.get((key, info.meaning))
            found[key, info.meaning] = (
                replace(known, of=(*known.of, of)) if known else FoundKey(key, info, (of,))
            )
    return tuple(found.values())


def _tables() -> Iterator[tuple[str, str, Table]]:
    """What has it, what stands before its keys, and a table."""
    for table in tables_of(Settings):
        yield "experiment", "", table
    for entry in entries():
        if entry.kind in ("surface", "event", "law", "file"):
            for table in tables_of_entry(entry):
                yield entry.name, "controller" * (entry.kind == "law"), table


def search(word: str) -> list[FoundKey]:
    """Keys that a word may mean: first those of that name, then those with it in name, meaning or unit.

    Of each kind a key of a list, whose entries have numbers, comes last.

    Where there are none, those with a word that is spelled alike.
    """
    word = word.lower().strip()
    keys = sorted(all_keys(), key=lambda key: ANY_NUMBER in key.key)
    last = [key for key in keys if word in (key.key.lower(), key.key.lower().rpartition(".")[2])]
    inside = [key for key in keys if word in key.key.lower()]
    told = [key for key in keys if word in key.info.meaning.lower()]
    found = list(dict.fromkeys([*last, *inside, *told]))
    return found or _alike(word)[:_MOST]


def _alike(word: str) -> list[FoundKey]:
    def likeness(key: FoundKey) -> float:
        words = {*key.key.lower().split("."), *key.key.lower().replace("_", ".").split(".")}
        return max(difflib.SequenceMatcher(None, word, each).ratio() for each in words)

    rated = sorted(((likeness(key), key) for key in all_keys()), key=lambda pair: -pair[0])
    return [key for rate, key in rated if rate >= _ALIKE]
