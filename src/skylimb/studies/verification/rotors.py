"""Rotors with a speed and an inertia against theory: lag, motor torque, reaction, gyroscopic torque."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from skylimb.robots.description import RobotDescription
from skylimb.robots.links import Joint
from skylimb.simulation.scene import scene_spec
from skylimb.studies.verification.drawing import family, lines
from skylimb.studies.verification.rotor_rig import (
    ACROSS,
    ALONG,
    FACTOR,
    FINE,
    LAG,
    PERIOD,
    RotorRig,
    description,
    far_away,
    speeds_of,
    times_of,
)
from skylimb.studies.verification.row import Evidence, evidence

_STIFF = 10.0  # N m s/rad of the servos that hold that model's wheels


def speed_step() -> Evidence:
    """A rotor's speed follows a step of its command as a first-order lag."""
    times, drawn, off = times_of(60), [], []
    for begin, end in ((4.0, 16.0), (16.0, 4.0), (10.0, 11.0)):
        rig = RotorRig.of(description(), begin)
        found = speeds_of(rig.fly(np.full(4, end), len(times))[:, 0])
        first, last = speeds_of(np.array([begin, end]))
        theory = last + (first - last) * np.exp(-times / LAG)
        off.append(np.abs(found - theory).max())
        drawn += [(times, found, "o", f"{begin:g} to {end:g} N"), (times, theory, "k-", "")]
    return evidence(
        "speed_step",
        "After a step of its command a rotor's speed comes by a first-order lag; its thrust is its square.",
        off,
        0.0,
        1e-6,
        "rad/s",
        lines(drawn, "time (s)", "speed (rad/s)"),
    )


def torque_limit() -> Evidence:
    """A motor at its limit accelerates against the drag as theory says, and brakes as hard."""
    inertia, drag, torque, times = 5e-4, 0.02, 0.5, times_of(12)
    drawn, off = [], []
    for begin, end in ((1.0, 20.0), (20.0, 1.0)):
        rig = RotorRig.of(description(inertia, drag=drag, torque=torque), begin)
        found = speeds_of(rig.fly(np.full(4, end), len(times))[:, 0])
        # J dOmega/dt = +-torque - drag k Omega^2, whose solution is a tanh, or a tan.
        scale = math.sqrt(torque / (drag * FACTOR))
        rate, first = torque / (inertia * scale), float(speeds_of(np.array(begin))) / scale
        if end > begin:
            theory = scale * np.tanh(np.arctanh(first) + rate * times)
        else:
            theory = scale * np.tan(np.arctan(first) - rate * times)
        # Only as long as the lag asks for more than the motor has.
        last = float(speeds_of(np.array(end)))
        asked = np.abs(last - theory) / LAG * (1.0 - np.exp(-PERIOD / LAG)) * LAG / PERIOD
        rest = (np.sign(last - theory) * torque - drag * FACTOR * theory**2) / inertia
        at_limit = np.cumprod(asked > 1.1 * np.abs(rest)).astype(bool)
        off.append(float(np.abs(found / theory - 1.0)[at_limit].max()))
        drawn += [
            (times[at_limit], found[at_limit], "o", f"{begin:g} to {end:g} N"),
            (times[at_limit], theory[at_limit], "k-", ""),
        ]
    return evidence(
        "torque_limit",
        "A motor at its greatest torque speeds its rotor up against the drag, and brakes it, as theory says.",
        100.0 * np.array(off),
        0.0,
        0.05,
        "%",
        lines(drawn, "time (s)", "speed (rad/s)"),
    )


def reaction() -> Evidence:
    """A free body takes up the angular momentum that its rotors gain."""
    times, inertias = times_of(60), (0.0, 1e-4, 3.24e-4, 6.5e-4)
    turns, drawn = [], []
    for inertia in inertias:
        rig = RotorRig.of(description(inertia), 4.0)
        found = rig.fly(np.full(4, 16.0), len(times))
        gained = 4.0 * inertia * (speeds_of(found[:, 0]) - speeds_of(np.array(4.0)))
        turn, theory = found[:, 4 + 5], -gained / ALONG
        turns.append(np.abs(turn - theory).max())
        drawn += [(times, turn, "o", f"{inertia:g} kg m²"), (times, theory, "k-", "")]
    return evidence(
        "reaction",
        "Rotors that gain speed turn a free body the other way: angular momentum is kept.",
        turns,
        0.0,
        1e-9,
        "rad/s",
        lines(drawn, "time (s)", "turn of the body (rad/s)"),
    )


