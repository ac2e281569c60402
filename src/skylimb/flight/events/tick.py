"""Ticks for which the controller comes too late: a busy computer, a law that raises or never comes back.

Without a supervisor nobody commands then: thrusts and set points stay what they are for so long, and the
controller, which does not know, goes on. A supervisor is told, and commands in the controller's place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.flight.events.event import Event, EventContext, ModelRows, TickRows
from skylimb.simulation.rows import row_layout

_NEVER = 1e30
"""A rotor of this time constant keeps its thrust to the bit, s."""


@configuration
class LateTicks(Event):
    """The controller gives no command in time."""

    kind: Literal["tick"] = field(default="tick", kw_only=True)
    duration: Annotated[
        float, Key("s", "how long; a control period for a single tick", above=0.0, high=1e5)
    ] = field(kw_only=True)

    on: ClassVar[Literal["controller", "plant"]] = "plant"

    @property
    def words(self) -> str:
        """How long."""
        return f"no command for {self.duration:g} s"

    def require(self, context: EventContext) -> None:
        """Every robot has commands."""

    @classmethod
    def effect(
        cls, events: Sequence[LateTicks], context: EventContext, times: np.ndarray
    ) -> ModelRows | TickRows:
        """The rotors' time constants and the servos' speed limits, or what a supervisor is told."""
        robot, rotors, late = context.robot, context.robot.n_rotors, [one.lasting(times) for one in events]
        if context.supervised:
            layout = row_layout(robot)
            added = np.zeros((len(times), layout.size))
            for ticks in late:
                added[ticks, layout.slices["late"]] = 1.0
            return TickRows(added)
        assert context.plant is not None
        servos = range(rotors, rotors + robot.n_joints + robot.n_vectoring)
        fields = [("actuator_dynprm", index, 1) for index in range(rotors)]
        fields += [("actuator_ctrlrange", index, 2) for index in servos]
        rows = ModelRows.untouched(context.plant.model, fields, times)
        for ticks in late:
            rows.values[ticks, :rotors] = _NEVER
            rows.values[ticks, rotors:] = 0.0
        return rows
