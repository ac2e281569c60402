"""What rotors, weight and a push at the tip do to a robot's body and to its joints, by posture."""

from __future__ import annotations

import functools

import casadi as ca

from skylimb.robots.model import Robot


@functools.lru_cache(maxsize=16)
def loads_function(robot: Robot) -> ca.Function:
    """(q, psi) -> C, V, J_c, J_r and r of `skylimb.statics`, in root axes, and the tip link's heading, rad.

    Joints are those of the shape, then those of the vectoring. By virtual work the torque of a thrust along u
    at p on joint j is u . dp/dq_j + kappa u . w_j, with w_j the turn of the rotor for a radian of the joint.
    """
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    state, joints, tip = robot.model(q, psi), ca.vertcat(q, psi), robot.description.tip
    place = robot.link_pose_function(tip.link)(q, psi)
    J_r = ca.jacobian(place[:, 0] + place[:, 1:] @ ca.SX(tip.position), joints)
    outputs = [
        robot.wrench_function(q, psi),
        ca.horzcat(*thrust_loads(robot, q, psi, joints)),
        state.cog_jacobian,
        J_r,
        state.tip_root - state.cog_root,
        state.tip_heading,
    ]
    return ca.Function("loads", [q, psi], outputs, {"cse": True})


def thrust_loads(robot: Robot, q: ca.SX, psi: ca.SX, joints: ca.SX) -> list[ca.SX]:
    """Torque on each of some joints for a newton of each rotor, m: a column (k,) a rotor."""
    columns = []
    for rotor in robot.description.rotors:
        pose = robot.link_pose_function(rotor.link)(q, psi)
        R = pose[:, 1:] @ ca.SX(rotor.R)
        p = pose[:, 0] + pose[:, 1:] @ ca.SX(rotor.xyz)
        drag = rotor.drag_torque_coefficient * R[:, 2]
        moved = ca.jacobian(p, joints).T @ R[:, 2]
        slopes = ca.jacobian(ca.vec(R), joints)
        turned = [ca.dot(drag, _turn(R, ca.reshape(slopes[:, j], 3, 3))) for j in range(joints.numel())]
        columns.append(moved + ca.vertcat(*turned))
    return columns


def _turn(R: ca.SX, slope: ca.SX) -> ca.SX:
    """Angular velocity, (3,), of a rotation R that changes by `slope`."""
    W = slope @ R.T
    return ca.vertcat(W[2, 1], W[0, 2], W[1, 0])
