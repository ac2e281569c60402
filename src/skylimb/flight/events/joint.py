"""Servos that fail: of a joint that goes limp, sticks or runs away, shape or vectoring.

A servo is a spring from the joint to a set point, which its command drives at a limited rate. A limp one has
lost the spring, a stuck one's set point stands still, and that of one that runs away goes on at its own
speed, until the joint's stop or the servo's torque ends it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.keys import Key, configuration, refused
from skylimb.flight.events.event import Event, EventContext, ModelRows, require_known

_FIELDS = ("actuator_gainprm", 1), ("actuator_biasprm", 3), ("actuator_ctrlrange", 2)


@configuration
class JointFault(Event):
    """A servo doesn't follow its command."""

    kind: Literal["joint"] = field(default="joint", kw_only=True)
    joint: Annotated[str, Key("", "which, of the shape or of the vectoring joints")]
    strength: Annotated[
        float | None, Key("", "stiffness and damping that are left; 0: limp", low=0.0, high=1.0)
    ] = None
    speed: Annotated[
        float | None,
        Key("rad/s", "at which its set point runs, whatever is commanded; 0: stuck", low=-20.0, high=20.0),
    ] = None
    duration: Annotated[float, Key("s", "how long it lasts; 0: for good", low=0.0, high=1e5)] = field(
        default=0.0, kw_only=True
    )

    on: ClassVar[Literal["controller", "plant"]] = "plant"
    lasts: ClassVar[bool] = True

    def check(self) -> None:
        """Refuse a fault that changes nothing."""
        super().check()
        if self.strength is None and self.speed is None:
            raise refused(self, "joint", "fails in no way: give strength or speed")

    @property
    def words(self) -> str:
        """Which joint, and what it does."""
        limp = "limp" if self.strength == 0.0 else f"at {self.strength} of its strength"
        runs = "stuck" if self.speed == 0.0 else f"running away at {self.speed} rad/s"
        said = [word for word, value in ((limp, self.strength), (runs, self.speed)) if value is not None]
        return f"{self.joint} {' and '.join(said)}"

    @property
    def changed(self) -> dict[str, float | None]:
        """The joint's strength and speed."""
        found = {"strength": self.strength, "speed": self.speed}
        return {f"{self.joint} {name}": value for name, value in found.items() if value is not None}

    def require(self, context: EventContext) -> None:
        """The robot has such a joint with a servo."""
        names = context.robot.description.moving_joints
        require_known("joint of an event", self.joint, names, optional=False)

    @classmethod
    def effect(cls, events: Sequence[JointFault], context: EventContext, times: np.ndarray) -> ModelRows:
        """What the engine knows of the servos, at every tick."""
        assert context.plant is not None
        names, rotors = context.robot.description.moving_joints, context.robot.n_rotors
        which = sorted({rotors + names.index(one.joint) for one in events})
        fields = [(name, index, entries) for index in which for name, entries in _FIELDS]
        rows = ModelRows.untouched(context.plant.model, fields, times)
        for one in sorted(events, key=lambda event: event.time):
            first = 6 * which.index(rotors + names.index(one.joint))
            ticks = one.lasting(times)
            if one.strength is not None:
                rows.values[ticks, first : first + 4] *= one.strength
            if one.speed is not None:
                rows.values[ticks, first + 4 : first + 6] = one.speed
        return rows
