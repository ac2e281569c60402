"""Rotors that joints turn, as fixed ones: how robots of two and three rotors are flown.

Two or three thrusts leave lift or a torque out; where joints turn the rotors, angles make up for it. The
thrust T of a rotor whose axis u is turned about a, across it, by an angle d from its first place is

    T u(d) = T cos(d) u(0) + T sin(d) (a x u(0)),

so its wrench is linear in the two numbers T cos(d) and T sin(d), drag included. Two fixed rotors give the
same: one along u(0), one to the side; a gimbal of two joints has two sides. Laws and supervisor fly the robot
of such fixed rotors, its pairs, which has four rotors and more and no vectoring joint. Where a command leaves
them, thrust and angles are taken from it again (`skylimb.control.thrust_and_angle`).

Joints count from where the search for vectoring angles begins; the inner one of a gimbal from zero, where
the axes of joints and rotor are across each other. A side acts where its joint's axis meets the plane across
u(0), so the torque is exact where axes and thrust meet; what goes by at a distance e is off by up to
e T (1 - cos(d)). Mass and inertia are those of the first angles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from skylimb.base.rotations import rotation_from_axis_angle
from skylimb.robots.description import RobotDescription, Rotor, Servos, Side
from skylimb.robots.links import Fixed, Joint
from skylimb.symbolic import Array, arctan2, clip, cos, sin, stack

ENOUGH = 4
"""Rotors that can give lift and three torques by their thrusts."""

SIDE = 0.4
"""Share of its greatest thrust that a rotor gives to a side; what is left of it along is the rest."""

_LEAST = 0.01
"""Share of the greatest thrust that a rotor keeps along: without thrust it has no direction."""

_ACROSS = 1e-3
"""Cosine between axes from which on they do not count as across each other."""


@dataclass(frozen=True, eq=False)
class TurnedRotors(Fixed):
    """The robot of pairs, and what a pair stands for.

    Attributes:
        description: with fixed rotors: the robot's own, then the sides of each, from the outer joint in.
        joints: numbers of the vectoring joints that turn each of the robot's rotors, the outer one first.
        start: vectoring angles from which a pair counts, rad, (nv,).
        low: least angle of each joint from there, rad, (nv,).
        high: greatest angle of each joint from there, rad, (nv,).
    """

    description: RobotDescription
    joints: tuple[tuple[int, ...], ...]
    start: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def pairs(self, thrusts: Array, angles: Array) -> Array:
        """Thrusts of the pairs, N: those along, then those to the sides.

        Args:
            thrusts: of the robot, N, (n,).
            angles: of its vectoring joints, rad, (nv,).
        """
        along, sides = [], []
        for index, joints in enumerate(self.joints):
            left, own = thrusts[index], []
            for joint in reversed(joints):
                turn = angles[joint] - self.start[joint]
                own.insert(0, left * sin(turn))
                left = left * cos(turn)
            along.append(left)
            sides += own
        return stack(*along, *sides)

    def command(self, pairs: Array) -> tuple[Array, Array]:
        """Thrusts of the robot, N, (n,), and vectoring angles, rad, (nv,), of thrusts of the pairs, N.

        Where a joint's limit is nearer than the angle of a pair, the thrust is what lies along the rotor.
        """
        thrusts, angles, count = [], {}, len(self.joints)
        for index, joints in enumerate(self.joints):
            along = pairs[index]
            for joint in joints:
                side = pairs[count + len(angles)]
                turn = clip(arctan2(side, along), self.low[joint], self.high[joint])
                along = along * cos(turn) + side * sin(turn)
                angles[joint] = self.start[joint] + turn
            thrusts.append(along)
        return stack(*thrusts), stack(*(angles[joint] for joint in sorted(angles)))


def turned_rotors(description: RobotDescription) -> TurnedRotors | None:
    """The robot of pairs; None for enough rotors, and where joints do not turn one rotor each, across it."""
    names = description.vectoring_joints
    if len(description.rotors) >= ENOUGH or not names:
        return None
    inner = {turn.name for rotor in description.rotors for turn in _turns(description, rotor)[1:]}
    start = [0.0 if n in inner else a for n, a in zip(names, description.vectoring_start, strict=True)]
    there = replace(description, vectoring_start=np.array(start))
    found = [_turns(there, rotor) for rotor in description.rotors]
    if sorted(turn.name for turns in found for turn in turns) != sorted(names):
        return None
    along, sides = [], []
    for index, (turns, rotor) in enumerate(zip(found, description.rotors, strict=True)):
        axes = [rotor.R[:, 2], *(turn.axis for turn in turns)]
        if np.abs(np.triu([[one @ other for one in axes] for other in axes], 1)).max() > _ACROSS:
            return None
        own = [_side(there, rotor, index, turn, alone=len(turns) == 1) for turn in turns]
        along.append(_along(rotor, own) if own else rotor)
        sides += own
    fixed = replace(
        description,
        rotors=(*along, *sides),
        joints=tuple(_stiff(there, joint) for joint in description.joints),
        vectoring_joints=(),
        vectoring_servos=Servos(**{key: np.zeros(0) for key in vars(description.vectoring_servos)}),
        vectoring_start=np.zeros(0),
        preferred_thrusts=None,
    )
    joints = tuple(tuple(names.index(turn.name) for turn in turns) for turns in found)
    of = [description.joint(name) for name in names]
    low, high = (np.array([getattr(one, end) for one in of]) - start for end in ("lower", "upper"))
    return TurnedRotors(fixed, joints, there.vectoring_start, low, high)


class _Turn(NamedTuple):
    """A vectoring joint above a rotor: its name, its axis and a point of it in the rotor's link, m."""

    name: str
    axis: np.ndarray
    point: np.ndarray


