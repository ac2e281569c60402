"""What a scene looks like: its visible shapes, and where each of its bodies is over time."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import mujoco
import numpy as np

_KINDS = {
    mujoco.mjtGeom.mjGEOM_PLANE: "plane",
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_MESH: "mesh",
}

_SHOWN_GROUPS = 3
"""Geoms of the groups 0 .. 2 are shown, as in the engine's own viewer."""


def shapes(model: mujoco.MjModel) -> list[dict[str, Any]]:
    """The visible geoms: kind, size (half lengths, as in the engine), colour, body, and place in it."""
    found = []
    for i in range(model.ngeom):
        kind = _KINDS.get(mujoco.mjtGeom(model.geom_type[i]))
        if kind is None or model.geom_group[i] >= _SHOWN_GROUPS or model.geom_rgba[i][3] == 0.0:
            continue
        shape: dict[str, Any] = {
            "kind": kind,
            "body": int(model.geom_bodyid[i]),
            "size": _digits(model.geom_size[i]),
            "position": _digits(model.geom_pos[i]),
            "quaternion": _digits(model.geom_quat[i]),
            "colour": _digits(model.geom_rgba[i], 3),
        }
        if kind == "mesh":
            shape["mesh"] = int(model.geom_dataid[i])
        found.append(shape)
    return found


def shapes_with_surface(
    model: mujoco.MjModel, position: np.ndarray, quaternion: np.ndarray
) -> list[dict[str, Any]]:
    """The shapes, where a surface that stands still is one more body behind the model's, which may be moved.

    The engine makes what stands still a part of the world.

    Args:
        model: of the scene.
        position: origin of the surface's axes in the scene, W, m, (3,).
        quaternion: their attitude, (4,).
    """
    back, place, turned = np.zeros(4), np.zeros(3), np.zeros(4)
    mujoco.mju_negQuat(back, quaternion)
    found = shapes(model)
    for shape in found:
        if shape["body"] == 0 and shape["kind"] != "plane":  # the floor is the one plane that is seen
            mujoco.mju_rotVecQuat(place, np.array(shape["position"]) - position, back)
            mujoco.mju_mulQuat(turned, back, np.array(shape["quaternion"]))
            shape |= {"body": model.nbody, "position": _digits(place), "quaternion": _digits(turned, 9)}
    return found


OUT_OF_SIGHT = 1000.0
"""Metres below the floor: where a surface that was taken away is shown."""


def meshes(model: mujoco.MjModel) -> list[dict[str, Any]]:
    """Vertices (float32, m) and triangles (uint32) of every mesh, deflated, base64."""
    found = []
    for i in range(model.nmesh):
        vertices = slice(model.mesh_vertadr[i], model.mesh_vertadr[i] + model.mesh_vertnum[i])
        faces = slice(model.mesh_faceadr[i], model.mesh_faceadr[i] + model.mesh_facenum[i])
        found.append(
            {
                "vertices": _bytes(model.mesh_vert[vertices].astype("<f4")),
                "faces": _bytes(model.mesh_face[faces].astype("<u4")),
            }
        )
    return found


def body_poses(model: mujoco.MjModel, configurations: np.ndarray) -> np.ndarray:
    """Where every body is: position (m) and unit quaternion (w, x, y, z) in W.

    Args:
        model: of the scene.
        configurations: generalised positions, (k, nq).

    Returns:
        Poses, (k, bodies, 7). A quaternion keeps its sign from sample to sample, so that one may interpolate.
    """
    data = mujoco.MjData(model)
    poses = np.empty((len(configurations), model.nbody, 7))
    for k, configuration in enumerate(configurations):
        data.qpos[:] = configuration
        mujoco.mj_kinematics(model, data)
        poses[k, :, :3], poses[k, :, 3:] = data.xpos, data.xquat
    turned = np.sum(poses[1:, :, 3:] * poses[:-1, :, 3:], axis=2) < 0.0
    flips = np.cumprod(np.where(turned, -1.0, 1.0), axis=0)
    poses[1:, :, 3:] *= flips[:, :, None]
    return poses


def thrust_sites(model: mujoco.MjModel) -> list[dict[str, Any]]:
    """Where each rotor pushes: body, place and direction (z of the site) in it, and its largest thrust, N."""
    found = []
    for i in range(model.nu):
        if model.actuator_trntype[i] != mujoco.mjtTrn.mjTRN_SITE:
            continue
        site = int(model.actuator_trnid[i, 0])
        R = np.zeros(9)
        mujoco.mju_quat2Mat(R, model.site_quat[site])
        found.append(
            {
                "body": int(model.site_bodyid[site]),
                "position": _digits(model.site_pos[site]),
                "direction": _digits(R.reshape(3, 3)[:, 2]),
                "most": float(model.actuator_ctrlrange[i, 1]),
            }
        )
    return found


def _digits(values: np.ndarray, digits: int = 6) -> list[float]:
    return [round(float(x), digits) for x in values]


def _bytes(values: np.ndarray) -> str:
    return base64.b64encode(zlib.compress(values.tobytes(), 9)).decode()
