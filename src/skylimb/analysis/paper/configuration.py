"""Whether a flight is one of the paper's: what its stored configuration has otherwise.

The paper's numbers and claims say something of one experiment and four controllers. Beside any other flight
they would say something false, whatever that flight's experiment is called.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from skylimb.analysis.recording import Run
from skylimb.analysis.recording.origin import tables_of_text
from skylimb.base.config import flatten

FILE = Path(__file__).with_name("configuration.toml")

CONTROLLERS = ("pid", "impedance", "admittance", "hybrid")
"""The paper's four."""

EXPERIMENT = "paper"
"""The experiment that is flown as in the paper, unless something is set otherwise."""

INDIFFERENT = (
    "name.",
    "description.",
    "seed.",
    "approach.believed_friction.",
    "approach.believed_lean.",
    "terminations.",
    "tolerances.",
    "controller.name.",
    "controller.description.",
    "recorded.",
)
"""Keys and tables that change nothing of a finished flight but its noise and its verdict."""

KINDS = ("kind", "law", "shape")
"""Keys that say which other keys their table has."""

NOTHING = "not set"
_MOST_SHOWN = 5
_TOLERANCE = 1e-6


class Difference(NamedTuple):
    """A key whose value is not the paper's.

    Attributes:
        key: dotted, as `--set` takes it.
        here: the flight's value; `NOTHING` where it has no such key.
        paper: the paper's value; `NOTHING` where it has no such key.
    """

    key: str
    here: Any
    paper: Any

    def __str__(self) -> str:
        return f"{self.key} = {_shown(self.here)} (paper: {_shown(self.paper)})"


def differences(config: Mapping[str, Any], controller: str) -> tuple[Difference, ...]:
    """What a configuration has otherwise than the paper's.

    Args:
        config: tables of an experiment with those of the controller that flew it below "controller", as in
            a run's config.toml.
        controller: which of the paper's `CONTROLLERS` it is compared with.

    Returns:
        Every key whose value differs, in the order of the paper's. Numbers that agree to one in a million
        are equal. A key that the paper's does not have and that is empty is no difference. Where a table is
        of another kind (`surface.kind`, `controller.shape.law`), the keys that come and go with the kind are
        not listed.
    """
    paper = _paper(controller)
    # An empty list or word, or a switch that is off, is as good as no key: nothing is changed.
    empty = [], ""
    here = {
        key: value
        for key, value in flatten(config).items()
        if key in paper or (value not in empty and value is not False)
    }
    other = (*paper, *(key for key in here if key not in paper))
    found = [
        Difference(key, here.get(key, NOTHING), paper.get(key, NOTHING))
        for key in other
        if not f"{key}.".startswith(INDIFFERENT)
        and (key not in here or key not in paper or not _same(here[key], paper[key]))
    ]
    changed_kinds = {d.key.rpartition(".")[0] for d in found if d.key.rpartition(".")[2] in KINDS}
    return tuple(
        d
        for d in found
        if NOTHING not in (d.here, d.paper)
        or d.key.rpartition(".")[2] in KINDS
        or not any(d.key.startswith(f"{table}.") for table in changed_kinds)
    )


def differences_of(run: Run) -> tuple[Difference, ...]:
    """What a run flew otherwise than the paper's flight under the controller of that name.

    A run without a configuration, or of a controller that is none of the paper's, differs in just that.
    """
    if run.controller not in CONTROLLERS:
        return (Difference("controller", run.controller, " or ".join(CONTROLLERS)),)
    return _differences_of_text(run.config, run.controller)


def is_the_papers(run: Run) -> bool:
    """Whether a run flew the paper's configuration, so that its numbers may stand beside the paper's."""
    return not differences_of(run)


def not_the_papers(runs: Mapping[str, Run]) -> list[str]:
    """A line for each run that goes by the paper's names and flew something else: what that is.

    Runs that differ in the same way share a line. Runs of other experiments or controllers, beside which
    nobody expects the paper's numbers, have none.
    """
    alike: dict[str, list[str]] = {}
    for name, run in runs.items():
        if run.controller in CONTROLLERS and run.log.attrs.get("experiment") == EXPERIMENT:
            found = differences_of(run)
            if found:
                alike.setdefault(in_words(found), []).append(name)
    return [f"{', '.join(names)}: {words}" for words, names in alike.items()]


def in_words(found: tuple[Difference, ...]) -> str:
    """Differences in one line; of many, the first and how many more."""
    shown = ", ".join(map(str, found[:_MOST_SHOWN]))
    more = len(found) - _MOST_SHOWN
    return f"{shown} and {more} more" if more > 0 else shown


@lru_cache(maxsize=64)
def _differences_of_text(config: str, controller: str) -> tuple[Difference, ...]:
    tables = tables_of_text(config)
    if "controller" not in tables:
        return (Difference("configuration", "not in the record", f"{EXPERIMENT} with {controller}"),)
    return differences(tables, controller)


@lru_cache(maxsize=len(CONTROLLERS))
def _paper(controller: str) -> dict[str, Any]:
    tables = tomllib.loads(FILE.read_text(encoding="utf-8"))
    return flatten({**tables["experiment"], "controller": tables["controller"][controller]})


def _same(first: Any, second: Any) -> bool:
    if isinstance(first, list) and isinstance(second, list):
        return len(first) == len(second) and all(map(_same, first, second))
    if isinstance(first, bool) or isinstance(second, bool):
        return first is second
    if isinstance(first, int | float) and isinstance(second, int | float):
        return math.isclose(first, second, rel_tol=_TOLERANCE, abs_tol=1e-12)
    return first == second


def _shown(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_shown, value))}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key} = {_shown(inside)}' for key, inside in value.items())}}}"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.7g}" if isinstance(value, float) else str(value)
