"""Rotors on arms that turn, as fixed ones: how robots of two and three rotors are flown.

Two or three thrusts leave lift or a torque out; where their arms turn, angles make up for it. The thrust T of
a rotor whose axis u turns about a by an angle d from its first place is

    T u(d) = T cos(d) u(0) + T sin(d) (a x u(0)),

so its wrench is linear in two numbers, T cos(d) and T sin(d), drag included. A pair of fixed rotors gives the
same: one along u(0), one to the side. Laws and supervisor fly the robot of such pairs, which has four rotors
and more and no vectoring joint, and every pair becomes a thrust and an angle where a command leaves them
(`skylimb.control.thrust_and_angle`).

The side rotor stands where the joint's axis meets the plane across u(0), so the torque is exact for a rotor
whose thrust goes through the axis; one that goes by at a distance e is off by e T (1 - cos(d)). Mass and
inertia are those of the first angles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from skylimb.base.rotations import rotation_from_axis_angle
from skylimb.robots.description import RobotDescription, Rotor, Servos, Side
from skylimb.robots.links import Fixed, Joint
from skylimb.symbolic import Array, arctan2, clip, cos, sin, stack

ENOUGH = 4
"""Rotors that can give lift and three torques by their thrusts."""

SIDE = 0.4
"""Share of its greatest thrust that a rotor gives to the side; the rest of it is for what is along."""

_LEAST = 0.01
"""Share of the greatest thrust that a turned rotor keeps: without thrust it has no direction."""

_ACROSS = 1e-3
"""Cosine between joint and thrust from which on the joint does not turn the thrust across itself."""


@dataclass(frozen=True, eq=False)
class TurnedRotors(Fixed):
    """The robot of pairs, and what a pair stands for.

    Attributes:
        description: with fixed rotors: the robot's own, then one to the side for each that turns.
        joints: vectoring joint that turns each of the robot's rotors, by number; -1 where none does, (n,).
        start: vectoring angles from which a pair counts, rad, (nv,).
        low: least angle of each joint from there, rad, (nv,).
        high: greatest angle of each joint from there, rad, (nv,).
    """

    description: RobotDescription
    joints: tuple[int, ...]
    start: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def pairs(self, thrusts: Array, angles: Array) -> Array:
        """Thrusts of the pairs, N: those along, then those to the side.

        Args:
            thrusts: of the robot, N, (n,).
            angles: of its vectoring joints, rad, (nv,).
        """
        along, sides = [], []
        for index, joint in enumerate(self.joints):
            turn = angles[joint] - self.start[joint] if joint >= 0 else 0.0
            along.append(thrusts[index] * cos(turn))
            if joint >= 0:
                sides.append(thrusts[index] * sin(turn))
        return stack(*along, *sides)

    def command(self, pairs: Array) -> tuple[Array, Array]:
        """Thrusts of the robot, N, (n,), and vectoring angles, rad, (nv,), of thrusts of the pairs, N.

        Where a joint's limit is nearer than the angle of a pair, the thrust is what lies along the rotor.
        """
        thrusts, angles, count = [], {}, len(self.joints)
        for index, joint in enumerate(self.joints):
            along = pairs[index]
            if joint < 0:
                thrusts.append(along)
                continue
            side = pairs[count + len(angles)]
            turn = clip(arctan2(side, along), self.low[joint], self.high[joint])
            thrusts.append(along * cos(turn) + side * sin(turn))
            angles[joint] = self.start[joint] + turn
        return stack(*thrusts), stack(*(angles[joint] for joint in sorted(angles)))


def turned_rotors(description: RobotDescription) -> TurnedRotors | None:
    """The robot of pairs; None for enough rotors, and where joints do not turn one rotor each, across it."""
    if len(description.rotors) >= ENOUGH or not description.vectoring_joints:
        return None
    found = [_joint_of(description, rotor) for rotor in description.rotors]
    turning = [name for name, _, _ in found if name]
    if sorted(turning) != sorted(description.vectoring_joints):
        return None
    start = description.vectoring_start
    along, sides = [], []
    for index, ((name, R, xyz), rotor) in enumerate(zip(found, description.rotors, strict=True)):
        if not name:
            along.append(rotor)
            continue
        number = description.vectoring_joints.index(name)
        joint = description.joint(name)
        u, at = R @ rotor.R[:, 2], xyz + R @ rotor.xyz
        if abs(float(u @ joint.axis)) > _ACROSS:
            return None
        side = min(SIDE, math.sin(min(_travel(joint, start[number]), 0.5 * math.pi))) * rotor.thrust_max
        most = math.sqrt(rotor.thrust_max**2 - side**2)
        along.append(
            replace(rotor, thrust_min=max(rotor.thrust_min, _LEAST * rotor.thrust_max), thrust_max=most)
        )
        sides.append(
            replace(
                rotor,
                name=f"{rotor.name}_side",
                xyz=R.T @ (at - (at @ u) * u - xyz),
                R=R.T @ np.column_stack([joint.axis, u, np.cross(joint.axis, u)]),
                thrust_min=-side,
                thrust_max=side,
                side=Side(index, _servo_lag(description.vectoring_servos, number)),
                torque_max=math.inf,
                radius=None,
            )
        )
    fixed = replace(
        description,
        rotors=(*along, *sides),
        joints=tuple(_stiff(description, joint) for joint in description.joints),
        vectoring_joints=(),
        vectoring_servos=_none(description.vectoring_servos),
        vectoring_start=np.zeros(0),
        preferred_thrusts=None,
    )
    joints = tuple(description.vectoring_joints.index(name) if name else -1 for name, _, _ in found)
    of = [description.joint(name) for name in description.vectoring_joints]
    low, high = (np.array([getattr(one, end) for one in of]) - start for end in ("lower", "upper"))
    return TurnedRotors(fixed, joints, start, low, high)


def _joint_of(description: RobotDescription, rotor: Rotor) -> tuple[str, np.ndarray, np.ndarray]:
    """The vectoring joint that turns a rotor, and the pose of the rotor's link in the joint's child link.

    The name is empty where no vectoring joint is between the rotor and the next joint that bends.
    """
    above = {joint.child: joint for joint in description.joints}
    R, xyz, link = np.eye(3), np.zeros(3), rotor.link
    while link in above:
        joint = above[link]
        if joint.name in description.vectoring_joints:
            return joint.name, R, xyz
        if joint.kind != "fixed":
            break
        R, xyz, link = joint.R @ R, joint.xyz + joint.R @ xyz, joint.parent
    return "", R, xyz


def _travel(joint: Joint, start: float) -> float:
    """How far a joint turns to the nearer side, rad."""
    return max(min(joint.upper - start, start - joint.lower), 0.0)


def _stiff(description: RobotDescription, joint: Joint) -> Joint:
    """A vectoring joint that stays at its first angle."""
    if joint.name not in description.vectoring_joints:
        return joint
    angle = description.vectoring_start[description.vectoring_joints.index(joint.name)]
    return replace(joint, kind="fixed", R=joint.R @ rotation_from_axis_angle(joint.axis, float(angle)))


def _servo_lag(servos: Servos, number: int) -> float:
    return max(float(servos.damping[number] / servos.stiffness[number]), 1e-3)


def _none(servos: Servos) -> Servos:
    return replace(servos, **{key: np.zeros(0) for key in vars(servos)})
