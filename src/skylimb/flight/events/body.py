"""A body that becomes another in flight: a load that is hung on or lost, a pen that breaks off shorter.

A load is a mass at a point. Mass, centre of gravity and inertia of its link become those of both (Steiner),
and so do the engine's sums of masses; what it scales its constraints by stays what it was at take-off.

The record's tip, gap and centre of gravity go on being those of the robot that took off: a pen that is 30 mm
shorter touches at a gap of -30 mm. Force and point of the contact are the true ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, Vector3, configuration, refused
from skylimb.base.rotations import quaternion_from_rotation, rotation_from_quaternion
from skylimb.flight.events.event import Event, EventContext, ModelRows, require_known
from skylimb.robots.model import Robot
from skylimb.simulation.contact_keys import TIP_GEOM, TIP_SITE

if TYPE_CHECKING:
    import mujoco

_INERTIAL = ("body_mass", 1), ("body_ipos", 3), ("body_iquat", 4), ("body_inertia", 3)
_WIDTH = sum(entries for _, entries in _INERTIAL)
_ROUNDED = 1e-6
"""By which the largest moment of inertia of a thin rod may be more than the sum of the others."""


@configuration
class BodyChange(Event):
    """A link gets or loses a mass, or the pen becomes shorter."""

    kind: Literal["body"] = field(default="body", kw_only=True)
    link: Annotated[str, Key("", "link of the load; empty for the one of the tip")] = ""
    mass: Annotated[float, Key("kg", "of the load; negative for what falls off", low=-50.0, high=50.0)] = 0.0
    point: Annotated[Vector3, Key("m", "where the load is, in the link's axes", low=-10.0, high=10.0)] = (
        0.0, 0.0, 0.0,
    )  # fmt: skip
    pen: Annotated[
        float, Key("m", "by which the pen becomes shorter, along its stem or the tool", low=0.0, high=1.0)
    ] = 0.0
    duration: Annotated[Literal[0], Key("s", "it happens at once")] = field(default=0, kw_only=True)

    on: ClassVar[Literal["controller", "plant"]] = "plant"

    def check(self) -> None:
        """Refuse a change of nothing."""
        super().check()
        if not self.mass and not self.pen:
            raise refused(self, "mass", "changes nothing: give mass or pen")

    @property
    def words(self) -> str:
        """What comes, goes or breaks."""
        load = f"{self.mass:+g} kg on {self.link or 'the link of the tip'}"
        said = [
            word
            for word, value in ((load, self.mass), (f"pen {1e3 * self.pen:g} mm shorter", self.pen))
            if value
        ]
        return " and ".join(said)

    def require(self, context: EventContext) -> None:
        """The robot has such a link, and a pen that is longer; `effect` asks what is left of each."""
        require_known("link of a load", self.link, [body.name for body in context.robot.bodies])
        if self.pen and context.touches != "ball":
            raise ConfigError(f"{self}: a {context.touches}, plant.{context.touches}, does not break off")
        self._require_pen(context.robot, 0.0)

    def _require_pen(self, robot: Robot, shorter: float) -> None:
        """The pen, which is `shorter` already (m), is longer than what breaks off."""
        tip = robot.description.tip
        name, xyz, R = _carrier(robot, tip.link)
        if self.pen and shorter + self.pen >= np.linalg.norm(xyz + R @ tip.position):
            before = f", after {shorter:g} m before," if shorter else ""
            raise ConfigError(f"{self}: pen = {self.pen:g} m{before} is more than {name} is long")

    @classmethod
    def effect(cls, events: Sequence[BodyChange], context: EventContext, times: np.ndarray) -> ModelRows:
        """Inertia of each link that changes, masses above it, and the tip's place.

        Raises:
            ConfigError: when nothing is left of a link or of the pen.
        """
        assert context.plant is not None
        model, tip = context.plant.model, context.robot.description.tip
        name, xyz, R = _carrier(context.robot, tip.link)
        ids = [model.body(one.link or name).id for one in events]
        carriers = sorted({above for body in ids for above in _above(model, body)})
        which = sorted(set(ids))
        fields = [(name, body, entries) for body in which for name, entries in _INERTIAL]
        fields += [("body_subtreemass", body, 1) for body in carriers]
        fields += [("geom_pos", model.geom(TIP_GEOM).id, 3), ("site_pos", model.site(TIP_SITE).id, 3)]
        rows = ModelRows.untouched(model, fields, times)
        shorter = 0.0
        for one, body in sorted(zip(events, ids, strict=True), key=lambda pair: pair[0].time):
            one._require_pen(context.robot, shorter)
            shorter += one.pen
            after = rows.values[one.lasting(times)]
            if not len(after):
                continue
            if one.mass:
                first = _WIDTH * which.index(body)
                own = slice(first, first + _WIDTH)
                point = np.array(one.point) if one.link else xyz + R @ one.point
                after[:, own] = _loaded(one, after[0, own], point)
            for above in _above(model, body):
                after[:, _WIDTH * len(which) + carriers.index(above)] += one.mass
            after[:, -6:] -= np.tile(one.pen * R @ tip.along, 2)
        return rows


def _carrier(robot: Robot, link: str) -> tuple[str, np.ndarray, np.ndarray]:
    """The body that a link is part of, and the link's place and axes there: the engine knows bodies alone."""
    place = robot.placements[link]
    return robot.bodies[place.body].name, place.xyz, place.R


def _above(model: mujoco.MjModel, body: int) -> list[int]:
    """A body and all that carry it, the world among them."""
    found = [body]
    while found[-1]:
        found.append(int(model.body_parentid[found[-1]]))
    return found


def _loaded(one: BodyChange, numbers: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Mass, centre, axes and inertia of a body (the engine's 11 numbers) with the event's load at a point."""
    mass, own, centre, axes = one.mass, numbers[0], numbers[1:4], rotation_from_quaternion(numbers[4:8])
    total = own + mass
    if total <= 0.0:
        raise ConfigError(f"{one}: mass = {mass:g} kg leaves {total:.4g} kg of the link")
    common = (own * centre + mass * point) / total
    inertia = axes @ np.diag(numbers[8:11]) @ axes.T
    for part, at in ((own, centre), (mass, point)):
        away = at - common
        inertia = inertia + part * (away @ away * np.eye(3) - np.outer(away, away))
    moments, axes = np.linalg.eigh(inertia)
    if moments[0] <= 0.0 or moments[2] > (1.0 + _ROUNDED) * (moments[0] + moments[1]):
        raise ConfigError(
            f"{one}: mass = {mass:g} kg at {list(one.point)} m is more than the link has there: it leaves "
            f"principal moments of inertia of {', '.join(f'{moment:.3g}' for moment in moments)} kg m^2, "
            "which no body has"
        )
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return np.concatenate([[total], common, quaternion_from_rotation(axes), moments])
