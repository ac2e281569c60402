"""Test rigs: a body with a ball before a surface, its touches, and a carriage that is read at every step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np

from skylimb.robots.description import Tip
from skylimb.simulation.contact import add_contact_sensor, set_contact_options
from skylimb.simulation.contact_keys import TIP_GEOM
from skylimb.simulation.surface_bodies import SurfaceParts, add_surface
from skylimb.simulation.surfaces.surface import Surface
from skylimb.simulation.tool import add_tool, tune_tool

RADIUS = 0.004  # m, of the tip
BODY = "body"
"""Of the body that carries the ball."""

_SERVO = 400.0  # N s/m of the carriage's speed servos
_TURN_SPRING, _TURN_DAMPER = 200.0, 10.0  # N m/rad and N m s/rad that hold a carriage with an arm
_GYRATION = 0.3  # m, its radius of gyration


def scene(
    surface: Surface,
    mass: float,
    inertia: float | Sequence[float],
    position: np.ndarray | Sequence[float],
    ball: np.ndarray | Sequence[float] = (0.0, 0.0, 0.0),
    radius: float = RADIUS,
    timestep: float = 1e-3,
) -> tuple[mujoco.MjSpec, mujoco.MjsBody, SurfaceParts]:
    """A scene without gravity: a surface, and a body with the tip's ball, which has no joint yet.

    Args:
        surface: what is touched.
        mass: of the body, kg.
        inertia: about its axes, kg m^2.
        position: of the body, which is its centre of mass, W, m.
        ball: place of the ball's middle in the body's axes, m.
        radius: of the ball, m.
        timestep: s.
    """
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    set_contact_options(spec, timestep)
    spec.option.gravity = [0.0, 0.0, 0.0]
    parts = add_surface(spec, surface)
    body = spec.worldbody.add_body(name=BODY, pos=position)
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = mass, np.broadcast_to(inertia, 3), [0.0, 0.0, 0.0]
    sphere = mujoco.mjtGeom.mjGEOM_SPHERE
    body.add_geom(name=TIP_GEOM, type=sphere, size=[radius, 0.0, 0.0], pos=ball, contype=0, conaffinity=0)
    return spec, body, parts


def released(
    spec: mujoco.MjSpec, surface: Surface, parts: SurfaceParts, **tool: Any
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A scene whose body has its joints, with the contact of its tool, ready to be stepped.

    Args:
        spec: of `scene`, as are `surface` and `parts`.
        surface: what is touched.
        parts: of the surface.
        tool: as `add_tool` takes it; nothing for the ball alone.
    """
    tip = Tip(BODY, np.zeros(3), 0.0)  # the front of a peg is at the body's origin
    add_tool(spec, tip, parts.geoms, surface.contact, **tool)
    model = spec.compile()
    tune_tool(model, surface.contact, foot="foot" in tool)
    return model, mujoco.MjData(model)


class Touch(NamedTuple):
    """One touch of a body.

    Attributes:
        force: on the body, W, N, (3,).
        point: where it acts, W, m, (3,).
        pressure: its part along the touch's normal, N.
        friction: magnitude of the rest, N.
    """

    force: np.ndarray
    point: np.ndarray
    pressure: float
    friction: float


def touches(model: mujoco.MjModel, data: mujoco.MjData, body: str = BODY) -> list[Touch]:
    """Everything that presses on a body now."""
    found, wrench, number = [], np.zeros(6), model.body(body).id
    for index in range(data.ncon):
        contact = data.contact[index]
        mujoco.mj_contactForce(model, data, index, wrench)
        if wrench[0] > 0.0:
            # The engine's force acts on the second geom.
            sign = 1.0 if model.geom_bodyid[contact.geom[1]] == number else -1.0
            force = sign * (contact.frame.reshape(3, 3).T @ wrench[:3])
            shear = float(np.linalg.norm(wrench[1:3]))
            found.append(Touch(force, contact.pos.copy(), float(wrench[0]), shear))
    return found


