"""A robot description as bodies, joints, actuators and sites of a MuJoCo model specification."""

from __future__ import annotations

import mujoco
import numpy as np

from skylimb.base.rotations import quaternion_from_rotation
from skylimb.robots.description import RobotDescription
from skylimb.robots.links import Inertial, Joint, Link, Visual
from skylimb.simulation.contact_keys import TIP_GEOM, TIP_SITE
from skylimb.simulation.servo_friction import add_servo_friction

_GEOM = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "mesh": mujoco.mjtGeom.mjGEOM_MESH,
}


_ROUNDING = 1e-10
"""Of principal moments, over the largest."""


def add_robot(spec: mujoco.MjSpec, description: RobotDescription) -> None:
    """Add the robot as one free body tree, with its tip; nothing but the tip can touch anything.

    Link frames become body frames, so that every quantity of the description keeps its meaning. The root is
    free: a URDF's root fixed to the world would lose that link's mass.
    """
    bodies = {description.root: spec.worldbody.add_body(name=description.root)}
    bodies[description.root].add_freejoint(name="root")
    for joint in description.joints:
        body = bodies[joint.parent].add_body(
            name=joint.child, pos=joint.xyz, quat=quaternion_from_rotation(joint.R)
        )
        bodies[joint.child] = body
        if joint.kind != "fixed":
            _add_joint(body, joint)
    for link in description.links:
        _add_inertial(bodies[link.name], link.inertial)
        _add_visuals(spec, bodies[link.name], link)
    tip = bodies[description.tip.link]
    tip.add_geom(
        name=TIP_GEOM,
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[description.tip.radius, 0, 0],
        pos=description.tip.position,
        mass=0.0,
        contype=0,
        conaffinity=0,
        rgba=[0.8, 0.1, 0.1, 1.0],
    )
    tip.add_site(name=TIP_SITE, pos=description.tip.position, size=[1e-3, 0, 0], group=4)
    if description.tip.stem is not None:
        tip.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[*description.tip.stem, *description.tip.position],
            size=[description.tip.radius, 0, 0],
            mass=0.0,
            contype=0,
            conaffinity=0,
            rgba=[0.25, 0.25, 0.27, 1.0],
            group=1,
        )
    _add_actuators(spec, bodies, description)
    for joint in description.joints:
        if joint.kind != "fixed" and joint.friction > 0.0:
            add_servo_friction(spec, joint.name, joint.friction)


def _add_joint(body: mujoco.MjsBody, joint: Joint) -> None:
    limited = np.isfinite(joint.lower) and np.isfinite(joint.upper)
    body.add_joint(
        name=joint.name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=joint.axis,
        limited=limited,
        range=[joint.lower, joint.upper] if limited else [0.0, 0.0],
        damping=[joint.damping, 0.0, 0.0],
    )


def _add_inertial(body: mujoco.MjsBody, inertial: Inertial) -> None:
    body.explicitinertial = True
    body.mass = inertial.mass
    if inertial.mass == 0.0:  # a camera's or sensor's frame; the engine refuses an inertia of zeros
        return
    body.ipos = inertial.com
    inertia = _for_engine(inertial.inertia)
    body.fullinertia = [
        inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2],
    ]  # fmt: skip


def _for_engine(inertia: np.ndarray) -> np.ndarray:
    """An inertia (3, 3), kg m^2, whose principal moments A + B >= C hold in the engine's own arithmetic.

    A thin disc has A + B = C. Turned, a third of them fall short by rounding, and the engine refuses them.
    Such a one, and what `check_inertial` lets pass, gets all moments larger by what is lacking.
    """
    moments = np.linalg.eigvalsh(inertia)
    lacking, rounding = moments[2] - moments[0] - moments[1], _ROUNDING * moments[2]
    turned = bool(np.any(inertia != np.diag(np.diag(inertia))))
    if lacking <= (-rounding if turned else 0.0):
        return inertia
    return inertia + (lacking + 2.0 * rounding) * np.eye(3)


def _add_visuals(spec: mujoco.MjSpec, body: mujoco.MjsBody, link: Link) -> None:
    for index, visual in enumerate(link.visuals):
        add_shape(spec, body, visual, f"{link.name}_{index}")


def add_shape(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: Visual, name: str, *, collides: bool = False
) -> None:
    """Add a weightless shape to a body; `name` is for its mesh."""
    size, mesh = _geom_size(spec, shape, name)
    body.add_geom(
        type=_GEOM[shape.shape],
        size=size,
        meshname=mesh,
        pos=shape.xyz,
        quat=quaternion_from_rotation(shape.R),
        rgba=shape.rgba,
        contype=int(collides),
        conaffinity=int(collides),
        mass=0.0,
        group=3 if collides else 1,
    )


def _geom_size(spec: mujoco.MjSpec, visual: Visual, name: str) -> tuple[list[float], str]:
    match visual.shape:
        case "box":
            return [0.5 * edge for edge in visual.size], ""
        case "cylinder":
            return [visual.size[0], 0.5 * visual.size[1], 0.0], ""
        case "sphere":
            return [visual.size[0], 0.0, 0.0], ""
        case "mesh":
            spec.add_mesh(name=name, file=str(visual.mesh), scale=np.broadcast_to(visual.size, 3))
            return [0.0, 0.0, 0.0], name


def _add_actuators(
    spec: mujoco.MjSpec, bodies: dict[str, mujoco.MjsBody], description: RobotDescription
) -> None:
    """Actuators in the order thrusts, shape joints, vectoring joints; each has one activation.

    A rotor's activation is its thrust, which follows the command with a first-order lag, exactly integrated.
    A servo's activation is its set point, which its control drives at a rate: the ramp inside a control tick
    is smooth at any control rate, and the speed limit is the rate's.
    """
    for rotor in description.rotors:
        site = f"thrust_{rotor.name}"
        bodies[rotor.link].add_site(
            name=site, pos=rotor.xyz, quat=quaternion_from_rotation(rotor.R), size=[1e-3, 0, 0], group=4
        )
        spec.add_actuator(
            name=rotor.name,
            trntype=mujoco.mjtTrn.mjTRN_SITE,
            target=site,
            # eq:allocation for torque: the drag torque acts along the thrust.
            gear=[0.0, 0.0, 1.0, 0.0, 0.0, rotor.drag_torque_coefficient],
            dyntype=mujoco.mjtDyn.mjDYN_FILTEREXACT,
            dynprm=[rotor.lag] + [0.0] * 9,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            gainprm=[1.0] + [0.0] * 9,
            ctrllimited=True,
            ctrlrange=[0.0, rotor.thrust_max],
        )
    servos = description.servos
    for name, *numbers in zip(
        description.moving_joints,
        servos.stiffness,
        servos.damping,
        servos.torque_limit,
        servos.speed_limit,
        strict=True,
    ):
        _add_servo(spec, name, *map(float, numbers))


def _add_servo(
    spec: mujoco.MjSpec, joint: str, stiffness: float, damping: float, torque: float, speed: float
) -> None:
    spec.add_actuator(
        name=joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=joint,
        dyntype=mujoco.mjtDyn.mjDYN_INTEGRATOR,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=[stiffness] + [0.0] * 9,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=[0.0, -stiffness, -damping] + [0.0] * 7,
        ctrllimited=True,
        ctrlrange=[-speed, speed],
        forcelimited=True,
        forcerange=[-torque, torque],
    )