def precession() -> Evidence:
    """A body whose rotors turn one way precesses, at their angular momentum over its inertia."""
    ticks, rate, drawn, off = 400, 0.3, [], []
    times = times_of(ticks)
    for inertia in (1e-4, 3.24e-4, 6.5e-4):
        rig = RotorRig.of(description(inertia), 10.0)
        rig.data.qvel[3] = rate
        found = rig.fly(np.full(4, 10.0), ticks)[:, 4 + 3 : 4 + 5]
        phase = 4.0 * inertia * float(speeds_of(np.array(10.0))) / ACROSS * times
        theory = rate * np.stack([np.cos(phase), np.sin(phase)], axis=1)
        off.append(float(np.abs(found - theory).max() / rate))
        drawn += [(times, found[:, 0], "o", f"{inertia:g} kg m²"), (times, theory[:, 0], "k-", "")]
    return evidence(
        "precession",
        "A body whose rotors turn one way precesses, at their angular momentum over its own inertia.",
        100.0 * np.array(off),
        0.0,
        2.0,
        "% of its turn, after 2 s",
        lines(drawn, "time (s)", "turn about x (rad/s)"),
    )


def energy() -> Evidence:
    """The gyroscopic torque does no work: a precessing body keeps its energy."""
    ticks, drawn, off = 1000, [], []
    times = times_of(ticks)
    for inertia in (1e-4, 3.24e-4, 6.5e-4):
        rig = RotorRig.of(description(inertia), 10.0)
        rig.data.qvel[3] = 0.3
        turns = rig.fly(np.full(4, 10.0), ticks)[:, 4 + 3 : 4 + 6]
        kept = np.sum(turns**2 * [ACROSS, ACROSS, ALONG], axis=1) / (ACROSS * 0.3**2)
        off.append(float(np.abs(kept[-1] - 1.0)))
        drawn += family(times, [100.0 * (kept - 1.0)], [f"{inertia:g} kg m²"], "-")
    return evidence(
        "energy",
        "The gyroscopic torque does no work: a precessing body keeps its energy over 5 s.",
        100.0 * np.array(off),
        0.0,
        5.0,
        "%",
        lines(drawn, "time (s)", "energy gained (%)"),
    )


def wheel() -> Evidence:
    """An arm with rotors on a hinge moves as one with wheels that the engine itself turns."""
    ticks, middle, axis = 100, np.zeros(3), np.array([1.0, 0.0, 0.0])
    times = times_of(ticks)
    hinge = Joint("hinge", "revolute", "body", "arm", middle, np.eye(3), axis, -3.0, 3.0, 1.0, 1.0, 0.2, 0.0)
    start, commands = np.array([0.2, -0.3, 0.1, 0.4]), np.array([12.0, 9.0, 8.0, 11.0])
    drawn, off = [], []
    for spins in ((1, 1, 1, 1), (1, -1, 1, -1), (1, 1, -1, 1)):
        described = description(3.24e-4, spins, hinge=hinge)
        rig = RotorRig.of(described, 10.0, FINE)
        rig.data.qvel[3:7] = start
        turned = rig.fly(commands, ticks)
        wheels = _with_wheels(described, start, commands, ticks)
        found = turned[:, 4 + 3 : 4 + 7]
        off.append(float(np.abs(found - wheels).max()))
        drawn += [(times, found[:, 3], "o", f"spins {spins}"), (times, wheels[:, 3], "k-", "")]
    return evidence(
        "wheel",
        "Rotors on a hinged arm move it and its body as wheels do that the engine itself turns.",
        off,
        0.0,
        0.01,
        "rad/s",
        lines(drawn, "time (s)", "rate of the hinge (rad/s)"),
    )


