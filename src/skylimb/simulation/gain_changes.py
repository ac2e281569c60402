"""Gains that change in flight, spread over a moment so that no command jumps.

Gains are inputs of the compiled tick, so a change rebuilds nothing: both drivers write the few numbers that
change into the flight's own copy of the gains before each tick.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from skylimb.control.controller import Controller, is_traceable
from skylimb.errors import ConfigError, unknown_name
from skylimb.keys import Key, configuration
from skylimb.packing import Layout


@configuration
class GainChange:
    """A gain that changes in flight, along a straight line from what it is at the time to a new value."""

    time: Annotated[float, Key("s", "time since take-off at which the change begins", low=0.0, high=1e5)]
    key: Annotated[
        str,
        Key("", "the gain's key in the preset, for example translation.force or contact.machine.touch_force"),
    ]
    value: Annotated[
        float | tuple[float, ...],
        Key(
            "",
            "the new value, as many numbers as the gain has; in its unit, within its range",
            low=-math.inf,
            high=math.inf,
        ),
    ]
    blend: Annotated[float, Key("s", "how long the change takes; 0 for a jump", low=0.0, high=1e4)] = 0.5


@dataclass(frozen=True)
class GainRows:
    """The gains that change, at every tick.

    Attributes:
        columns: where they stand in the flat gains, (m,).
        values: what they are, one row for every tick that the flight may have, (k, m).
    """

    columns: np.ndarray
    values: np.ndarray

    def until(self, count: int) -> GainRows:
        """The first `count` ticks."""
        return GainRows(self.columns, self.values[:count])


def require_gain_changes(changes: Sequence[GainChange], controller: Controller) -> None:
    """Raise a `ConfigError` unless every change is of a gain of the controller, to a value that it allows."""
    if not changes:
        return
    if not is_traceable(controller):
        raise ConfigError(
            f"gain_changes: controller '{controller.name}' flies in Python; only the gains of one that is "
            "compiled can be changed in flight"
        )
    known = Layout(controller.gains()).slices
    for change in changes:
        if change.key not in known:
            raise unknown_name(f"gain of controller {controller.name} in gain_changes", change.key, known)
        controller.check_gain(change.key, change.value, f"gain_changes of controller {controller.name}")


def gain_rows(
    changes: Sequence[GainChange], gains: np.ndarray, layout: Layout[Any], times: np.ndarray
) -> GainRows | None:
    """The gains that change, at every tick; None where none does.

    Args:
        changes: in any order; where two of one gain overlap, the later one begins at what the gain then is.
        gains: before take-off, flat.
        layout: where each stands.
        times: of every tick that the flight may have, s.

    Raises:
        ConfigError: when a change comes after the last tick.
    """
    if not changes:
        return None
    late = max(changes, key=lambda change: change.time)
    if late.time > times[-1]:
        raise ConfigError(
            f"gain_changes: {late.key} at {late.time:g} s comes after the flight's end at {times[-1]:g} s"
        )
    columns = np.unique(np.concatenate([np.r_[layout.slices[change.key]] for change in changes]))
    values = np.tile(gains[columns], (len(times), 1))
    ordered = sorted(changes, key=lambda change: change.time)
    firsts = [int(np.searchsorted(times, change.time - 1e-9)) for change in ordered]
    until = dict.fromkeys((change.key for change in changes), len(times))
    ends = []
    for change, first in zip(reversed(ordered), reversed(firsts), strict=True):
        # Up to the next change of the same gain, which reads there where it begins.
        ends.append(min(until[change.key] + 1, len(times)))
        until[change.key] = first
    for change, first, end in zip(ordered, firsts, reversed(ends), strict=True):
        where = np.searchsorted(columns, np.r_[layout.slices[change.key]])
        since = times[first:end] - change.time
        part = np.clip(since / change.blend, 0.0, 1.0) if change.blend > 0.0 else np.ones(len(since))
        before, after = values[first, where].copy(), np.ravel(change.value)
        # Written so that it is the new value to the bit in the end.
        values[first:end, where] = (1.0 - part[:, None]) * before + part[:, None] * after
    return GainRows(columns, values)
