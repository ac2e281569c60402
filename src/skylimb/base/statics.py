"""A robot at rest on its rotors while its tip pushes: what has to balance, for numbers and for symbols.

With thrusts lambda, the turn R of the body from upright, up = R^T z and the push p of the tip on the surface,

    C lambda = (m g up + R^T p,  r x R^T p),        tau = V lambda - m g J_c^T up - J_r^T R^T p,

in the body's axes: C is force and torque about the centre of gravity for a newton of each rotor, V the torque
on each joint for the same, r the tip from the centre of gravity, J_c and J_r how centre of gravity and tip
move with the joints. tau is what the servos have to hold; all forces balance, so the body may be held for it.
The body leans by roll and pitch with its yaw held, R = R_y(pitch) R_x(roll), as a flight holds its heading.
"""

from __future__ import annotations

import functools
from typing import Any

import casadi as ca


@functools.lru_cache(maxsize=32)
def rest_function(rotors: int, joints: int) -> ca.Function:
    """What is left over of force and torque, (6,), N and N m, and the torque on each joint, N m, (joints,).

    Its arguments are C (6, rotors), V (joints, rotors), J_c and J_r (3, joints), r (3,), m g, the lean (2,),
    the thrusts (rotors,), and p (3,) in the level axes that have the body's yaw. The lean is roll and pitch,
    rad.
    """
    C, V, r = ca.SX.sym("C", 6, rotors), ca.SX.sym("V", joints, rotors), ca.SX.sym("r", 3)
    J_c, J_r, weight = ca.SX.sym("J_c", 3, joints), ca.SX.sym("J_r", 3, joints), ca.SX.sym("weight")
    lean, thrusts, push = ca.SX.sym("lean", 2), ca.SX.sym("thrusts", rotors), ca.SX.sym("push", 3)
    up, pushed = turned_back(lean, ca.DM([0.0, 0.0, 1.0])), turned_back(lean, push)
    wrench = ca.vertcat(weight * up + pushed, ca.cross(r, pushed))
    torques = V @ thrusts - weight * (J_c.T @ up) - J_r.T @ pushed
    given = [C, V, J_c, J_r, r, weight, lean, thrusts, push]
    return ca.Function("rest", given, [C @ thrusts - wrench, torques])


def turned_back(lean: ca.SX, vector: Any) -> ca.SX:
    """R^T of a vector (3,)."""
    (sin_r, sin_p), (cos_r, cos_p) = ca.vertsplit(ca.sin(lean)), ca.vertsplit(ca.cos(lean))
    level = sin_p * vector[0] + cos_p * vector[2]
    return ca.vertcat(
        cos_p * vector[0] - sin_p * vector[2],
        cos_r * vector[1] + sin_r * level,
        cos_r * level - sin_r * vector[1],
    )
