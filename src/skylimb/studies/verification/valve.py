"""A valve: when its lever starts to turn, what turning takes, how it leans on its stop, and the time step.

A ball on an arm about the same hinge pushes the lever from the side. A torque T on the arm presses with
T / r, r from the hinge to the ball.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from skylimb.simulation.contact import add_contact_pair, set_contact_options, tune_contact_pair
from skylimb.simulation.surface_bodies import HINGE, add_surface
from skylimb.simulation.surfaces import Valve
from skylimb.studies.verification.drawing import curves
from skylimb.studies.verification.row import Evidence, Row, worst

_MASS, _RADIUS = 1.0, 0.004
_ARMS = np.array([0.1, 0.2, 0.3])
_NAMES = [f"r = {arm:g} m" for arm in _ARMS]
_HAND = np.array([200.0, 2.0])  # N m/rad and N m s/rad, of a hand that turns the arm steadily
_TORQUES = np.array([0.1, 0.5, 2.0])


def valve_starts() -> Evidence:
    """The lever stays while the push has less torque about the hinge than dry friction, and goes beyond."""
    shares = np.array([0.9, 0.95, 0.98, 1.02, 1.05, 1.1])
    turned = np.array([[[_moved(arm, T, share * T) for share in shares] for T in _TORQUES] for arm in _ARMS])
    flat = turned.reshape(-1, len(shares))
    limits = [0.5 * (shares[row].min(initial=9.0) + shares[~row].max(initial=0.0)) for row in flat]
    measured, expected = worst(100.0 * np.array(limits), 100.0)

    both = "torque of the push (% of the dry friction)", "turns (0 or 1)"
    draw = curves(100.0 * shares, turned[:, 1].astype(float), _NAMES, both)
    claim = "A valve starts to turn when the push has the torque of its dry friction."
    return Evidence(Row("valve_starts", claim, measured, expected, 2.0, "% of it", cases=turned.size), draw)


def valve_turns() -> Evidence:
    """Turned at a steady rate, the contact's torque about the hinge is dry friction and damper."""
    rates = np.array([0.05, 0.2, 0.5])
    found = np.array([[_turning(arm, T, rate) for rate in rates for T in _TORQUES] for arm in _ARMS])
    measured, expected = worst(100.0 * found, 100.0)

    both = "case (friction, rate)", "torque of the contact (% of theory)"
    draw = curves(None, 100.0 * found, _NAMES, both)
    claim = "Turned steadily, the contact's torque about the hinge is the hinge's friction and damper."
    return Evidence(Row("valve_turns", claim, measured, expected, 0.5, "% of theory", cases=found.size), draw)


def valve_stops() -> Evidence:
    """At its stop the ball sinks into the lever by F / k."""
    forces = np.array([0.5, 2.0, 8.0])
    found = np.array([[_depth_at_stop(arm, force) for force in forces] for arm in _ARMS])
    measured, expected = worst(100.0 * found, 100.0)

    draw = curves(forces, 100.0 * found, _NAMES, ("force (N)", "depth (% of F/k)"), logarithmic=True)
    claim = "Pressed against its stop, a ball sinks into the lever by F/k."
    return Evidence(Row("valve_stops", claim, measured, expected, 1.0, "% of F/k", cases=found.size), draw)


def valve_step() -> Evidence:
    """A push that turns it for 2 s: where it is then does not depend on the time step."""
    steps = np.array([2e-3, 1e-3, 5e-4])
    cases = [(arm, T) for arm in _ARMS for T in _TORQUES[:2]]
    finest = np.array([_pushed(arm, T, 2.5e-4) for arm, T in cases])
    off = np.array([[_pushed(arm, T, step) for arm, T in cases] for step in steps]) - finest
    measured = float(100.0 * np.abs(off / finest).max())

    names = [f"{1e3 * step:g} ms" for step in steps]
    both = "case (arm, friction)", "turn beside that of 0.25 ms (%)"
    draw = curves(None, 100.0 * off / finest, names, both)
    claim = "A time step of 0.5 to 2 ms turns a pushed valve as far as one of 0.25 ms."
    return Evidence(Row("valve_step", claim, measured, 2.0, 0.0, "%", "below", cases=off.size), draw)


