"""What rotors, weight and a push at the tip do to a robot's body and to its joints, by posture."""

from __future__ import annotations

import functools
from typing import NamedTuple

import casadi as ca

from skylimb.base.rotations import vee
from skylimb.robots.model import Robot


@functools.lru_cache(maxsize=16)
def loads_function(robot: Robot) -> ca.Function:
    """(q, psi) -> C, V, J_c, J_r and r of `skylimb.base.statics`, root axes; the heading, rad.

    Joints are those of the shape, then those of the vectoring.
    """
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    state, joints, tip = robot.model(q, psi), ca.vertcat(q, psi), robot.description.tip
    lines = thrust_lines(robot, q, psi, joints)
    columns = [
        ca.vertcat(line.axis, ca.cross(line.point - state.cog_root, line.axis) + line.drag) for line in lines
    ]
    place = robot.link_pose_function(tip.link)(q, psi)
    outputs = [
        ca.horzcat(*columns),
        ca.horzcat(*(line.load for line in lines)),
        state.cog_jacobian,
        ca.jacobian(place[:, 0] + place[:, 1:] @ ca.SX(tip.position), joints),
        state.tip_root - state.cog_root,
        state.tip_heading,
    ]
    return ca.Function("loads", [q, psi], outputs, {"cse": True})


class ThrustLine(NamedTuple):
    """A rotor's thrust in root axes, for 1 N.

    Attributes:
        axis: direction u.
        point: p where it acts, m.
        drag: torque kappa u about it, m.
        load: torque on each of some joints, m: by virtual work u . dp/dq_j + kappa u . w_j, with w_j the turn
            of the rotor for a radian of the joint.
    """

    axis: ca.SX
    point: ca.SX
    drag: ca.SX
    load: ca.SX


def thrust_lines(robot: Robot, q: ca.SX, psi: ca.SX, joints: ca.SX) -> list[ThrustLine]:
    """One a rotor, with the torques on some of the joints."""
    rotors, lines = robot.description.rotors, []
    poses = robot.link_pose_function(*(rotor.link for rotor in rotors)).call([q, psi])
    for rotor, pose in zip(rotors, poses, strict=True):
        R = pose[:, 1:] @ ca.SX(rotor.R)
        p = pose[:, 0] + pose[:, 1:] @ ca.SX(rotor.xyz)
        drag = rotor.drag_torque_coefficient * R[:, 2]
        moved = ca.jacobian(p, joints).T @ R[:, 2]
        slopes = ca.jacobian(ca.vec(R), joints)
        turned = [ca.dot(drag, vee(ca.reshape(slopes[:, j], 3, 3) @ R.T)) for j in range(joints.numel())]
        lines.append(ThrustLine(R[:, 2], p, drag, moved + ca.vertcat(*turned)))
    return lines
