"""The ways that flights went: each act can be undone, and each way can be come back to.

A place on a way is what repeats the flights up to there: nothing of what was flown is kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from skylimb.apps.studio.flight_setup import FlightSetup
from skylimb.base.errors import ConfigError
from skylimb.flight.experiments.experiment import Experiment

MOST = 40
"""Ways that are kept, and acts that can be undone."""

TOGETHER = 1.0
"""Acts of one kind that follow each other within this time are one, s."""


@dataclass(frozen=True)
class Place:
    """What repeats flights up to a moment.

    Attributes:
        begun: what they took off with.
        setup: of the next take-off.
        experiments: of each flight, with all changes up to then.
        ticks: flown up to then.
        time: since take-off, s.
        branch: the way on which it is; -1 where that isn't known yet.
    """

    begun: FlightSetup
    setup: FlightSetup
    experiments: tuple[Experiment, ...]
    ticks: int
    time: float
    branch: int = -1


@dataclass(frozen=True)
class Branch:
    """One way from where it left another to where it was left itself.

    Attributes:
        number: counted from the first take-off on.
        parent: the way that it leaves; itself for a take-off.
        since: time at which it leaves it, s.
        words: what began it.
        end: where it was left; None while it is flown.
    """

    number: int
    parent: int
    since: float
    words: str
    end: Place | None = None


@dataclass(frozen=True)
class Act:
    """Something that people did, and the moment before it."""

    words: str
    kind: str
    before: Place
    time: float


@dataclass(frozen=True)
class Branches:
    """All ways, the one that is flown, and what can be undone and done again.

    Attributes:
        ways: in the order in which they began.
        here: number of the one that is flown.
        done: acts, the last one can be undone.
        undone: acts that can be done again, each with the moment at which it was undone.
    """

    ways: tuple[Branch, ...] = (Branch(0, 0, 0.0, "take-off"),)
    here: int = 0
    done: tuple[Act, ...] = ()
    undone: tuple[Act, ...] = ()

    def acted(self, now: Place, words: str, kind: str) -> Branches:
        """People do something now; it goes on with what they did just before, where that is of one kind."""
        last = self.done[-1] if self.done else None
        joins = last and kind and last.kind == kind and 0.0 <= now.time - last.time <= TOGETHER
        before = last.before if last and joins else self._here(now)
        done = (*(self.done[:-1] if joins else self.done), Act(words, kind, before, now.time))
        return replace(self, done=done[-MOST:], undone=())

    def began(self, now: Place, words: str) -> Branches:
        """The flights take off anew."""
        return self._with(self._ended(now), None, 0.0, words)

    def came_to(self, now: Place, branch: int, time: float) -> Branches:
        """The flights are brought to a time of a way: another one begins there, but where it was left."""
        if branch == self.here and time >= now.time:
            return self
        ways = self._ended(now)
        end = next((way.end for way in ways if way.number == branch), None)
        if end is not None and time >= end.time:
            return replace(self, ways=ways, here=branch)
        return self._with(ways, branch, time, f"from {time:.1f} s on")

    def undo(self, now: Place) -> tuple[Branches, Place]:
        """The last act is undone; with the moment before it.

        Raises:
            ConfigError: when there is none.
        """
        if not self.done:
            raise ConfigError("there is nothing to undo")
        last = self.done[-1]
        again = replace(last, before=self._here(now))
        return replace(self, done=self.done[:-1], undone=(*self.undone, again)), last.before

    def redo(self, now: Place) -> tuple[Branches, Place]:
        """What was undone last is done again; with the moment at which it was undone.

        Raises:
            ConfigError: when there is none.
        """
        if not self.undone:
            raise ConfigError("there is nothing to do again")
        last = self.undone[-1]
        again = replace(last, before=self._here(now))
        return replace(self, done=(*self.done, again), undone=self.undone[:-1]), last.before

    def end_of(self, number: int) -> Place:
        """Where a way was left.

        Raises:
            ConfigError: when there is no such way, or it is the one that is flown.
        """
        ends = {way.number: way.end for way in self.ways if way.end and way.number != self.here}
        if number not in ends:
            raise ConfigError(f"branch {number} is not there; those that can be come back to are {[*ends]}")
        return ends[number]

    def _here(self, now: Place) -> Place:
        return replace(now, branch=self.here)

    def _ended(self, now: Place) -> tuple[Branch, ...]:
        """The ways with the end of the one that is flown; without it, where nothing was flown on it."""
        ended = [replace(way, end=self._here(now)) if way.number == self.here else way for way in self.ways]
        parents = {way.parent for way in ended if way.parent != way.number}
        empty = [way for way in ended if way.number == self.here and way.since >= now.time - 1e-9]
        return tuple(way for way in ended if way not in empty or way.number in parents)

    def _with(self, ways: tuple[Branch, ...], parent: int | None, since: float, words: str) -> Branches:
        number = max(way.number for way in self.ways) + 1
        way = Branch(number, number if parent is None else parent, since, words)
        return replace(self, ways=(*ways, way)[-MOST:], here=number)

    def sent(self) -> dict[str, Any]:
        """What a page is sent, ready for JSON; `until` is None for the way that is flown."""
        ways = [
            {
                "number": way.number,
                "parent": way.parent,
                "since": way.since,
                "until": way.end.time if way.end and way.number != self.here else None,
                "words": way.words,
            }
            for way in self.ways
        ]
        undo, redo = (acts[-1].words if acts else None for acts in (self.done, self.undone))
        return {"branches": ways, "here": self.here, "undo": undo, "redo": redo}
