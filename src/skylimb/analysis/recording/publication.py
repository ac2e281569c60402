"""Published numbers that stand beside those of a run, in tables, box plots and reports.

What was published, and beside which flights it may stand, is known above this package (`provided`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from skylimb.analysis.recording.provided import provided

if TYPE_CHECKING:
    from skylimb.analysis.recording.run import Run


@dataclass(frozen=True)
class Claim:
    """A published statement with its numbers and those of some runs.

    Attributes:
        text: the statement.
        paper: what is published for it.
        ours: the same from the runs.
        holds: whether it is true of the runs.
    """

    text: str
    paper: str
    ours: str
    holds: bool


@dataclass(frozen=True)
class Publication:
    """What is published.

    Attributes:
        source: where it stands.
        number: to stand beside a run's own score of that name; None where none is printed, and beside a
            flight of anything else than was flown there.
        claims: those that some runs by name allow to check.
        otherwise: a line for each of some runs that goes by the publication's names and flew something else.
    """

    source: str
    number: Callable[[Run, str], float | None]
    claims: Callable[[Mapping[str, Run]], list[Claim]]
    otherwise: Callable[[Mapping[str, Run]], list[str]]


def publication() -> Publication:
    """What is published."""
    return provided("publication")
