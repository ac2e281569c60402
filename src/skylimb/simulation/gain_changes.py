"""Gains that change in flight, spread over a moment so that no command jumps.

Gains are inputs of the compiled tick, so a change rebuilds nothing: both drivers write the few numbers that
change into the flight's own copy of the gains before each tick.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skylimb.config import require_range, with_overrides
from skylimb.control.cascade import Cascade
from skylimb.control.controller import Controller
from skylimb.control.preset import SLOTS
from skylimb.errors import ConfigError, unknown_name
from skylimb.packing import Layout


@dataclass(frozen=True)
class GainChange:
    """One change: from what a gain is at the time to a new value, along a straight line.

    Attributes:
        time: at which it begins, since take-off, s.
        key: of the gain in the preset, for example "translation.force" or "contact.machine.touch_force".
        value: new; as many numbers as the gain has.
        blend: how long the change takes, s; 0 for a jump.
    """

    time: float
    key: str
    value: float | tuple[float, ...]
    blend: float = 0.5

    def __post_init__(self) -> None:
        require_range("gain_changes", "time", self.time, 0.0, 1e5, "s")
        require_range("gain_changes", "blend", self.blend, 0.0, 1e4, "s")


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
    if not isinstance(controller, Cascade):
        raise ConfigError(
            f"gain_changes: controller '{controller.name}' is a Python class of its own; only the gains of a "
            "preset can be changed in flight"
        )
    known = Layout(controller.gains()).slices
    for change in changes:
        if change.key not in known:
            raise unknown_name(f"gain of controller {controller.name} in gain_changes", change.key, known)
        part, _, key = change.key.partition(".")
        owner = getattr(controller.preset, part)
        try:
            with_overrides(owner.gains if part in SLOTS else owner, {key: change.value})
        except ConfigError as error:
            reason = str(error).removeprefix("override: ")
            raise ConfigError(
                f"gain_changes: {change.key} of controller {controller.name}: {reason}"
            ) from None


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
    for change in sorted(changes, key=lambda change: change.time):
        where = np.searchsorted(columns, np.r_[layout.slices[change.key]])
        first = int(np.searchsorted(times, change.time - 1e-9))
        since = times[first:] - change.time
        part = np.clip(since / change.blend, 0.0, 1.0) if change.blend > 0.0 else np.ones(len(since))
        before, after = values[first, where].copy(), np.ravel(change.value)
        # Written so that it is the new value to the bit in the end.
        values[first:, where] = (1.0 - part[:, None]) * before + part[:, None] * after
    return GainRows(columns, values)
