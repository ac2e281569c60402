"""The attitude that points the rotors' force where it is wanted, eq:target roll and pitch angle."""

from __future__ import annotations

from typing import Any

from skylimb.base.rotations import rot_z, rotation_from_rpy
from skylimb.symbolic import Array, arctan2, vector


def attitude_target(force: Array, yaw: Any, yaw_reference: Any) -> tuple[Array, Array]:
    """Target roll and pitch from the wanted force, and R_C,ref = Rz Ry Rx.

    eq:imp cmd for trans turns the force into the frame of the present heading; the paper's atan^-1(a, b) is
    atan2(a, b).

    Args:
        force: f_cmd in W, N.
        yaw: heading of C now, rad.
        yaw_reference: heading of C wanted, rad.

    Returns:
        Target (roll, pitch, yaw), rad, and the rotation R_W,Cref.
    """
    f = rot_z(yaw).T @ force
    roll = arctan2(-f[1], (f[0] * f[0] + f[2] * f[2]) ** 0.5)
    pitch = arctan2(f[0], f[2])
    return vector(roll, pitch, yaw_reference), rotation_from_rpy(roll, pitch, yaw_reference)
