"""A path around a post: the flat mission, bent around an upright axis behind the surface.

What the flat mission does at the place s along u, the wrapped one does at the angle s / R around the axis,
with the contact axis, the sliding axis and the heading turned by it. So the robot flies around the post with
its tip toward it, and lengths along the path are those of the flat one.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.control.missions.frame import ContactFrame
from skylimb.control.missions.reference import Reference

_UPRIGHT = 1e-6


@configuration
class WrapConfig:
    """What the path is bent around."""

    radius: Annotated[
        float | None,
        Key("m", "radius of the upright post that the path goes around; none for a flat path", 0.01, 1000.0),
    ] = None


class Along(NamedTuple):
    """Place along the sliding axis u, m, its rate and its second derivative, (k,) each."""

    place: np.ndarray
    rate: np.ndarray
    bend: np.ndarray


def require_upright(frame: ContactFrame) -> None:
    """Raise a `ConfigError` unless the axis that the path is bent around is upright."""
    if np.hypot(*frame.sliding_v[:2]) > _UPRIGHT:
        raise ConfigError(
            f"wrap.radius bends a path around the axis v = {frame.sliding_v.round(3).tolist()}, which has to "
            "be upright: choose a level contact_axis"
        )


def wrapped(
    reference: Reference, frame: ContactFrame, center: np.ndarray, radius: float, along: Along
) -> Reference:
    """The flat references bent around the post.

    Args:
        reference: of every tick of the flat mission, rates and accelerations as they are sent.
        frame: axes of the flat task.
        center: middle of the path on the nominal surface, W, m, (3,).
        radius: of the post, m.
        along: the path's place along u at every tick.
    """
    turn, spin, surge = (-part / radius for part in along)
    bent = _Bend(frame, center + radius * frame.contact, turn)
    flat = along.place[:, None] * frame.sliding_u
    moved = {}
    for place, rate, bend in (
        ("position", "velocity", "acceleration"),
        ("tip_position", "tip_velocity", "tip_acceleration"),
    ):
        there = bent.point(getattr(reference, place) - flat)
        moved[place] = there
        # What is not sent stays unsent.
        sent = float(np.any(getattr(reference, rate)))
        inward = bent.vector(getattr(reference, rate) - sent * along.rate[:, None] * frame.sliding_u)
        moved[rate] = inward + sent * bent.swept(there, spin)
        sent = float(np.any(getattr(reference, bend)))
        away = there - bent.axis_point
        level = away - np.outer(away @ frame.sliding_v, frame.sliding_v)
        moved[bend] = bent.vector(
            getattr(reference, bend) - sent * along.bend[:, None] * frame.sliding_u
        ) + sent * (
            bent.swept(there, surge)
            - level * (spin**2)[:, None]
            + 2.0 * spin[:, None] * np.cross(frame.sliding_v, inward)
        )
    return reference._replace(
        **moved,
        contact_axis=bent.vector(reference.contact_axis),
        sliding_axis=bent.vector(reference.sliding_axis),
        heading=reference.heading + turn * frame.sliding_v[2],
    )


def wrapped_points(
    points: np.ndarray, frame: ContactFrame, center: np.ndarray, radius: float, place: np.ndarray
) -> np.ndarray:
    """Points of the flat path, W, m, (k, 3), bent around the post; their places along u are (k,)."""
    bent = _Bend(frame, center + radius * frame.contact, -place / radius)
    return bent.point(points - place[:, None] * frame.sliding_u)


class _Bend(NamedTuple):
    """Turns about the post's axis, one for every tick.

    Attributes:
        frame: axes of the flat task; v is the axis.
        axis_point: a point of the axis, W, m, (3,).
        turn: rad, (k,).
    """

    frame: ContactFrame
    axis_point: np.ndarray
    turn: np.ndarray

    def vector(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (k, 3) turned."""
        v = self.frame.sliding_v
        c, s = np.cos(self.turn)[:, None], np.sin(self.turn)[:, None]
        upright = np.outer(vectors @ v, v)
        return upright + c * (vectors - upright) + s * np.cross(v, vectors)

    def point(self, points: np.ndarray) -> np.ndarray:
        """Points (k, 3) turned about the axis."""
        return self.axis_point + self.vector(points - self.axis_point)

    def swept(self, points: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Velocity of points (k, 3) that turn with `rate` (k,) about the axis."""
        return rate[:, None] * np.cross(self.frame.sliding_v, points - self.axis_point)
