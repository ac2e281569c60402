"""Pushes on the flying robot: constant wrenches, at its centre of gravity or at a point of a link.

A bent robot's centre of gravity lies in the air. A force there is spread over all bodies by their masses, as
gravity is: it accelerates all of them alike and loads no joint. Held by one link it would bend the arm.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from dataclasses import field
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from skylimb.base.keys import Key, configuration, refused
from skylimb.flight.events.event import Event, EventContext, require_known

Vector = tuple[float, float, float]

STRONGEST = 100.0
"""Greatest force along an axis, N."""
_ZERO = (0.0, 0.0, 0.0)
_Word, _Vector = ctypes.c_int64, ctypes.c_double * 3


@configuration
class Push(Event):
    """The robot is pushed; what acts at the same time adds up."""

    kind: Literal["push"] = field(default="push", kw_only=True)
    duration: Annotated[
        float,
        Key("s", "how long it lasts: it acts in the control periods that begin then", above=0.0, high=1e5),
    ] = field(kw_only=True)
    force: Annotated[Vector, Key("N", "force in W", low=-STRONGEST, high=STRONGEST)] = _ZERO
    torque: Annotated[Vector, Key("N m", "torque in W", low=-50.0, high=50.0)] = _ZERO
    link: Annotated[
        str, Key("", "link that is pushed; empty for all by their masses, through the true centre of gravity")
    ] = ""
    point: Annotated[
        Vector, Key("m", "where the force acts, in the link's axes; only with a link", low=-10.0, high=10.0)
    ] = _ZERO

    on: ClassVar[Literal["controller", "plant"]] = "plant"
    lasts: ClassVar[bool] = True

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
        require_known("link of a push", self.link, [body.name for body in context.robot.bodies])

    @classmethod
    def effect(cls, events: Sequence[Push], context: EventContext, times: np.ndarray) -> tuple[Wrench, ...]:
        """All wrenches that act in some tick, in the order in which they are added up."""
        assert context.plant is not None
        model, found = context.plant.model, []
        root = model.body(context.robot.description.root).id
        for push in events:
            begin, end = np.searchsorted(times, [push.time - 1e-9, push.time + push.duration - 1e-9])
            if begin < end and (any(push.force) or any(push.torque)):
                if push.link:
                    body = model.body(push.link).id
                    found.append(Wrench(begin, end, body, push.force, push.torque, push.point))
                else:
                    found += _spread(model, root, begin, end, push)
        return tuple(found)


def _spread(model: Any, root: int, begin: int, end: int, push: Push) -> Iterator[Wrench]:
    """A push on the whole robot: each body's share of the force, and the torque on the root."""
    for body in np.flatnonzero(model.body_rootid == model.body_rootid[root]).tolist():
        force = np.array(push.force) * (model.body_mass[body] / model.body_subtreemass[root])
        torque = push.torque if body == root else _ZERO
        if any(force) or any(torque):
            yield Wrench(begin, end, body, tuple(force), torque, tuple(model.body_ipos[body]))


class Wrench(ctypes.Structure):
    """A push on a model; `Wrench` of flight.c is declared from these fields.

    begin, end: ticks from which and before which it acts. body: that is pushed at `point`, m, in its axes.
    """

    _fields_ = (
        ("begin", _Word), ("end", _Word), ("body", _Word),
        ("force", _Vector), ("torque", _Vector), ("point", _Vector),
    )  # fmt: skip
