"""A robot at a moment of a flight, as its scene has it: what its rotors do about the centre of gravity.

Its lean of that moment is taken back, so that leans count from the level whatever the flight did.
"""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation


class Stance(NamedTuple):
    """A robot at a moment, were it level; vectors in W.

    Attributes:
        columns: force (N) and torque about the centre of gravity (N m) of each rotor for 1 N, (6, n).
        low: least thrusts, N, (n,).
        high: greatest thrusts, N, (n,).
        weight: N.
        lever: from the centre of gravity to the tip, m, (3,).
        heading: of the hovering frame {C}, rad.
    """

    columns: np.ndarray
    low: np.ndarray
    high: np.ndarray
    weight: float
    lever: np.ndarray
    heading: float = 0.0


def stance_at(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    configuration: np.ndarray,
    attitude: np.ndarray,
    tip: np.ndarray,
    limits: np.ndarray,
) -> Stance | None:
    """The robot of a scene at a configuration; None where it has no rotors.

    Args:
        model: of the scene.
        data: of the model; it is written into.
        configuration: generalised positions, (nq,).
        attitude: roll, pitch and yaw of the hovering frame {C}, rad, (3,).
        tip: W, m, (3,).
        limits: least and greatest thrusts, N, (2, n).
    """
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    rotors = np.flatnonzero(model.actuator_trntype == mujoco.mjtTrn.mjTRN_SITE)
    if len(free) == 0 or len(rotors) == 0 or limits.shape != (2, len(rotors)):
        return None
    root = int(model.jnt_bodyid[free[0]])
    data.qpos[:] = configuration
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    cog, columns = data.subtree_com[root].copy(), []
    for actuator in rotors:
        site, gear = model.actuator_trnid[actuator, 0], model.actuator_gear[actuator]
        R = data.site_xmat[site].reshape(3, 3)
        force, drag = R @ gear[:3], R @ gear[3:]
        columns.append(np.concatenate([force, np.cross(data.site_xpos[site] - cog, force) + drag]))
    weight = float(model.body_subtreemass[root]) * float(-model.opt.gravity[2])
    roll, pitch, yaw = attitude
    level = (Rotation.from_euler("z", yaw) * Rotation.from_euler("ZYX", [yaw, pitch, roll]).inv()).as_matrix()
    wrenches = np.kron(np.eye(2), level) @ np.array(columns).T
    return Stance(wrenches, limits[0], limits[1], weight, level @ (tip - cog), float(attitude[2]))
