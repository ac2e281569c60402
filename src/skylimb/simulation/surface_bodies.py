"""A surface as a body, geoms and joints of a MuJoCo model specification."""

from __future__ import annotations

import ctypes
import threading
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.rotations import quaternion_from_rotation
from skylimb.simulation.compiling import engine_library
from skylimb.simulation.surfaces import Surface
from skylimb.simulation.surfaces.geom import BODY, JOINT, Geom, Hinge, Shaped

HINGE = "surface_hinge"
LEVER = "surface_lever"
_SHEET = "surface_sheet"
_NUMERIC = "surface_shape"
_SLIDE_MASS = 1e4  # kg: heavy enough that a pen does not push the surface between two writes of its state
_VIEW = 3.5  # m, the scene that a viewer should frame
_STICK = (0.9999, 0.9999, 1e-3, 0.5, 2.0)
"""Impedance of a hinge's dry friction: by default it creeps under any push."""

_COUNT = int(mujoco.mjtGeom.mjNGEOMTYPES)
SLOT = int(mujoco.mjtGeom.mjGEOM_SPHERE) * _COUNT + int(mujoco.mjtGeom.mjGEOM_ELLIPSOID)
"""Place of the function of a sphere and an ellipsoid in the engine's collision table."""

_SEEN, _TOUCHED = 1, 4
"""Groups of geoms: what a viewer shows, and what it does not."""

_KINDS = {
    "plane": mujoco.mjtGeom.mjGEOM_PLANE,
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "mesh": mujoco.mjtGeom.mjGEOM_MESH,
}


@dataclass(frozen=True)
class SurfaceParts:
    """Names that a surface has in the physics model.

    Attributes:
        joint: the slide of a moving surface, or None. The loop writes `Surface.motion` into its qpos and
            qvel.
        hinge: the hinge of a part that the engine turns, or None.
        geoms: all that is touched; a ball touches the first.
    """

    joint: str | None
    hinge: str | None
    geoms: tuple[str, ...]


def add_surface(spec: mujoco.MjSpec, surface: Surface) -> SurfaceParts:
    """Write a surface into a model: a body with the geoms to collide with, on a slide when it moves.

    Raises:
        ConfigError: when the model has a shape with contact code of its own already.
    """
    body = spec.worldbody.add_body(
        name=BODY, pos=surface.position, quat=quaternion_from_rotation(surface.R_WS)
    )
    if surface.moves:
        axis = surface.R_WS.T @ surface.motion_axis
        body.add_joint(name=JOINT, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        _weigh(body, _SLIDE_MASS, _SLIDE_MASS)
    turning = None if surface.hinge is None else _add_lever(body, surface.hinge)
    for geom in surface.geoms:
        _add_geom(spec, turning if geom.turns and turning is not None else body, geom)
    # Collision geometry without end must not set the scale of what is looked at.
    spec.stat.extent, spec.stat.center = _VIEW, surface.position
    touched = tuple(geom.name for geom in surface.geoms if geom.name)
    return SurfaceParts(JOINT if surface.moves else None, None if turning is None else HINGE, touched)


def _weigh(body: mujoco.MjsBody, mass: float, inertia: float) -> None:
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = mass, [inertia] * 3, [0.0, 0.0, 0.0]
    body.gravcomp = 1.0


def _add_lever(body: mujoco.MjsBody, hinge: Hinge) -> mujoco.MjsBody:
    lever = body.add_body(name=LEVER, quat=hinge.quaternion)
    lever.add_joint(
        name=HINGE,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=[1.0, 0.0, 0.0],
        limited=True,
        range=[0.0, hinge.travel],
        damping=[hinge.damping, 0.0, 0.0],
        frictionloss=hinge.friction,
        solimp_friction=_STICK,
    )
    _weigh(lever, hinge.mass, hinge.inertia)
    return lever


def _add_geom(spec: mujoco.MjSpec, body: mujoco.MjsBody, geom: Geom) -> None:
    more: dict[str, Any] = {} if geom.quaternion is None else {"quat": geom.quaternion}
    if geom.name:
        more["name"] = geom.name
    if geom.sheet is not None:
        vertices, faces = geom.sheet
        shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        spec.add_mesh(name=_SHEET, uservert=vertices.ravel(), userface=faces.ravel(), inertia=shell)
        more["meshname"] = _SHEET
    if geom.shaped is not None:
        more["userdata"] = [_add_shape(spec, geom.shaped)]
    body.add_geom(
        type=_KINDS[geom.kind],
        size=geom.size,
        pos=geom.position,
        rgba=geom.color or (0.0, 0.0, 0.0, 0.0),
        group=_SEEN if geom.color else _TOUCHED,
        contype=0,
        conaffinity=0,
        mass=0.0,
        **more,
    )


def _add_shape(spec: mujoco.MjSpec, shaped: Shaped) -> float:
    """Put the contact code of a shape into the engine and its numbers into the model; its mark."""
    if any(numeric.name == _NUMERIC for numeric in spec.numerics):
        raise ConfigError("a scene can hold one curved surface: it has one already")
    install(shaped.library)
    spec.add_numeric(name=_NUMERIC, data=np.concatenate([[shaped.mark], shaped.numbers]))
    return shaped.mark


def collision_table() -> ctypes.Array[ctypes.c_void_p]:
    """The engine's collision functions, by the kinds of two geoms."""
    kind = ctypes.c_void_p * (_COUNT * _COUNT)
    return kind.in_dll(ctypes.CDLL(str(engine_library())), "mjCOLLISIONFUNC")


def install(library: ctypes.CDLL) -> None:
    """Put the contact code of a kind of shape into the engine's table of this process; once is enough."""
    with _lock:
        library.skylimb_install(ctypes.byref(collision_table(), SLOT * ctypes.sizeof(ctypes.c_void_p)))


_lock = threading.Lock()
