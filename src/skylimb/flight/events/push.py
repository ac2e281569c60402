"""Pushes on the flying robot: constant wrenches, at its centre of gravity or at a point of a link."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import field
from typing import Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.errors import unknown_name
from skylimb.base.keys import Key, configuration, refused
from skylimb.flight.events.event import Event, EventContext

Vector = tuple[float, float, float]

STRONGEST = 100.0
"""Greatest force along an axis, N."""
_ZERO = (0.0, 0.0, 0.0)
_Word, _Vector = ctypes.c_int64, ctypes.c_double * 3


@configuration
class Push(Event):
    """The robot is pushed; what acts at the same time adds up."""

    kind: Literal["push"] = field(default="push", kw_only=True)
    duration: Annotated[float, Key("s", "how long it lasts", above=0.0, high=1e5)] = field(kw_only=True)
    force: Annotated[Vector, Key("N", "force in W", low=-STRONGEST, high=STRONGEST)] = _ZERO
    torque: Annotated[Vector, Key("N m", "torque in W", low=-50.0, high=50.0)] = _ZERO
    link: Annotated[str, Key("", "link that is pushed; empty for the robot's true centre of gravity")] = ""
    point: Annotated[
        Vector, Key("m", "where the force acts, in the link's axes; only with a link", low=-10.0, high=10.0)
    ] = _ZERO

    on: ClassVar[Literal["controller", "plant"]] = "plant"

    def check(self) -> None:
        """Refuse a point without a link."""
        super().check()
        if any(self.point) and not self.link:
            raise refused(self, "point", "needs a link, in whose axes it is; link is empty")

    @property
    def words(self) -> str:
        """How hard, and where."""
        sizes = [(np.linalg.norm(self.force), "N"), (np.linalg.norm(self.torque), "N m")]
        said = " and ".join(f"{size:.3g} {unit}" for size, unit in sizes if size > 0.0)
        return f"{said or 'nothing'} on {self.link or 'the centre of gravity'}"

    def require(self, context: EventContext) -> None:
        """The robot has such a link that moves by itself."""
        names = [body.name for body in context.robot.bodies]
        if self.link and self.link not in names:
            raise unknown_name("link of a push", self.link, names)

    @classmethod
    def effect(cls, events: Sequence[Push], context: EventContext, times: np.ndarray) -> tuple[Wrench, ...]:
        """All wrenches that act in some tick, in the order in which they are added up."""
        assert context.plant is not None
        model, root, found = context.plant.model, context.robot.description.root, []
        for push in events:
            begin, end = np.searchsorted(times, [push.time - 1e-9, push.time + push.duration - 1e-9])
            if begin < end and (any(push.force) or any(push.torque)):
                body, local = model.body(push.link or root).id, int(bool(push.link))
                found.append(Wrench(begin, end, body, local, push.force, push.torque, push.point))
        return tuple(found)


class Wrench(ctypes.Structure):
    """A push on a model; `Wrench` of flight.c is declared from these fields.

    begin, end: ticks from which and before which it acts. body: that is pushed. local: 1 when the force acts
    at `point`, m, in the body's axes; 0 when it acts at the centre of gravity of the body and all below it.
    """

    _fields_ = (
        ("begin", _Word), ("end", _Word), ("body", _Word), ("local", _Word),
        ("force", _Vector), ("torque", _Vector), ("point", _Vector),
    )  # fmt: skip
