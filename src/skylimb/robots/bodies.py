"""Links that move as one: everything that fixed joints hold together, as one body on one moving joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.robots.description import RobotDescription
from skylimb.robots.links import Joint
from skylimb.robots.urdf import clean_rotation


@dataclass(frozen=True)
class Placement:
    """Where a link sits in its body: position (3,) in m and orientation (3, 3) in the body's frame."""

    body: int
    xyz: np.ndarray
    R: np.ndarray


@dataclass(frozen=True)
class Body:
    """A rigid body of the kinematic tree; its frame is that of its first link.

    Attributes:
        name: the first link's name.
        parent: index of the parent body, -1 for the root.
        joint: the moving joint that leads here, None for the root.
        xyz: (3,) origin in the parent body's frame, m.
        R: (3, 3) orientation in the parent body's frame at joint angle zero.
        mass: kg.
        com: (3,) centre of mass in the body frame, m.
        inertia: (3, 3) about the centre of mass in the body's axes, kg m^2.
    """

    name: str
    parent: int
    joint: Joint | None
    xyz: np.ndarray
    R: np.ndarray
    mass: float
    com: np.ndarray
    inertia: np.ndarray


def lump(description: RobotDescription) -> tuple[tuple[Body, ...], dict[str, Placement]]:
    """The bodies of a robot (parents first, root at 0) and where each link sits in them."""
    places = {description.root: Placement(0, np.zeros(3), np.eye(3))}
    seeds: list[tuple[str, int, Joint | None, np.ndarray, np.ndarray]] = [
        (description.root, -1, None, np.zeros(3), np.eye(3))
    ]
    for joint in description.joints:
        parent = places[joint.parent]
        xyz, R = parent.xyz + parent.R @ joint.xyz, clean_rotation(parent.R @ joint.R)
        if joint.kind == "fixed":
            places[joint.child] = Placement(parent.body, xyz, R)
        else:
            places[joint.child] = Placement(len(seeds), np.zeros(3), np.eye(3))
            seeds.append((joint.child, parent.body, joint, xyz, R))
    bodies = tuple(
        Body(name, parent, joint, xyz, R, *_composite(description, places, index))
        for index, (name, parent, joint, xyz, R) in enumerate(seeds)
    )
    return bodies, places


def _composite(
    description: RobotDescription, places: dict[str, Placement], body: int
) -> tuple[float, np.ndarray, np.ndarray]:
    members = [
        (link.inertial, places[link.name]) for link in description.links if places[link.name].body == body
    ]
    mass = sum(inertial.mass for inertial, _ in members)
    if mass <= 0.0:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    centres = [place.xyz + place.R @ inertial.com for inertial, place in members]
    com = (
        sum((inertial.mass * c for (inertial, _), c in zip(members, centres, strict=True)), np.zeros(3))
        / mass
    )
    inertia = np.zeros((3, 3))
    for (inertial, place), centre in zip(members, centres, strict=True):
        d = centre - com
        inertia += place.R @ inertial.inertia @ place.R.T
        inertia += inertial.mass * (np.dot(d, d) * np.eye(3) - np.outer(d, d))
    return mass, com, inertia
