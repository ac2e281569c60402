"""A peg in a chamfered hole: touches in several places that hold each other's balance, and the time step."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import mujoco
import numpy as np

from skylimb.robots.description import Tip
from skylimb.simulation.contact import set_contact_options
from skylimb.simulation.peg import add_peg, tune_peg
from skylimb.simulation.surface_bodies import add_surface
from skylimb.simulation.surfaces import Hole
from skylimb.studies.verification.drawing import curves
from skylimb.studies.verification.row import Evidence, Row, worst

_MASS, _GYRATION, _RADIUS, _LENGTH = 2.0, 0.1, 0.015, 0.12
_FORCES = np.array([1.0, 3.0, 10.0])
_FRICTIONS = np.array([0.1, 0.3, 0.6])


def peg_sinks() -> Evidence:
    """On the floor of the hole it sinks in by F / k."""
    stiffnesses = np.array([1000.0, 5000.0, 20000.0])
    found = np.array([[_depth_on_floor(k, force) for force in _FORCES] for k in stiffnesses])
    measured, expected = worst(100.0 * found, 100.0)

    names = [f"k = {k:g} N/m" for k in stiffnesses]
    draw = curves(_FORCES, 100.0 * found, names, ("force (N)", "depth (% of F/k)"), logarithmic=True)
    claim = "On the floor of a hole a peg sinks in by F/k."
    return Evidence(Row("peg_sinks", claim, measured, expected, 0.5, "% of F/k", cases=found.size), draw)


def peg_balances() -> Evidence:
    """Pushed and turned in the hole it comes to rest on several touches, which hold it."""
    rests = _rests()
    off = 100.0 * np.array([rest.unbalanced for rest in rests])
    measured, _ = worst(off, 0.0)

    def draw(axes: Any) -> None:
        axes.plot([rest.touches for rest in rests], off, "o")
        axes.set(xlabel="touches", ylabel="force or torque left over (%)")

    claim = "Pushed and turned in its hole a peg rests on several touches that balance the load."
    return Evidence(
        Row("peg_balances", claim, measured, 1.0, 0.0, "% of the load", "below", cases=len(rests)), draw
    )


def peg_cone() -> Evidence:
    """No touch of those has more friction than mu times its pressure."""
    rests = _rests()
    shares = 100.0 * np.array([rest.cone for rest in rests])
    measured = float(shares.max())

    def draw(axes: Any) -> None:
        axes.plot(np.sort(shares), "o")
        axes.set(xlabel="case", ylabel="friction of the worst touch (% of mu N)")

    claim = "No touch of a peg in its hole has more friction than mu N."
    return Evidence(
        Row("peg_cone", claim, measured, 100.0, 0.1, "% of mu N", "below", cases=len(rests)), draw
    )


def peg_chamfer() -> Evidence:
    """Pushed on along the hole's axis, the chamfer of 45 degrees pushes it aside with (1 - mu) / (1 + mu)."""
    found = np.array([_aside(mu) for mu in _FRICTIONS])
    theory = (1.0 - _FRICTIONS) / (1.0 + _FRICTIONS)
    measured, expected = worst(found, theory)

    def draw(axes: Any) -> None:
        axes.plot(_FRICTIONS, found, "o", label="measured")
        axes.plot(_FRICTIONS, theory, "-", label="(1 - mu) / (1 + mu)")
        axes.set(xlabel="friction", ylabel="sideways over axial force")
        axes.legend()

    claim = "A chamfer of 45 degrees pushes a peg aside with (1 - mu) / (1 + mu) of its push."
    return Evidence(Row("peg_chamfer", claim, measured, expected, 0.01, "", cases=found.size), draw)


def peg_step() -> Evidence:
    """From the chamfer into the hole, down to its floor: where it rests does not depend on the time step."""
    steps = np.array([2e-3, 1e-3, 5e-4])
    finest = np.array([_inserted(force, 2.5e-4) for force in _FORCES])
    off = np.array([[_inserted(force, step) for force in _FORCES] for step in steps]) - finest
    far = 1e6 * np.linalg.norm(off, axis=-1)

    names = [f"{1e3 * step:g} ms" for step in steps]
    draw = curves(_FORCES, far, names, ("force (N)", "place beside that of 0.25 ms (µm)"), logarithmic=True)
    claim = "A peg that slides down a chamfer into its hole rests there with steps of 0.25 to 2 ms alike."
    return Evidence(Row("peg_step", claim, float(far.max()), 50.0, 0.0, "µm", "below", cases=far.size), draw)


class Rest(NamedTuple):
    """A peg at rest in its hole.

    Attributes:
        touches: how many.
        unbalanced: what is left of load and contact forces, as a share of the load; forces, or torques.
        cone: greatest friction of a touch over mu times its pressure.
    """

    touches: int
    unbalanced: float
    cone: float


@cache
def _rests() -> tuple[Rest, ...]:
    """Random loads in the hole."""
    rng = np.random.default_rng(3)
    return tuple(_rest(rng, friction) for friction in _FRICTIONS for _ in range(10))


