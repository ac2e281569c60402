"""Where the robot is to hover: ways that begin and end at rest, and velocities that a user steers with."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from skylimb.apps.ros.limits import FlightLimits
from skylimb.base.rotations import wrapped
from skylimb.control.planning.smooth_step import quintic


class RefusedError(Exception):
    """Why a request is not fulfilled, for its user."""


class Shape(NamedTuple):
    """Joint angles, rad, (nq,), and vectoring angles, rad, (nv,)."""

    joints: np.ndarray
    vectoring: np.ndarray


Form = float | Shape
"""How a robot is bent: the shape angle of its family of postures, rad, or the angles of any other posture."""


class Place(NamedTuple):
    """Where a robot hovers: centre of gravity in W, m, (3,); yaw of the lab's link, rad; its form."""

    position: np.ndarray
    yaw: float
    form: Form


class Target(NamedTuple):
    """A place, with velocity and acceleration of its position in W."""

    place: Place
    velocity: np.ndarray
    acceleration: np.ndarray


class Leg(NamedTuple):
    """A way from rest to rest, along the quintic of least jerk.

    Attributes:
        start: where it begins.
        end: where it ends.
        begin: when, s.
        duration: s.
        bends: shapes on the way, evenly in time, where it leads through others than those of the family.
    """

    start: Place
    end: Place
    begin: float
    duration: float
    bends: tuple[Shape, ...] = ()

    def at(self, now: float) -> Target:
        """Where the robot is to be."""
        s = min(max((now - self.begin) / self.duration, 0.0), 1.0)
        part, rate, bend = (float(value) for value in quintic(np.asarray(s)))
        way = self.end.position - self.start.position
        turn = wrapped(self.end.yaw - self.start.yaw)
        place = Place(
            self.start.position + part * way,
            self.start.yaw + part * float(turn),
            self._form(s, part),
        )
        return Target(place, rate / self.duration * way, bend / self.duration**2 * way)

    def _form(self, s: float, part: float) -> Form:
        start, end = self.start.form, self.end.form
        if s >= 1.0:
            return end
        if self.bends:
            k = s * (len(self.bends) - 1)
            before, after = self.bends[int(k)], self.bends[int(k) + 1]
            return Shape(*(a + k % 1.0 * (b - a) for a, b in zip(before, after, strict=True)))
        if isinstance(start, Shape) or isinstance(end, Shape):
            return end
        return start + part * (end - start)


@dataclass(frozen=True)
class Targets:
    """All that decides where the robot is to be.

    Attributes:
        place: at `time`.
        time: s.
        legs: to go, one after another.
        velocity: that a user steers with, W, m/s, (3,).
        yaw_rate: likewise, rad/s.
        until: when that ends, s.
    """

    place: Place
    time: float
    legs: tuple[Leg, ...] = ()
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    yaw_rate: float = 0.0
    until: float = -math.inf

    def at(self, now: float) -> tuple[Targets, Target]:
        """The target at a time that is not before the last one, and what remains."""
        legs = self.legs
        while legs and now >= legs[0].begin + legs[0].duration and len(legs) > 1:
            legs = legs[1:]
        if legs:
            target = legs[0].at(now)
            done = now >= legs[0].begin + legs[0].duration
            return replace(self, place=target.place, time=now, legs=() if done else legs), target
        still, steered = np.zeros(3), max(0.0, min(now, self.until) - self.time)
        place = self.place._replace(
            position=self.place.position + steered * self.velocity,
            yaw=self.place.yaw + steered * self.yaw_rate,
        )
        velocity = self.velocity if now < self.until else still
        return replace(self, place=place, time=now), Target(place, velocity, still)

    def hold(self, place: Place, now: float) -> Targets:
        """Stay at a place from now on."""
        return Targets(place, now)

    def go(self, place: Place, now: float, duration: float, bends: tuple[Shape, ...] = ()) -> Targets:
        """Go to a place from where the target is."""
        here = self.at(now)[0].place
        return Targets(here, now, (Leg(here, place, now, duration, bends),))

    def then(self, place: Place, duration: float) -> Targets:
        """Go on to a place from where the last leg ends."""
        last = self.legs[-1]
        end = last.begin + last.duration
        return replace(self, legs=(*self.legs, Leg(last.end, place, end, duration)))

    def steer(self, velocity: np.ndarray, yaw_rate: float, now: float, timeout: float) -> Targets:
        """Move with a velocity for some time."""
        here = self.at(now)[0].place
        return Targets(here, now, (), velocity, yaw_rate, now + timeout)


def duration_of(start: Place, end: Place, limits: FlightLimits, speed: float | None = None) -> float:
    """Time that a way takes by the lab's rule: distance, turn and a least time decide, s.

    Args:
        start: of the way.
        end: of the way.
        limits: the speeds.
        speed: of the position instead of that of a pose, m/s.
    """
    way = float(np.linalg.norm(end.position - start.position))
    bent = 0.0
    if not (isinstance(start.form, Shape) or isinstance(end.form, Shape)):
        bent = abs(end.form - start.form)
    return max(
        way / (speed or limits.pose_speed),
        abs(float(wrapped(end.yaw - start.yaw))) / limits.turn_speed,
        bent / limits.joint_speed,
        limits.shortest_way,
    )