@dataclass
class _Rig:
    """The valve and the arm.

    Attributes:
        model: of both.
        data: its state.
        arm: dof of the arm; 0 is where the ball just touches the lever at its first stop.
        lever: dof of the lever.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    arm: int
    lever: int

    @property
    def torque(self) -> float:
        """Torque of the contact on the lever about the hinge, friction and all, N m."""
        total, wrench = 0.0, np.zeros(6)
        for index in range(self.data.ncon):
            contact = self.data.contact[index]
            mujoco.mj_contactForce(self.model, self.data, index, wrench)
            # The force acts on the second geom; the engine puts the ball first.
            force = contact.frame.reshape(3, 3).T @ wrench[:3]
            total += float(np.cross(contact.pos, force)[0])
        return total


def _rig(arm: float, valve: Valve, timestep: float = 1e-3) -> _Rig:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    set_contact_options(spec, timestep)
    parts = add_surface(spec, valve)
    # The ball's middle stands beside the lever's middle line, so that it presses square to the lever.
    side = -(0.5 * valve.thickness + _RADIUS)
    body = spec.worldbody.add_body(name="arm")
    body.add_joint(name="arm", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[1.0, 0.0, 0.0])
    body.explicitinertial = True
    body.mass, body.ipos, body.inertia = _MASS, [0.0, arm, side], [1e-3] * 3
    body.gravcomp = 1.0
    ball = mujoco.mjtGeom.mjGEOM_SPHERE
    body.add_geom(
        name="tip", type=ball, size=[_RADIUS, 0, 0], pos=[0, arm, side], contype=0, conaffinity=0, mass=0
    )
    add_contact_pair(spec, "tip", parts.geom, valve.contact)
    model = spec.compile()
    tune_contact_pair(model, valve.contact)
    dofs = [int(model.jnt_dofadr[model.joint(name).id]) for name in ("arm", HINGE)]
    return _Rig(model, mujoco.MjData(model), *dofs)


def _valve(friction_torque: float = 0.3, **keys: Any) -> Valve:
    return Valve(position=(0.0, 0.0, 0.0), damping_ratio=1.0, friction_torque=friction_torque, **keys)


def _moved(arm: float, friction_torque: float, torque: float) -> bool:
    """Whether 3 s of this torque turn the lever by more than 10 mrad."""
    rig = _rig(arm, _valve(friction_torque, friction=0.0))
    rig.data.qfrc_applied[rig.arm] = torque
    mujoco.mj_step(rig.model, rig.data, 3000)
    return bool(rig.data.qpos[rig.lever] > 0.01)


def _turning(arm: float, friction_torque: float, rate: float) -> float:
    """Torque of the contact about the hinge over that of theory, while a hand turns the arm steadily."""
    valve = _valve(friction_torque, travel=6.0)
    rig = _rig(arm, valve)
    data, torques = rig.data, []
    for k in range(3000):
        behind = np.array([rate * data.time - data.qpos[rig.arm], rate - data.qvel[rig.arm]])
        data.qfrc_applied[rig.arm] = _HAND @ behind
        mujoco.mj_step(rig.model, data)
        if k >= 2500:
            torques.append(rig.torque)
    return float(np.mean(torques)) / (friction_torque + valve.hinge_damping * rate)


def _depth_at_stop(arm: float, force: float) -> float:
    """Depth over F / k once the lever leans on its second stop, which is close."""
    valve = _valve(0.01, travel=0.02, friction=0.0)
    rig = _rig(arm, valve)
    rig.data.qfrc_applied[rig.arm] = force * arm
    mujoco.mj_step(rig.model, rig.data, 6000)
    # Turned by the same angle the two would just touch.
    depth = (rig.data.qpos[rig.arm] - rig.data.qpos[rig.lever]) * arm
    return float(depth * valve.stiffness / force)


def _pushed(arm: float, friction_torque: float, timestep: float) -> float:
    """Turn of the lever after 2 s with half as much torque again as its friction, rad."""
    rig = _rig(arm, _valve(friction_torque, travel=6.0, hinge_damping=0.5, friction=0.0), timestep)
    rig.data.qfrc_applied[rig.arm] = 1.5 * friction_torque
    mujoco.mj_step(rig.model, rig.data, round(2.0 / timestep))
    return float(rig.data.qpos[rig.lever])