@dataclass(frozen=True)
class Trace:
    """What one stretch of time left: one row a physics step, as things stand at its beginning.

    Attributes:
        time: (n,) s.
        touching: (n,) whether tip and surface overlap.
        force: (n, 3) force on the tip along the surface's axes w, u, v, N.
        position: (n, 3) tip centre along these axes, m, from the surface's origin.
        velocity: (n, 3) of the tip along these axes, m/s.
    """

    time: np.ndarray
    touching: np.ndarray
    force: np.ndarray
    position: np.ndarray
    velocity: np.ndarray

    @property
    def pressing(self) -> np.ndarray:
        """(n,) force along -w, N: the normal force on a flat surface."""
        return -self.force[:, 0]

    @property
    def duty(self) -> float:
        """Fraction of the steps that touch."""
        return float(self.touching.mean())

    def after(self, time: float) -> Trace:
        """The rows from `time` (s) on, counted from the first one."""
        keep = self.time >= self.time[0] + time
        return Trace(*(getattr(self, name)[keep] for name in self.__dataclass_fields__))


class Bench:
    """A carriage on three slides along the surface's axes, with the tip on it.

    Args:
        surface: what is touched; the tip starts at the surface's origin, `gap` away from it.
        mass: of the carriage, kg.
        timestep: s.
        arm: m by which the tip stands before the carriage's centre, on a body that turns against a spring;
            0 for a tip that is the carriage, a block that cannot turn.
        gap: between the surface and the tip at the start, m; negative presses in.
        servos: which of the axes u and v follow a commanded speed.
    """

    def __init__(
        self,
        surface: Surface,
        mass: float = 2.0,
        timestep: float = 1e-3,
        arm: float = 0.0,
        gap: float = 0.0,
        servos: str = "",
    ) -> None:
        self.surface, self.mass = surface, mass
        start = surface.to_world(np.array([-RADIUS - gap - arm, 0.0, 0.0]))
        ball = surface.R_WS @ np.array([arm, 0.0, 0.0])
        spec, body, parts = scene(surface, mass, _GYRATION**2 * mass, start, ball, timestep=timestep)
        for name, axis in zip("wuv", surface.R_WS.T, strict=True):
            body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        if arm:
            body.add_joint(
                name="turn",
                type=mujoco.mjtJoint.mjJNT_BALL,
                stiffness=[_TURN_SPRING, 0.0, 0.0],
                damping=[_TURN_DAMPER, 0.0, 0.0],
            )
        body.add_site(name="tip", pos=ball)
        for name in "wuv":
            spec.add_actuator(name=f"push_{name}", trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        for name in servos:
            spec.add_actuator(
                name=f"speed_{name}",
                trntype=mujoco.mjtTrn.mjTRN_JOINT,
                target=name,
                gainprm=[_SERVO] + [0.0] * 9,
                biastype=mujoco.mjtBias.mjBIAS_AFFINE,
                biasprm=[0.0, 0.0, -_SERVO] + [0.0] * 7,
            )
        add_contact_sensor(spec, TIP_GEOM, parts.geoms[0], 1)
        for name, kind in _SENSORS:
            spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="tip")
        self.model, self.data = released(spec, surface, parts)
        self.slide = parts.joint

    def drive(self, **commands: float) -> None:
        """Set forces `push_w`, `push_u`, `push_v` (N) and speeds `speed_u`, `speed_v` (m/s); others stay."""
        for name, value in commands.items():
            self.data.actuator(name).ctrl = value

    def launch(self, **speeds: float) -> None:
        """Give the carriage speeds along `w`, `u` and `v`, m/s."""
        for name, value in speeds.items():
            self.data.joint(name).qvel = value

    def run(self, duration: float) -> Trace:
        """Advance by `duration`, s, and return every physics step."""
        steps = round(duration / self.model.opt.timestep)
        model, data = self.model, self.data
        rows, times = np.empty((steps, model.nsensordata)), np.empty(steps)
        for step in range(steps):
            times[step] = data.time
            mujoco.mj_step(model, data)
            rows[step] = data.sensordata
        if not np.isfinite(data.qpos).all() or any(warning.number for warning in data.warning):
            raise RuntimeError(f"the test bench diverged on surface '{self.surface.kind}' at {data.time:g} s")
        found, force, position, velocity = np.split(rows[:, _COLUMNS], [1, 4, 7], axis=1)
        R = self.surface.R_WS
        local = (position - np.asarray(self.surface.position)) @ R
        return Trace(times, found[:, 0] > 0.0, force @ R, local, velocity @ R)


_SENSORS = (
    ("place", mujoco.mjtSensor.mjSENS_FRAMEPOS),
    ("speed", mujoco.mjtSensor.mjSENS_FRAMELINVEL),
)
# The contact sensor gives found, force and position; the place of contact is not needed here.
_COLUMNS = [0, 1, 2, 3, 7, 8, 9, 10, 11, 12]