def _rest(rng: np.random.Generator, friction: float) -> Rest:
    hole = _hole(friction=float(friction))
    model, data = _rig(hole, depth=0.05)
    force = np.array([rng.uniform(1.0, 5.0), *rng.uniform(-3.0, 3.0, 2)])
    torque = np.array([0.0, *rng.uniform(-0.2, 0.2, 2)])
    # A light damper lets it come to rest.
    model.dof_damping[:] = [20.0] * 3 + [0.5] * 3
    data.body("peg").xfrc_applied[:] = [*force, *torque]
    mujoco.mj_step(model, data, 4000)
    forces, torques, shares = _touches(model, data, friction)
    # The damper's share, where it still creeps.
    forces, torques = forces + data.qfrc_passive[:3], torques + data.qfrc_passive[3:]
    pushed = float(np.linalg.norm(force))
    scale = pushed, float(np.linalg.norm(torque)) + pushed * _RADIUS
    unbalanced = max(
        float(np.linalg.norm(force + forces)) / scale[0], float(np.linalg.norm(torque + torques)) / scale[1]
    )
    return Rest(len(shares), unbalanced, max(shares, default=np.inf))


def _touches(
    model: mujoco.MjModel, data: mujoco.MjData, friction: float
) -> tuple[np.ndarray, np.ndarray, list[float]]:
    """Contact forces on the peg, their torques about its body, and each touch's share of its cone."""
    forces, torques, shares, wrench = np.zeros(3), np.zeros(3), [], np.zeros(6)
    peg = model.geom("tip_peg").id
    for index in range(data.ncon):
        contact = data.contact[index]
        mujoco.mj_contactForce(model, data, index, wrench)
        if wrench[0] <= 0.0:
            continue
        force = contact.frame.reshape(3, 3).T @ wrench[:3] * (1.0 if contact.geom[1] == peg else -1.0)
        forces += force
        torques += np.cross(contact.pos - data.body("peg").xpos, force)
        shares.append(float(np.linalg.norm(wrench[1:3])) / (friction * float(wrench[0])))
    return forces, torques, shares


def _depth_on_floor(stiffness: float, force: float) -> float:
    """Depth over F / k on the floor."""
    hole = _hole(stiffness=stiffness)
    model, data = _rig(hole, depth=hole.depth)
    data.body("peg").xfrc_applied[0] = force
    mujoco.mj_step(model, data, 4000)
    return float((data.qpos[0] - hole.depth) * stiffness / force)


def _aside(friction: float) -> float:
    """Sideways over axial force while it slides in on the chamfer, its attitude held."""
    hole = _hole(friction=friction)
    offset = hole.radius - _RADIUS + 0.7 * hole.chamfer
    model, data = _rig(hole, depth=0.0, aside=offset)
    ratios = []
    for k in range(500):
        # A hand leads it down along the slope, 0.5 mm deep in it.
        x = 1e-5 * k
        data.qpos[:3] = [x + _front(hole, offset), offset - x, 0.0]
        data.qpos[3:], data.qvel[:] = [1.0, 0.0, 0.0, 0.0], [0.01, -0.01, 0.0, 0.0, 0.0, 0.0]
        mujoco.mj_forward(model, data)
        forces, _, _ = _touches(model, data, friction)
        ratios.append(forces[1] / forces[0])
    return float(np.mean(ratios))


def _front(hole: Hole, offset: float) -> float:
    """Where its front is when its round end presses 0.5 mm into the chamfer, m behind the face."""
    # The round end touches the slope where its own slope is 45 degrees.
    centre = hole.radius + hole.chamfer - offset - _RADIUS * np.sqrt(2.0)
    return float(centre + _RADIUS + 0.5e-3 * np.sqrt(2.0))


def _inserted(force: float, timestep: float) -> np.ndarray:
    """Where it rests on the floor after a push from the chamfer, m, (3,)."""
    hole = _hole(friction=0.2)
    model, data = _rig(hole, depth=-0.005, aside=0.008, timestep=timestep)
    model.dof_damping[:] = [20.0] * 3 + [0.5] * 3
    body = data.body("peg")
    for _ in range(round(4.0 / timestep)):
        # Springs hold its attitude and, softly, its line.
        turn = 2.0 * data.qpos[4:7]
        body.xfrc_applied[:] = [force, 10.0 * (0.008 - data.qpos[1]), 0.0, *(-5.0 * turn)]
        mujoco.mj_step(model, data)
    return np.array(data.qpos[:3])


def _hole(friction: float = 0.4, stiffness: float = 5000.0) -> Hole:
    return Hole(position=(0.0, 0.0, 0.0), friction=friction, stiffness=stiffness, damping_ratio=1.0)


def _rig(
    hole: Hole, depth: float, aside: float = 0.0, timestep: float = 1e-3
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A free body with a peg along x, its front `depth` (m) behind the hole's face, `aside` of its axis."""
    spec = mujoco.MjSpec()
    set_contact_options(spec, timestep)
    spec.option.gravity = [0.0, 0.0, 0.0]
    parts = add_surface(spec, hole)
    body = spec.worldbody.add_body(name="peg", pos=[depth, aside, 0.0])
    body.add_freejoint()
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = _MASS, [_GYRATION**2 * _MASS] * 3, [0.0, 0.0, 0.0]
    ball = mujoco.mjtGeom.mjGEOM_SPHERE
    body.add_geom(name="tip", type=ball, size=[1e-3, 0, 0], mass=0.0, contype=0, conaffinity=0)
    # The body's origin is the peg's front.
    tip = Tip("peg", np.zeros(3), 0.0)
    add_peg(spec, "tip", tip, (_RADIUS, _LENGTH), parts, hole.contact)
    model = spec.compile()
    tune_peg(model, hole.contact)
    return model, mujoco.MjData(model)
