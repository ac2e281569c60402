"""One sliding contact in physical units, and its force read over every physics step.

Stiffness is in N/m, damping in N s/m, and Coulomb friction neither creeps nor chatters. The engine's
contact is a spring and a damper behind an impedance d in (0, 1): f = d / ((1 - d) A) (K delta + B delta'),
with A the inverse effective mass; handed over with a minus sign, `solref` is (-K d, -B d). So f = k delta +
c delta' needs -k (1 - d) A and -c (1 - d) A.

Friction shares the normal direction's damper unless it is given its own, and on a convex cone a friction
damper of c_f N s/m adds mu c_f v of normal force to a tip that slides at v: enough, with the stiff default,
to throw a pen that presses with 1 N off a flat plate. Hence a separate, weak friction damper
(`friction_rate`), at the smallest impedance, and a large ratio of friction to normal impedance
(`impratio`), which keeps the creep in stick at F_t / `stick_damping`. `solreffriction` exists only on an
explicit geom pair, so the pair is explicit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.simulation.contact_keys import PAIR_NAME, ContactParameters
from skylimb.symbolic import Array, dot, vector, where

SENSOR_NAME = "tip_surface_force"
IMPEDANCE = 1e-4  # the smallest that the engine keeps (mjMINIMP)


def set_contact_options(spec: mujoco.MjSpec, timestep: float) -> None:
    """Set the engine's options that this contact was verified with, and its time step, s."""
    option = spec.option
    option.timestep = timestep
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # One touch has three rows, which the dual solver finds in two passes; Newton's factors a matrix of all
    # degrees of freedom in each.
    option.solver = mujoco.mjtSolver.mjSOL_PGS
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.tolerance = 1e-10
    option.noslip_iterations = 0
    # A state that blew up must stay visible, not turn into the initial one.
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET


def add_contact_pair(
    spec: mujoco.MjSpec,
    tip_geom: str,
    surface_geom: str,
    parameters: ContactParameters,
    name: str = PAIR_NAME,
) -> None:
    """Let tip and surface collide, as an explicit pair; `tune_contact_pair` completes it once compiled."""
    mu = parameters.friction
    spec.add_pair(
        name=name,
        geomname1=surface_geom,
        geomname2=tip_geom,
        condim=3,
        margin=0.0,
        gap=0.0,
        # The engine leaves adhesion out of a model that was compiled without any.
        adhesion=parameters.adhesion,
        friction=[mu, mu, 0, 0, 0],
    )


def effective_mass(model: mujoco.MjModel, name: str = PAIR_NAME) -> float:
    """Mass in kg that the pair's contact feels: the tip body's, in series with a movable surface's.

    It is the engine's own average over directions in the reference configuration, which is also what it
    divides by, so that stiffness stays in N/m in any pose.
    """
    pair = model.pair(name).id
    bodies = model.geom_bodyid[[model.pair_geom1[pair], model.pair_geom2[pair]]]
    inverse = float(model.body_invweight0[bodies, 0].sum())
    if not inverse > 0.0:
        raise ConfigError(
            f"contact pair '{name}': neither of its two bodies can move, so no contact can form"
        )
    return 1.0 / inverse


def tune_contact_pair(model: mujoco.MjModel, parameters: ContactParameters, name: str = PAIR_NAME) -> None:
    """Write the pair's solver parameters; call again whenever masses changed (after `mj_setConst`).

    `impratio` is one number for the whole model, so a model has one tuned tip. Raises `ConfigError` when
    the time step cannot carry the stiffness or damping.
    """
    pair = model.pair(name).id
    d, scale = IMPEDANCE, (1.0 - IMPEDANCE) / effective_mass(model, name)
    b_f = parameters.friction_rate
    model.pair_solimp[pair] = (d, d, 1e-3, 0.5, 2.0)
    *model.pair_solref[pair], model.pair_gap[pair] = pair_compliance(model, parameters, name)
    model.pair_solreffriction[pair] = (-1.0, -b_f * d)
    model.pair_friction[pair, :2] = parameters.friction
    model.pair_adhesion[pair] = parameters.adhesion
    model.opt.impratio = parameters.stick_damping * scale / (b_f * d)


def pair_compliance(
    model: mujoco.MjModel, parameters: ContactParameters, name: str = PAIR_NAME
) -> tuple[float, float, float]:
    """How a pair gives way, as the engine takes it: the two numbers of `solref`, and the gap in m.

    Raises:
        ConfigError: when the time step cannot carry the stiffness or damping.
    """
    mass = effective_mass(model, name)
    k, c = parameters.stiffness, parameters.normal_damping(mass)
    _require_resolved(k, c, mass, float(model.opt.timestep))
    scale = (1.0 - IMPEDANCE) / mass
    # A pull reaches as far as the surface's spring stretches under it.
    return -k * scale, -c * scale, parameters.adhesion / k


def _require_resolved(k: float, c: float, mass: float, timestep: float) -> None:
    stiffest, strongest = 0.25 * mass / timestep**2, mass / timestep
    where = f"for a time step of {timestep:g} s and {mass:.3g} kg at the tip"
    if k > stiffest:
        finer = 0.5 * math.sqrt(mass / k)
        raise ConfigError(
            f"surface.stiffness = {k:g} N/m is too stiff {where}: at most {stiffest:.4g} N/m, "
            f"or a time step of {finer:.2g} s"
        )
    if c > strongest:
        raise ConfigError(f"surface.damping = {c:g} N s/m is too much {where}: at most {strongest:.4g} N s/m")


