"""How far the parts of a robot reach: its rotors' discs and the shapes that draw its links."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from skylimb.robots.bodies import lump
from skylimb.robots.description import RobotDescription, Rotor
from skylimb.robots.links import Link, Visual

_CORNERS = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
_AROUND = 2.0 * math.pi * np.arange(25) / 24
_RIM = np.array([np.cos(_AROUND), np.sin(_AROUND), 0.0 * _AROUND]).T
_SMALLEST, _LARGEST, _FLAT = 0.02, 0.6, 0.4
"""Radius of what may be a drawn propeller, m, and its thickness over its radius."""
_MIDDLE = 0.25
"""How far its middle is from the rotor's axis at most, over its radius."""
_TOOL = 5e-3
"""What comes nearer to the tip's ball than this is the tool that carries it, m."""


@dataclass(frozen=True, eq=False)
class Part:
    """What must not touch a surface: the convex hull of equal balls.

    Attributes:
        name: the rotor's, or the link's.
        link: in whose frame it is.
        points: middles of the balls, m, (k, 3).
        radius: of each, m.
    """

    name: str
    link: str
    points: np.ndarray
    radius: float = 0.0


def parts_of(description: RobotDescription) -> list[Part]:
    """Discs of the rotors (their middles, where no radius is known) and the shapes of all links.

    Left out is the tool, which is what comes near to the tip, and meshes: who has some says by <collision>
    shapes what can touch.
    """
    tip, (_, places) = description.tip, lump(description)
    parts = [Part(rotor.name, rotor.link, rim(rotor)) for rotor in description.rotors]
    end = places[tip.link]
    ball = end.xyz + end.R @ tip.position
    for link in description.links:
        place = places[link.name]
        at = place.R.T @ (ball - place.xyz)
        for shape in link.collisions or link.visuals:
            same = place.body == end.body and _distance(shape, at) < tip.radius + _TOOL
            if shape.shape != "mesh" and not same:
                radius = shape.size[0] if shape.shape == "sphere" else 0.0
                parts.append(Part(link.name, link.name, _hull(shape), radius))
    return parts


def rim(rotor: Rotor) -> np.ndarray:
    """The closed rim of a rotor's disc in its link's frame, m, (k, 3); its middle without a radius."""
    return rotor.xyz + (rotor.radius or 0.0) * _RIM @ rotor.R.T


def drawn_radius(links: Iterable[Link], link: str, xyz: np.ndarray, axis: np.ndarray) -> float | None:
    """Radius of the propeller that a link draws about an axis, m: a disc, or a flat box; None for none.

    Args:
        links: of the robot.
        link: that carries the rotor.
        xyz: the rotor's middle in the link's frame, m, (3,).
        axis: of its thrust there, (3,).
    """
    found = []
    for one in links:
        for shape in (*one.visuals, *one.collisions) if one.name == link else ():
            if shape.shape not in ("cylinder", "box"):
                continue
            points, off = _hull(shape) - shape.xyz, shape.xyz - xyz
            along = points @ axis
            radius = float(np.linalg.norm(points - np.outer(along, axis), axis=1).max())
            aside = float(np.linalg.norm(off - (off @ axis) * axis))
            if (
                _SMALLEST <= radius <= _LARGEST
                and np.ptp(along) <= _FLAT * radius
                and aside <= _MIDDLE * radius
            ):
                found.append(radius)
    return round(max(found), 6) if found else None


def _hull(shape: Visual) -> np.ndarray:
    """Points of a shape in its link's frame whose convex hull it fills; a ball's middle."""
    points = np.zeros((1, 3))
    if shape.shape == "box":
        points = _CORNERS * shape.size
    elif shape.shape == "cylinder":
        radius, length = shape.size
        points = np.concatenate([radius * _RIM + [0.0, 0.0, end * length] for end in (-0.5, 0.5)])
    return shape.xyz + points @ shape.R.T


def _distance(shape: Visual, point: np.ndarray) -> float:
    """From a shape to a point of its link's frame, m; 0 inside."""
    local = np.abs(shape.R.T @ (point - shape.xyz))
    if shape.shape == "box":
        return float(np.linalg.norm(np.maximum(local - 0.5 * np.array(shape.size), 0.0)))
    if shape.shape == "cylinder":
        aside = max(math.hypot(local[0], local[1]) - shape.size[0], 0.0)
        return math.hypot(aside, max(local[2] - 0.5 * shape.size[1], 0.0))
    return max(float(np.linalg.norm(local)) - shape.size[0], 0.0)