def _with_wheels(
    described: RobotDescription, start: np.ndarray, commands: np.ndarray, ticks: int
) -> np.ndarray:
    """Turn of the body and rate of the hinge after each tick, (ticks, 4), with wheels in the rotors' places.

    The wheels are bodies of the engine, whose speeds stiff servos hold; thrusts are theirs.
    """
    spec, _ = scene_spec(described, far_away(), FINE, round(PERIOD / FINE))
    spec.option.gravity = [0.0, 0.0, 0.0]
    arm, inertias = spec.body("arm"), np.array([rotor.inertia for rotor in described.rotors])
    spins = np.array([rotor.spin for rotor in described.rotors])
    for rotor, inertia in zip(described.rotors, inertias, strict=True):
        body = arm.add_body(name=f"wheel {rotor.name}", pos=rotor.xyz)
        # All but no mass, as the arm has it; a body's moments are at least half of the largest.
        body.explicitinertial, body.mass = True, 1e-9
        body.inertia = inertia * np.array([0.51, 0.51, 1.0])
        joint = body.add_joint(
            name=f"turn {rotor.name}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0]
        )
        spec.add_actuator(
            name=f"speed {rotor.name}",
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            target=joint.name,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            gainprm=[_STIFF] + [0.0] * 9,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            biasprm=[0.0, 0.0, -_STIFF] + [0.0] * 7,
        )
    whole = float(inertias.sum())
    arm.fullinertia = np.array(arm.fullinertia) - whole * np.array([0.51, 0.51, 1.0, 0.0, 0.0, 0.0])
    model = spec.compile()
    model.actuator_ctrllimited[:] = False
    data, speeds = mujoco.MjData(model), np.full(4, float(speeds_of(np.array(10.0))))
    turns = [int(model.jnt_dofadr[model.joint(f"turn {rotor.name}").id]) for rotor in described.rotors]
    data.qvel[3:7], data.qvel[turns] = start, spins * speeds
    wanted, decay, found = speeds_of(commands), math.exp(-FINE / LAG), []
    for step in range(1, 1 + ticks * round(PERIOD / FINE)):
        data.act[:4] = data.ctrl[:4] = FACTOR * speeds**2
        speeds = wanted + (speeds - wanted) * decay
        data.ctrl[-4:] = spins * speeds
        mujoco.mj_step(model, data)
        if step % round(PERIOD / FINE) == 0:
            found.append(data.qvel[3:7].copy())
    return np.array(found)


def joint_stop() -> Evidence:
    """A joint that a torque presses against its stop gives way by the torque over the stop's stiffness."""
    axis, middle, torques = np.array([0.0, 0.0, 1.0]), np.zeros(3), np.array([0.5, 1.0, 2.0, 4.0])
    hinge = Joint("hinge", "revolute", "body", "arm", middle, np.eye(3), axis, -0.1, 0.1, 9.0, 1.0, 0.05, 0.0)
    drawn, off = [], []
    for stiffness in (50.0, 200.0, 1000.0):
        beyond = []
        for torque in torques:
            rig = RotorRig.of(
                description(0.0, (1, -1, 1, -1), hinge=hinge), 10.0, FINE, joint_stop_stiffness=stiffness
            )
            for _ in range(4000):
                # On the arm and back on the body, so that nothing but the hinge is loaded.
                rig.data.qfrc_applied[6] = torque
                mujoco.mj_step(rig.plant.model, rig.data)
            beyond.append(1e3 * (rig.data.qpos[7] - 0.1))
        theory = 1e3 * torques / stiffness
        off.append(np.array(beyond) / theory)
        drawn += [(torques, beyond, "o", f"{stiffness:g} N m/rad"), (torques, theory, "k-", "")]
    return evidence(
        "joint_stop",
        "A joint pressed against its stop goes beyond its limit by the torque over the stop's stiffness.",
        off,
        1.0,
        0.01,
        "of theory",
        lines(drawn, "torque (N m)", "beyond the limit (mrad)"),
    )


ROWS = (speed_step, torque_limit, reaction, precession, energy, wheel, joint_stop)
"""Every claim about rotors, and one about the joints that they load, in the order of the page."""
