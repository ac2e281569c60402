"""A valve: when its lever starts to turn, what turning takes, how it leans on its stop, and the time step.

A ball on an arm about the same hinge pushes the lever from the side. A torque T on the arm presses with
T / r, r from the hinge to the ball.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from skylimb.simulation.surface_bodies import HINGE, LEVER
from skylimb.simulation.surfaces import Valve
from skylimb.studies.verification.drawing import family, lines
from skylimb.studies.verification.rig import RADIUS, released, scene, touches
from skylimb.studies.verification.row import Evidence, evidence, sweep

_ARM = "arm"
_MASS = 1.0  # kg, of the arm
_ARMS = np.array([0.1, 0.2, 0.3])
_NAMES = [f"r = {arm:g} m" for arm in _ARMS]
_SERVO = np.array([200.0, 2.0])  # N m/rad and N m s/rad, of a servo that turns the arm steadily
_TORQUES = np.array([0.1, 0.5, 2.0])


def valve_starts() -> Evidence:
    """The lever stays while the push has less torque about the hinge than dry friction, and goes beyond."""
    shares = np.array([0.9, 0.95, 0.98, 1.02, 1.05, 1.1])
    turned = sweep(_moved, _ARMS, _TORQUES, shares)
    flat = turned.reshape(-1, len(shares))
    limits = [50.0 * (shares[row].min(initial=9.0) + shares[~row].max(initial=0.0)) for row in flat]
    drawn = family(100.0 * shares, turned[:, 1].astype(float), _NAMES)
    return evidence(
        "valve_starts",
        "A valve starts to turn when the push has the torque of its dry friction.",
        limits,
        100.0,
        2.0,
        "% of it",
        lines(drawn, "torque of the push (% of the dry friction)", "turns (0 or 1)"),
        cases=turned.size,
    )


def valve_turns() -> Evidence:
    """Turned at a steady rate, the contact's torque about the hinge is dry friction and damper."""
    rates = np.array([0.05, 0.2, 0.5])
    found = 100.0 * sweep(_turning, _ARMS, rates, _TORQUES)
    drawn = family(np.arange(rates.size * _TORQUES.size), found.reshape(len(_ARMS), -1), _NAMES)
    return evidence(
        "valve_turns",
        "Turned steadily, the contact's torque about the hinge is the hinge's friction and damper.",
        found,
        100.0,
        0.5,
        "% of theory",
        lines(drawn, "case (rate, friction)", "torque of the contact (% of theory)"),
    )


def valve_stops() -> Evidence:
    """At its stop the ball sinks into the lever by F / k."""
    forces = np.array([0.5, 2.0, 8.0])
    found = 100.0 * sweep(_depth_at_stop, _ARMS, forces)
    drawn = family(forces, found, _NAMES)
    return evidence(
        "valve_stops",
        "Pressed against its stop, a ball sinks into the lever by F/k.",
        found,
        100.0,
        1.0,
        "% of F/k",
        lines(drawn, "force (N)", "depth (% of F/k)", xscale="log"),
    )


def valve_step() -> Evidence:
    """A push that turns it for 2 s: where it is then does not depend on the time step."""
    steps = np.array([2e-3, 1e-3, 5e-4, 2.5e-4])
    turns = sweep(_turned, steps, _ARMS, _TORQUES[:2]).reshape(len(steps), -1)
    off = 100.0 * (turns[:-1] / turns[-1] - 1.0)
    drawn = family(np.arange(turns.shape[1]), off, [f"{1e3 * step:g} ms" for step in steps[:-1]])
    return evidence(
        "valve_step",
        "A time step of 0.5 to 2 ms turns a pushed valve as far as one of 0.25 ms.",
        np.abs(off),
        2.0,
        0.0,
        "%",
        lines(drawn, "case (arm, friction)", "turn beside that of 0.25 ms (%)"),
        bound="below",
    )


def _rig(arm: float, valve: Valve, timestep: float = 1e-3) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The valve, and an arm at whose angle 0 the ball just touches the lever at its first stop."""
    # The ball's middle stands beside the lever's middle line, so that it presses square to the lever.
    ball = [0.0, arm, -(0.5 * valve.thickness + RADIUS)]
    spec, body, parts = scene(valve, _MASS, 1e-3, [0.0, 0.0, 0.0], ball, timestep=timestep)
    body.add_joint(name=_ARM, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[1.0, 0.0, 0.0])
    body.ipos = ball
    return released(spec, valve, parts)


def _valve(friction_torque: float = 0.3, **keys: Any) -> Valve:
    return Valve(position=(0.0, 0.0, 0.0), damping_ratio=1.0, friction_torque=friction_torque, **keys)


def _pushed(rig: tuple[mujoco.MjModel, mujoco.MjData], torque: float, duration: float) -> mujoco.MjData:
    """The rig after a torque (N m) on the arm for some time (s)."""
    model, data = rig
    data.joint(_ARM).qfrc_applied = torque
    mujoco.mj_step(model, data, round(duration / model.opt.timestep))
    return data


def _moved(arm: float, friction_torque: float, share: float) -> bool:
    """Whether 3 s of a share of the hinge's friction turn the lever by more than 10 mrad."""
    rig = _rig(arm, _valve(friction_torque, friction=0.0))
    return bool(_pushed(rig, share * friction_torque, 3.0).joint(HINGE).qpos[0] > 0.01)


def _turning(arm: float, rate: float, friction_torque: float) -> float:
    """Torque of the contact about the hinge over that of theory, while the arm is turned steadily."""
    valve = _valve(friction_torque, travel=6.0)
    model, data = _rig(arm, valve)
    joint, torques = data.joint(_ARM), []
    for k in range(3000):
        behind = np.array([rate * data.time - joint.qpos[0], rate - joint.qvel[0]])
        joint.qfrc_applied = _SERVO @ behind
        mujoco.mj_step(model, data)
        if k >= 2500:  # of all pushes on the lever, friction included
            pushes = touches(model, data, LEVER)
            torques.append(sum(np.cross(push.point, push.force)[0] for push in pushes))
    return float(np.mean(torques)) / (friction_torque + valve.hinge_damping * rate)


def _depth_at_stop(arm: float, force: float) -> float:
    """Depth over F / k once the lever leans on its second stop, which is close."""
    valve = _valve(0.01, travel=0.02, friction=0.0)
    data = _pushed(_rig(arm, valve), force * arm, 6.0)
    # Turned by the same angle the two would just touch.
    depth = (data.joint(_ARM).qpos[0] - data.joint(HINGE).qpos[0]) * arm
    return float(depth * valve.stiffness / force)


def _turned(timestep: float, arm: float, friction_torque: float) -> float:
    """Turn of the lever after 2 s with half as much torque again as its friction, rad."""
    valve = _valve(friction_torque, travel=6.0, hinge_damping=0.5, friction=0.0)
    return float(_pushed(_rig(arm, valve, timestep), 1.5 * friction_torque, 2.0).joint(HINGE).qpos[0])
