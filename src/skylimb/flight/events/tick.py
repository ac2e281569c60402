"""Ticks whose commands never reach the robot: a computer that comes too late, a cable that breaks contact.

Thrusts and set points stay what they are for so long, and the controller, which does not know, goes on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.flight.events.event import Event, EventContext, ModelRows

_NEVER = 1e30
"""A rotor of this time constant keeps its thrust to the bit, s."""


@configuration
class LostCommands(Event):
    """No command reaches the robot: its thrusts and set points stay what they are."""

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
    def effect(cls, events: Sequence[LostCommands], context: EventContext, times: np.ndarray) -> ModelRows:
        """The rotors' time constants and the servos' speed limits, at every tick."""
        assert context.plant is not None
        robot, rotors = context.robot, context.robot.n_rotors
        servos = range(rotors, rotors + robot.n_joints + robot.n_vectoring)
        fields = [("actuator_dynprm", index, 1) for index in range(rotors)]
        fields += [("actuator_ctrlrange", index, 2) for index in servos]
        rows = ModelRows.untouched(context.plant.model, fields, times)
        for one in events:
            ticks = one.lasting(times)
            rows.values[ticks, :rotors] = _NEVER
            rows.values[ticks, rotors:] = 0.0
        return rows
