"""A doubt: what is odd about a description, with its value and the remedy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

_MOST_NAMED = 12
"""Things of one finding that are named beside the first; of more only the number is said."""


@dataclass(frozen=True)
class Doubt:
    """One finding.

    Attributes:
        what: the thing, by name.
        value: what is odd, with the number it has.
        remedy: what to do.
        fatal: whether the robot cannot fly with it.
    """

    what: str
    value: str
    remedy: str
    fatal: bool = False

    def __str__(self) -> str:
        end = "" if self.value.endswith("?") else "."
        return f"{self.what}: {self.value}{end} Remedy: {self.remedy}."


def without_name(error: Exception) -> str:
    """What a check said, without the words up to the quoted name that it begins with."""
    text = str(error)
    return text.partition("' ")[2] or text


def together(doubts: Iterable[Doubt]) -> tuple[Doubt, ...]:
    """The doubts in their order, those that say the same of several things as one."""
    things: dict[tuple[str, str, bool], list[Doubt]] = {}
    for doubt in doubts:
        same = things.setdefault((doubt.value, doubt.remedy, doubt.fatal), [])
        if doubt not in same:
            same.append(doubt)
    return tuple(_as_one(same) for same in things.values())


def _as_one(same: list[Doubt]) -> Doubt:
    if len(same) == 1:
        return same[0]
    others = [doubt.what.rpartition(" ")[2] for doubt in same[1:]]
    more = ", ".join(others) if len(others) <= _MOST_NAMED else f"{len(others)} more"
    return replace(same[0], what=f"{same[0].what} and {more}, each")
