"""Gains that change in flight, spread over a moment so that no command jumps.

Gains are inputs of the compiled tick, so a change rebuilds nothing: a driver writes the few numbers that
change into the flight's own copy of the gains before each tick.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.keys import Key, configuration
from skylimb.base.packing import Layout
from skylimb.control.controller import is_traceable
from skylimb.control.laws.prepared_gains import settled
from skylimb.flight.events.event import Change, Event, EventContext, GainRows, write_changes


@configuration
class GainChange(Event):
    """A gain of the controller goes along a straight line to a new value."""

    kind: Literal["gain"] = field(default="gain", kw_only=True)
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
    duration: Annotated[float, Key("s", "how long the change takes; 0: a jump", low=0.0, high=1e4)] = field(
        default=0.5, kw_only=True
    )

    on: ClassVar[Literal["controller", "plant"]] = "controller"

    @property
    def words(self) -> str:
        """The gain and its new value."""
        value = np.ravel(self.value)
        return f"{self.key} to {value[0]:g}" if len(value) == 1 else f"{self.key} to {value.tolist()}"

    def require(self, context: EventContext) -> None:
        """The controller is compiled, and has such a gain, which may have such a value."""
        controller = context.controller
        if not is_traceable(controller):
            raise ConfigError(
                f"{self}: controller '{controller.name}' flies in Python; only the gains of one that is "
                "compiled can be changed in flight"
            )
        known = [key for key in Layout(controller.gains()).slices if not key.startswith("prepared.")]
        if self.key not in known:
            raise unknown_name(f"gain of controller {controller.name} in an event", self.key, known)
        asks = f"{self}, controller {controller.name}"
        controller.check_gain(self.key, self.value, asks, context.period)

    @property
    def changed(self) -> dict[str, Any]:
        """The gain and its new value."""
        return {self.key: self.value}

    @classmethod
    def effect(cls, events: Sequence[GainChange], context: EventContext, times: np.ndarray) -> GainRows:
        """The gains that change, at every tick."""
        return gain_rows(events, context.controller, times)


def gain_rows(changes: Sequence[GainChange], controller: Any, times: np.ndarray) -> GainRows:
    """The gains that change, at every tick, and what laws prepare of them.

    Args:
        changes: in any order; where two of one gain overlap, the later one begins at what the gain then is.
        controller: a `control.controller.TraceableController`.
        times: of every tick that the flight may have, s.

    Raises:
        UserCodeError: where a law cannot prepare itself for the gains of a tick.
    """
    layout = Layout(controller.gains())
    gains = layout.pack(controller.gains())
    columns = np.unique(np.concatenate([np.r_[layout.slices[change.key]] for change in changes]))
    values = np.tile(gains[columns], (len(times), 1))
    for key in dict.fromkeys(change.key for change in changes):
        where = np.searchsorted(columns, np.r_[layout.slices[key]])
        alike = [Change(one.time, one.duration, np.ravel(one.value)) for one in changes if one.key == key]
        write_changes(values, where, alike, times)
    if not any(name.startswith("prepared.") for name in layout.slices):
        return GainRows(columns, values)
    whole, known = np.tile(gains, (len(times), 1)), gains
    for k, row in enumerate(values):
        if k == 0 or not np.array_equal(row, values[k - 1]):
            known = gains.copy()
            known[columns] = row
            known = layout.pack(settled(controller.preset, controller.robot, layout.unpack(known)))
        whole[k] = known
    return GainRows(np.arange(layout.size), whole)
