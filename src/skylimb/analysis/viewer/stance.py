"""A robot at a moment of a flight, as its scene has it: what its rotors do to its body and its servos.

Vectors are in the body's axes, so that leans count from upright whatever the flight did.
"""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np


class Stance(NamedTuple):
    """A robot at a moment, in the axes of the link whose tilt is measured.

    Attributes:
        columns: force (N) and torque about the centre of gravity (N m) of each rotor for 1 N, (6, n).
        low: least thrusts, N, (n,).
        high: greatest thrusts, N, (n,).
        weight: N.
        lever: from the centre of gravity to the tip, m, (3,).
        heading: of these axes, once they are upright, rad.
        loads: torque on each servo for 1 N of each rotor, m, (k, n).
        cog_jacobian: of the centre of gravity by the servos' joints, m/rad, (3, k).
        tip_jacobian: of the tip, (3, k).
        torques: what each servo can give, N m, (k,).
    """

    columns: np.ndarray
    low: np.ndarray
    high: np.ndarray
    weight: float
    lever: np.ndarray
    heading: float
    loads: np.ndarray
    cog_jacobian: np.ndarray
    tip_jacobian: np.ndarray
    torques: np.ndarray


def stance_at(
    model: mujoco.MjModel, data: mujoco.MjData, configuration: np.ndarray, limits: np.ndarray
) -> Stance | None:
    """The robot of a scene at a configuration; None where it has no rotors, or no tip.

    Args:
        model: of the scene.
        data: of the model; it is written into.
        configuration: generalised positions, (nq,).
        limits: least and greatest thrusts, N, (2, n).
    """
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    rotors = np.flatnonzero(model.actuator_trntype == mujoco.mjtTrn.mjTRN_SITE)
    touching = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "tip")
    if len(free) == 0 or len(rotors) == 0 or touching < 0 or limits.shape != (2, len(rotors)):
        return None
    root = int(model.jnt_bodyid[free[0]])
    data.qpos[:] = configuration
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    cog, turn = data.subtree_com[root].copy(), data.xmat[root].reshape(3, 3).T
    # Servos have a stiffness; what else acts on joints is their friction.
    servos = np.flatnonzero(model.actuator_biasprm[:, 1] < 0.0)
    joints = model.jnt_dofadr[model.actuator_trnid[servos, 0]]
    moved, turned = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    columns, loads = [], []
    for actuator in rotors:
        site, gear = model.actuator_trnid[actuator, 0], model.actuator_gear[actuator]
        R = data.site_xmat[site].reshape(3, 3)
        force, drag = R @ gear[:3], R @ gear[3:]
        columns.append(np.concatenate([force, np.cross(data.site_xpos[site] - cog, force) + drag]))
        mujoco.mj_jacSite(model, data, moved, turned, site)
        loads.append(moved[:, joints].T @ force + turned[:, joints].T @ drag)
    cog_jacobian, tip = np.zeros((3, model.nv)), data.site_xpos[touching]
    mujoco.mj_jacSite(model, data, moved, None, touching)
    mujoco.mj_jacSubtreeCom(model, data, cog_jacobian, root)
    return Stance(
        np.kron(np.eye(2), turn) @ np.array(columns).T,
        limits[0],
        limits[1],
        float(model.body_subtreemass[root]) * float(-model.opt.gravity[2]),
        turn @ (tip - cog),
        float(np.arctan2(turn[0, 1], turn[0, 0])),
        np.array(loads).T,
        turn @ cog_jacobian[:, joints],
        turn @ moved[:, joints],
        model.actuator_forcerange[servos, 1],
    )
