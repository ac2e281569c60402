"""A test bench: a carriage with a tip before a surface, pressed and pulled, read at every step."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from skylimb.simulation.contact import (
    add_contact_pair,
    add_contact_sensor,
    set_contact_options,
    tune_contact_pair,
)
from skylimb.simulation.surface_bodies import add_surface
from skylimb.simulation.surfaces.surface import Surface

RADIUS = 0.004  # m, of the tip
_SERVO = 400.0  # N s/m of the carriage's speed servos
_TURN_SPRING, _TURN_DAMPER = 200.0, 10.0  # N m/rad and N m s/rad that hold a carriage with an arm
_GYRATION = 0.3  # m, its radius of gyration


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
        spec = mujoco.MjSpec()
        set_contact_options(spec, timestep)
        spec.option.gravity = [0.0, 0.0, 0.0]
        parts = add_surface(spec, surface)
        _add_carriage(spec, surface, mass, arm, gap)
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
        add_contact_pair(spec, "tip", parts.geom, surface.contact)
        add_contact_sensor(spec, "tip", parts.geom, 1)
        for name, kind in _SENSORS:
            spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="tip")
        self.model = spec.compile()
        tune_contact_pair(self.model, surface.contact)
        self.data = mujoco.MjData(self.model)
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
        self._check()
        found, force, position, velocity = np.split(rows[:, _COLUMNS], [1, 4, 7], axis=1)
        R = self.surface.R_WS
        local = (position - np.asarray(self.surface.position)) @ R
        return Trace(times, found[:, 0] > 0.0, force @ R, local, velocity @ R)

    def _check(self) -> None:
        data = self.data
        if not np.isfinite(data.qpos).all() or any(warning.number for warning in data.warning):
            raise RuntimeError(f"the test bench diverged on surface '{self.surface.kind}' at {data.time:g} s")


_SENSORS = (
    ("place", mujoco.mjtSensor.mjSENS_FRAMEPOS),
    ("speed", mujoco.mjtSensor.mjSENS_FRAMELINVEL),
)
# The contact sensor gives found, force and position; the place of contact is not needed here.
_COLUMNS = [0, 1, 2, 3, 7, 8, 9, 10, 11, 12]


def _add_carriage(spec: mujoco.MjSpec, surface: Surface, mass: float, arm: float, gap: float) -> None:
    start = surface.to_world(np.array([-RADIUS - gap - arm, 0.0, 0.0]))
    body = spec.worldbody.add_body(name="carriage", pos=start)
    for name, axis in zip("wuv", surface.R_WS.T, strict=True):
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    if arm:
        body.add_joint(
            name="turn",
            type=mujoco.mjtJoint.mjJNT_BALL,
            stiffness=[_TURN_SPRING, 0.0, 0.0],
            damping=[_TURN_DAMPER, 0.0, 0.0],
        )
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = mass, [_GYRATION**2 * mass] * 3, [0.0, 0.0, 0.0]
    at = surface.R_WS @ np.array([arm, 0.0, 0.0])
    body.add_geom(
        name="tip",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[RADIUS, 0.0, 0.0],
        pos=at,
        contype=0,
        conaffinity=0,
    )
    body.add_site(name="tip", pos=at)
