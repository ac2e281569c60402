"""The page of the catalogue: a summary, then every fault with its physics and its numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from skylimb.analysis.scores.registry import SCORES
from skylimb.studies.faults.catalogue import Catalogue, Fault

_HEAD = """# Faults

What each fault does to a flight in contact, without the supervisor and with it. Every controller flies each
fault {draws} times: on the board leaning to either side, with another onset and noise in each draw.
`skylimb faults --draws {draws}` leaves such a page and docs/faults.json.{mixed} Numbers are median / what
99 % keep, in brackets what both are held to; a dash is a number that lost flights do not
have. "ok" means: all is kept.

A flight survives that goes on for 5 s after the onset, or to its mission's end: not tilted beyond 1 rad, on
the floor, or 2 m astray. So does one that its supervisor lands, slower than 0.6 m/s and upright. What a fault
does is counted from its onset to 1.5 s after its end; of one that is there from take-off on, all along. Where
there is a bound on the tip, what the same draw moves by itself, flown without the fault, does not count. A
flight that is broken off is held to the last reference that it had: its mission went on without it. A fault
that unprotected flights of every controller survive within its bounds is no test, and is marked so.
"""

_MIXED = " Rows of more or fewer\nflights say so."


@dataclass(frozen=True)
class Row:
    """What a fault did to one controller's flights.

    Attributes:
        fault: its name.
        controller: that met it.
        supervised: whether the supervisor was on.
        flights: that were flown.
        survived: of them.
        within: of them, that also kept what 99 % are held to in every number, whether it was noticed or not.
        numbers: of each bound: median and what 99 % keep; None where that many are lost.
        worst: folder of the worst flight's log, in the folder of all; empty where others were worse.
        cause: what ended the first flight that did not survive.
    """

    fault: str
    controller: str
    supervised: bool
    flights: int
    survived: int
    within: int
    numbers: dict[str, tuple[float | None, float | None]]
    worst: str
    cause: str

    @property
    def flown_by(self) -> str:
        """Controller and side, as tables call them."""
        return f"{self.controller}, {'supervised' if self.supervised else 'unprotected'}"

    @property
    def shares(self) -> tuple[str, str]:
        """How many flights survived, and how many within the bounds."""
        return f"{self.survived} of {self.flights}", f"{self.within} of {self.flights}"

    def reached(self, fault: Fault) -> bool:
        """Whether 99 % survive, and median and 99 % of every number are within their bounds.

        Without a supervisor nobody reaches what is only to be noticed.
        """
        held = fault.held(self.supervised)
        if not held or (fault.survived and self.survived < 0.99 * self.flights):
            return False
        return all(
            value is not None and value <= bound
            for key, bounds in held.items()
            for value, bound in zip(self.numbers.get(key, (None, None)), bounds, strict=True)
        )


def faults_page(catalogue: Catalogue, rows: Sequence[Row]) -> str:
    """The page as Markdown.

    Args:
        catalogue: what was flown; what of it was not is left out.
        rows: what came of it.
    """
    flown = {row.fault for row in rows}
    faults = [fault for fault in catalogue.faults if fault.name in flown]
    draws = Counter(row.flights for row in rows).most_common(1)[0][0] if rows else 0
    mixed = _MIXED if any(row.flights != draws for row in rows) else ""
    lines = [_HEAD.format(draws=draws, mixed=mixed), "## All of them", ""]
    columns = list(dict.fromkeys(row.flown_by for row in rows))
    lines += _table("fault: flights within the bounds", [*columns, ""], _summary(faults, rows, columns))
    lost = dict.fromkeys(row.fault for row in rows if row.supervised and row.survived < row.flights)
    lines += ["", f"Not outlived by every supervised flight: {', '.join(lost) or 'none'}."]
    for fault in faults:
        own = [row for row in rows if row.fault == fault.name]
        heads = [
            f"{key} {SCORES[f'fault_{key}'].unit} ({_both(bounds)})".replace("  ", " ")
            for key, bounds in fault.bounds.items()
        ]
        lines += ["", f"## {fault.name[0].upper()}{fault.name[1:]}", "", fault.physics.strip(), ""]
        lines += _table("", ["survived", "within", *heads, "worst flight"], _numbers(fault, own))
        first = next((row for row in own if row.cause), None)
        lines += ["", f"The first that did not survive, {first.flown_by}: {first.cause}."] if first else []
    return "\n".join(lines) + "\n"


def _summary(
    faults: Sequence[Fault], rows: Sequence[Row], columns: Sequence[str]
) -> Iterator[tuple[str, ...]]:
    """A line a fault: how many flights of each column are within its bounds; empty where none flew."""
    for fault in faults:
        own = [row for row in rows if row.fault == fault.name]
        shares = {row.flown_by: row.shares[1] + (", ok" if row.reached(fault) else "") for row in own}
        cells = [shares.get(column, "") for column in columns]
        harmless = all(row.reached(fault) for row in own if not row.supervised)
        yield fault.name, *cells, "no test" if harmless else ""


def _numbers(fault: Fault, rows: Sequence[Row]) -> Iterator[tuple[str, ...]]:
    """A line for each controller and side."""
    for row in rows:
        cells = [_both(row.numbers.get(key, (None, None))) for key in fault.bounds]
        yield row.flown_by, *row.shares, *cells, f"`{row.worst}`" if row.worst else ""


def _table(first: str, columns: Sequence[str], lines: Iterator[tuple[str, ...]]) -> list[str]:
    return [f"| {' | '.join(line)} |" for line in ((first, *columns), ["---"] * (1 + len(columns)), *lines)]


def _both(numbers: tuple[float | None, float | None]) -> str:
    return " / ".join("-" if value is None else f"{value:.3g}" for value in numbers)
