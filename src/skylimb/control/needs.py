"""What a controller needs of the loop that flies it, declared beside its code."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Needs:
    """What a law or a controller declares.

    Attributes:
        paced: it sets the pace of the mission's clock, by a signal "pace" between 0 and 1.
        preview: times ahead on the mission's clock at which it wants the reference too, s, rising; they come
            as `reference.ahead` in this order.
        vectoring: which vectoring angles the nominal posture has, "torque" or "contact".
    """

    paced: bool = False
    preview: tuple[float, ...] = ()
    vectoring: str = "torque"


def needs_of(controller: Any) -> Needs:
    """The needs that a controller declares as `needs`; none for one that declares nothing."""
    return getattr(controller, "needs", Needs())


def merged(parts: Iterable[Needs]) -> Needs:
    """What all of them together need."""
    parts = tuple(parts)
    preview = sorted({time for part in parts for time in part.preview})
    vectoring = next((part.vectoring for part in parts if part.vectoring != "torque"), "torque")
    return Needs(any(part.paced for part in parts), tuple(preview), vectoring)
