"""Stamps of another clock, message by message: which are believed, and when each measurement was made.

The least time from stamp to arrival is taken for that of a message without delay. It says how the two clocks
stand; a message that takes longer is as old as it is late. A stamp that does not follow the one before is
refused: a message that was overtaken, doubled or spoilt looks like that. When those after it are strange in
the same way, the clock itself was set, and after `RELOCK` of them that agree it is read anew. So arrivals
decide whether there is anything fresh, and stamps only how old it is.
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import NamedTuple

AHEAD = 0.02
"""Seconds that a stamp may lie ahead of the clock as it is known."""

RELOCK, LASTS, AGREE = 5, 0.03, 0.02
"""Strange messages in a row after which a clock is read anew; how long they last at least, s; by how much
their times from stamp to arrival may differ, s. A burst of old ones comes at once, and does not agree."""

DRIFT = 2e-4
"""How fast the least delay is forgotten, s/s: more than two clocks of quartz drift apart."""


class Fault(StrEnum):
    """What is wrong with a stamp."""

    NO_NUMBER = "stamp is no number"
    OUT_OF_ORDER = "stamp repeated or out of order"
    FUTURE = "stamp from the future"
    STEPPED = "clock of the stamps was set"


class Stamps(NamedTuple):
    """What is known of one stream of stamps.

    Attributes:
        offset: from a stamp to our clock, without delay, s; not finite before the first message.
        stamp: the last that was believed, s.
        at: when its message came, s on our clock.
        taken: when what it holds was measured, s on our clock.
        strange: messages in a row since then that agree with one another and not with it.
        last: stamp of the last of these.
        since: when the first of these came, s.
        least: shortest time from stamp to arrival among these, s.
        most: longest.
    """

    offset: float = math.inf
    stamp: float = -math.inf
    at: float = -math.inf
    taken: float = -math.inf
    strange: int = 0
    last: float = -math.inf
    since: float = 0.0
    least: float = 0.0
    most: float = 0.0


def judged(known: Stamps, stamp: float, at: float) -> tuple[Stamps, Fault | None]:
    """What is known after one more message.

    Args:
        known: before it.
        stamp: its own, s on the other clock.
        at: when it came, s on ours.

    Returns:
        That, with `taken` of this message where it is believed; and what is wrong. A message is not believed
        for any fault but `Fault.STEPPED`.
    """
    if not math.isfinite(stamp):
        return known, Fault.NO_NUMBER
    delay = at - stamp
    future = math.isfinite(known.offset) and delay < known.offset - AHEAD
    if stamp > known.stamp and not future:
        return _locked(known, min(known.offset + DRIFT * max(at - known.at, 0.0), delay), stamp, at), None
    fault = Fault.FUTURE if future else Fault.OUT_OF_ORDER
    if stamp in (known.stamp, known.last):  # said twice
        return known, fault
    known = _also_strange(known, stamp, at)
    if known.strange < RELOCK or at - known.since < LASTS:
        return known, fault
    return _locked(known, known.least, stamp, at), Fault.STEPPED


def believed(fault: Fault | None) -> bool:
    """Whether a message is used."""
    return fault in (None, Fault.STEPPED)


def _locked(known: Stamps, offset: float, stamp: float, at: float) -> Stamps:
    """After a message that is believed: it was not made before the one that came before it."""
    return Stamps(offset, stamp, at, max(known.taken, stamp + offset))


def _also_strange(known: Stamps, stamp: float, at: float) -> Stamps:
    """One more strange message: of the row before it where it agrees, else the first of another row."""
    delay = at - stamp
    least, most = min(known.least, delay), max(known.most, delay)
    if known.strange and stamp > known.last and most - least <= AGREE:
        return known._replace(strange=known.strange + 1, last=stamp, least=least, most=most)
    return known._replace(strange=1, last=stamp, since=at, least=delay, most=delay)