def _turns(description: RobotDescription, rotor: Rotor) -> list[_Turn]:
    """The vectoring joints between a rotor and the next joint that bends, the outer one first."""
    above = {joint.child: joint for joint in description.joints}
    R, xyz, link = np.eye(3), np.zeros(3), rotor.link
    turns: list[_Turn] = []
    while link in above:
        joint = above[link]
        vectoring = joint.name in description.vectoring_joints
        if vectoring:
            turns.insert(0, _Turn(joint.name, R.T @ joint.axis, -R.T @ xyz))
        elif joint.kind != "fixed":
            break
        still = _stiff(description, joint)
        R, xyz, link = still.R @ R, still.xyz + still.R @ xyz, joint.parent
    return turns


def _side(description: RobotDescription, rotor: Rotor, index: int, turn: _Turn, *, alone: bool) -> Rotor:
    """What a joint gives of a rotor's thrust to the side."""
    number = description.vectoring_joints.index(turn.name)
    start, servos = description.vectoring_start[number], description.vectoring_servos
    joint, u = description.joint(turn.name), rotor.R[:, 2]
    travel = max(min(joint.upper - start, start - joint.lower), 0.0)
    most = min(SIDE, math.sin(min(travel, 0.5 * math.pi))) * rotor.thrust_max
    lag = max(float(servos.damping[number] / servos.stiffness[number]), 1e-3)
    return replace(
        rotor,
        name=f"{rotor.name}_side{'' if alone else f'_{turn.name}'}",
        xyz=rotor.xyz - ((rotor.xyz - turn.point) @ u) * u,
        R=np.column_stack([turn.axis, u, np.cross(turn.axis, u)]),
        thrust_min=-most,
        thrust_max=most,
        side=Side(index, lag),
        torque_max=math.inf,
        radius=None,
    )


def _along(rotor: Rotor, sides: list[Rotor]) -> Rotor:
    """What is left of a rotor along, whatever it gives to its sides."""
    most = math.sqrt(rotor.thrust_max**2 - sum(side.thrust_max**2 for side in sides))
    return replace(rotor, thrust_min=max(rotor.thrust_min, _LEAST * rotor.thrust_max), thrust_max=most)


def _stiff(description: RobotDescription, joint: Joint) -> Joint:
    """A vectoring joint that stays at its first angle."""
    if joint.name not in description.vectoring_joints:
        return joint
    angle = description.vectoring_start[description.vectoring_joints.index(joint.name)]
    return replace(joint, kind="fixed", R=joint.R @ rotation_from_axis_angle(joint.axis, float(angle)))
