"""The scene that the engine compiles: robot, surface, contact, and what is only looked at."""

from __future__ import annotations

import mujoco

from skylimb.robots.description import RobotDescription
from skylimb.simulation.contact import add_contact_sensor, set_contact_options
from skylimb.simulation.plant_config import Peg
from skylimb.simulation.robot_bodies import TIP_GEOM, add_robot
from skylimb.simulation.surface_bodies import SurfaceParts, add_surface
from skylimb.simulation.surfaces import Surface
from skylimb.simulation.tool import add_tool

USER_WORDS = 2
"""Numbers in `data.userdata` that a driver may use."""


def scene_spec(
    description: RobotDescription,
    surface: Surface,
    physics_step: float,
    substeps: int,
    foot: float | None = None,
    peg: Peg | None = None,
) -> tuple[mujoco.MjSpec, SurfaceParts]:
    """Robot, surface and contact, ready to be compiled.

    Args:
        description: of the robot that really flies.
        surface: what it touches.
        physics_step: s.
        substeps: physics steps in a control tick.
        foot: half the side of a foot at the tip, m; none for the tip's ball alone.
        peg: radius and length of a peg at the tip, m.

    Returns:
        The scene, and what the surface added to it.
    """
    spec = mujoco.MjSpec()
    spec.modelname = description.name
    spec.compiler.degree = False
    set_contact_options(spec, physics_step)
    # Where the native driver finds what belongs to a flight; zero means that nothing does.
    spec.nuserdata = USER_WORDS
    # Batteries, computers and the pen become part of the links that carry them: half the bodies, the same
    # mechanics.
    spec.compiler.fusestatic = True
    spec.option.gravity = [0.0, 0.0, -description.gravity]
    _add_surroundings(spec)
    add_robot(spec, description)
    parts = add_surface(spec, surface)
    if parts.joint is None:
        # One robot is one island: looking for more takes a fourteenth of a step, and changes no bit.
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
    add_tool(spec, description.tip, parts.geoms, surface.contact, foot=foot, peg=peg)
    touched = parts.geoms[0] if peg is None else None
    add_contact_sensor(spec, TIP_GEOM, touched, substeps, whole_body=(foot, peg) != (None, None))
    return spec, parts


def _add_surroundings(spec: mujoco.MjSpec) -> None:
    """Light, sky and a floor that nothing touches."""
    visual = spec.visual
    visual.global_.offwidth, visual.global_.offheight = 1920, 1080
    visual.headlight.ambient = [0.45, 0.45, 0.45]
    visual.headlight.diffuse = [0.45, 0.45, 0.45]
    visual.headlight.specular = [0.1, 0.1, 0.1]
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.97],
        rgb2=[0.75, 0.82, 0.88],
        width=256,
        height=256,
    )
    spec.add_texture(
        name="floor",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.86, 0.87, 0.88],
        rgb2=[0.80, 0.81, 0.83],
        width=256,
        height=256,
    )
    material = spec.add_material(name="floor", texrepeat=[8.0, 8.0], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[8.0, 8.0, 0.1],
        material="floor",
        contype=0,
        conaffinity=0,
    )
    spec.worldbody.add_light(pos=[-1.0, -2.0, 5.0], dir=[0.3, 0.4, -1.0], diffuse=[0.5, 0.5, 0.5])