def add_contact_sensor(
    spec: mujoco.MjSpec,
    tip_geom: str,
    surface_geom: str | None,
    samples: int,
    whole_body: bool = False,
) -> None:
    """Record the contact's force and place at every physics step.

    `samples` is the number of physics steps in a control tick: one `mj_step(model, data, nstep=samples)`
    then leaves all of the tick in `data.history`, oldest first (`ContactReading` says where). With
    `whole_body` it is the force on the tip's whole body, at the centre of its parts, and the couple that
    they leave there; without a `surface_geom` that of all it touches.
    """
    sensor = spec.add_sensor(
        name=SENSOR_NAME,
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        # The force acts on the second geom, so the surface comes first: force ON the robot.
        objtype=mujoco.mjtObj.mjOBJ_UNKNOWN if surface_geom is None else mujoco.mjtObj.mjOBJ_GEOM,
        objname=surface_geom or "",
        reftype=mujoco.mjtObj.mjOBJ_BODY if whole_body else mujoco.mjtObj.mjOBJ_GEOM,
        refname=spec.geom(tip_geom).parent.name if whole_body else tip_geom,
        nsample=samples,
    )
    couple = (mujoco.mjtConDataField.mjCONDATA_TORQUE,) if whole_body else ()
    fields = (
        mujoco.mjtConDataField.mjCONDATA_FOUND,
        mujoco.mjtConDataField.mjCONDATA_FORCE,
        *couple,
        mujoco.mjtConDataField.mjCONDATA_POS,
    )
    net_force = 3  # of the attribute reduce: none, mindist, maxforce, netforce
    sensor.intprm = [sum(1 << int(field) for field in fields), net_force, 1]


@dataclass(frozen=True)
class ContactAverage:
    """What the tip felt in one control tick.

    Attributes:
        force: (3,) mean force on the robot over the tick's physics steps, N, world axes. It is exact: force
            times the tick's length is the impulse.
        duty: fraction of the steps in which tip and surface overlapped, 0 to 1.
        position: (3,) centre of the force, m, world: the mean of the steps' contact points, each weighted
            with the magnitude of its force. NaN in a tick without force.
        couple: (3,) mean torque on the robot besides that of the force at its points, N m, world axes; None
            of a touch at one point, which has none.
    """

    force: Array
    duty: Any
    position: Array
    couple: Array | None = None


@dataclass(frozen=True)
class ContactReading:
    """Where the contact sensor's samples lie in `data.history`, one row a physics step, oldest first.

    Attributes:
        found: (n,) indices of the number of contacts; above 0 tip and surface overlap.
        force: (n, 3) indices of the force ON THE ROBOT, N, world axes.
        position: (n, 3) indices of the contact point, m, world; zero where no force acts (an overlap that
            opens fast enough for its damper to cancel its spring carries none).
        couple: (n, 3) indices of the torque ON THE ROBOT about that point, N m, world axes; None of a ball.
    """

    found: np.ndarray
    force: np.ndarray
    position: np.ndarray
    couple: np.ndarray | None = None

    @classmethod
    def of(cls, model: mujoco.MjModel) -> ContactReading:
        """The reading of the sensor that `add_contact_sensor` adds."""
        sensor = model.sensor(SENSOR_NAME).id
        samples, width = int(model.sensor_history[sensor, 0]), int(model.sensor_dim[sensor])
        # The buffer: one word of the user's, a cursor, n times, then n rows of values.
        first = int(model.sensor_historyadr[sensor]) + 2 + samples
        rows = first + width * np.arange(samples)[:, None]
        return cls(
            found=rows[:, 0],
            force=rows + np.arange(1, 4),
            position=rows + np.arange(width - 3, width),
            couple=rows + np.arange(4, 7) if width > 7 else None,
        )

    @property
    def samples(self) -> int:
        """Physics steps in one reading."""
        return len(self.found)

    def average(self, history: Array) -> ContactAverage:
        """Average the tick that one `mj_step` call of `samples` steps has left in `data.history`.

        `history` is the whole buffer, as a NumPy array or as a CasADi column.
        """
        rate = 1.0 / self.samples
        forces, points, couples = (
            [vector(*(history[int(i)] for i in row)) for row in rows]
            for rows in (self.force, self.position, () if self.couple is None else self.couple)
        )
        overlap = sum(where(history[int(i)] > 0.0, 1.0, 0.0) for i in self.found)
        # Weighted with the force, the mean force at the mean point has the steps' mean torque, as far as the
        # steps' forces are parallel. A step without force has no point, and no weight.
        weights = [dot(force, force) ** 0.5 for force in forces]
        total = sum(weights)
        moment = sum(weight * point for weight, point in zip(weights, points, strict=True))
        return ContactAverage(
            force=sum(forces) * rate,
            duty=overlap * rate,
            position=moment / where(total > 0.0, total, math.nan),
            couple=sum(couples) * rate if couples else None,
        )
