"""Ticks for which the controller comes too late: a busy computer, a law that raises or never comes back.

Without a supervisor nobody commands then: thrusts and set points stay what they are for so long, and the
controller, which does not know, goes on. A supervisor knows, and commands in the controller's place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.flight.events.event import Event, EventContext, TickRows
from skylimb.simulation.rows import row_layout


@configuration
class LateTicks(Event):
    """The controller gives no command in time."""

    kind: Literal["tick"] = field(default="tick", kw_only=True)
    duration: Annotated[
        float, Key("s", "how long; a control period for a single tick", above=0.0, high=1e5)
    ] = field(kw_only=True)

    on: ClassVar[Literal["controller", "plant"]] = "plant"
    lasts: ClassVar[bool] = True

    @property
    def words(self) -> str:
        """How long."""
        return f"no command for {self.duration:g} s"

    def require(self, context: EventContext) -> None:
        """Every robot has commands."""

    @classmethod
    def effect(cls, events: Sequence[LateTicks], context: EventContext, times: np.ndarray) -> TickRows:
        """What a supervisor gets; without one the plant keeps its last command."""
        layout = row_layout(context.robot)
        added = np.zeros((len(times), layout.size))
        for one in events:
            added[one.lasting(times), layout.slices["late" if context.supervised else "held"]] = 1.0
        return TickRows(added)
