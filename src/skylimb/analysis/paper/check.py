"""What the paper claims of its four controllers, held against a set of runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from skylimb.analysis.paper.claims import CLAIMS, PaperClaim
from skylimb.analysis.paper.configuration import is_the_papers
from skylimb.analysis.paper.numbers import PUBLISHED
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.registry import measured

_CHECKED = {
    "impedance resists friction": "m",
    "hybrid below impedance in x": "m",
    "admittance below PID in x": "m",
    "hybrid pushed least": "N",
    "admittance narrows the force": "N",
}
"""Claims that one comparison can be held against, in the paper's order, and the unit of their numbers."""


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


def check_claims(runs: Mapping[str, Run]) -> list[Claim]:
    """Check the claims that these runs allow to check.

    A claim is about flights of the paper's configuration by the controllers that it names. It needs one of
    each that finished.

    Args:
        runs: by name; of two runs with the same controller the first counts.

    Returns:
        The claims that could be judged, in the paper's order.
    """
    flown: dict[str, Run] = {}
    for run in runs.values():
        if not run.failed and is_the_papers(run):
            flown.setdefault(run.controller, run)
    known = [CLAIMS[name] for name in _CHECKED if set(CLAIMS[name].controllers) <= set(flown)]
    return [_checked(claim, flown, _CHECKED[claim.name]) for claim in known]


def _checked(claim: PaperClaim, flown: Mapping[str, Run], unit: str) -> Claim:
    (key,) = claim.keys
    ours = {name: _number(flown[name], key) for name in claim.controllers}
    printed = {name: getattr(PUBLISHED[name], key, math.nan) for name in claim.controllers}
    return Claim(
        claim.text,
        _words(printed, unit) if key in vars(PUBLISHED["pid"]) else "shown in a box plot, no number",
        _words(ours, unit),
        claim.holds({name: {key: value} for name, value in ours.items()}),
    )


def _number(run: Run, key: str) -> float:
    found = run.metrics[key] if key in run.metrics else measured(run, ["paper"]).get(key)
    return math.nan if found is None else float(found)


def _words(numbers: Mapping[str, float], unit: str) -> str:
    """The numbers of some controllers; of two, their ratio as well."""
    text = ", ".join(f"{name} {value:.3f}" for name, value in numbers.items()) + f" {unit}"
    if len(numbers) == 2 and all(numbers.values()):
        first, second = numbers.values()
        text += f" (ratio {min(first, second) / max(first, second):.2f})"
    return text.replace("-", "\N{MINUS SIGN}")
