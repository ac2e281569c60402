"""What a replay made of a flight, held against what was recorded: a table, and figures side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.signals import at_ticks
from skylimb.base.files import csv_text

REPLAYED = "replayed"
"""Attribute of a replayed run's log: the name of the run that was recorded."""

_KINDS = ("estimate", "command")
_SUPERVISORS = (
    "supervisor_mode",
    "supervisor_bits",
    "rotor_shares_estimate",
    "lateness_estimate",
    "rotor_slowness_estimate",
)
"""Signals of who stands between controller and vehicle, and is not replayed."""


class Difference(NamedTuple):
    """One signal of a replay beside what was recorded.

    Attributes:
        signal: its name.
        unit: SI.
        size: root mean square of what was recorded, over all entries.
        rms: root mean square of the difference.
        largest: largest difference of an entry.
        time: when that is, s.
        same: whether every bit is the same.
    """

    signal: str
    unit: str
    size: float
    rms: float
    largest: float
    time: float
    same: bool


def differences(recorded: Run, replayed: Run) -> list[Difference]:
    """Every estimate and command that both runs have, in the order of the log; rows are matched by time."""
    here, there = replayed.log, at_ticks(recorded.log, replayed.log)
    found = []
    for name in here.data_vars:
        if here[name].attrs.get("kind") not in _KINDS or name not in there.variables:
            continue
        was, now = there[name].values, here[name].values
        if was.shape != now.shape:
            continue
        found.append(_difference(str(name), here[name].attrs.get("units", ""), here.time.values, was, now))
    return found


def _difference(
    name: str, unit: str, times: np.ndarray, recorded: np.ndarray, replayed: np.ndarray
) -> Difference:
    same = recorded.dtype == replayed.dtype and recorded.tobytes() == replayed.tobytes()
    was = np.asarray(recorded, dtype=float).reshape(len(times), -1)
    off = abs(np.asarray(replayed, dtype=float).reshape(len(times), -1) - was)
    # A number in the place of none is a difference; none in both is not.
    odd = np.isnan(off) & ~(np.isnan(was) & np.isnan(np.reshape(replayed, was.shape).astype(float)))
    off = np.where(odd, np.inf, np.nan_to_num(off))
    worst = off.max(axis=1, initial=0.0)  # of a robot without joints there is none
    at = int(np.argmax(worst))
    return Difference(
        name, unit, _rms(np.nan_to_num(was)), _rms(off), float(worst[at]), float(times[at]), same
    )


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def only_in(one: Run, other: Run) -> list[str]:
    """Estimates and commands of a controller that one run has and the other has not."""
    return [
        str(name)
        for name in one.log.data_vars
        if one.log[name].attrs.get("kind") in _KINDS and name not in (*other.log.variables, *_SUPERVISORS)
    ]


def differences_table(found: Sequence[Difference]) -> str:
    """The differences as CSV, one line a signal."""
    head = ["signal", "unit", "recorded_rms", "difference_rms", "largest", "at_s", "same_bits"]
    return csv_text([head, *([*one[:2], *map(repr, one[2:6]), int(one.same)] for one in found)])
