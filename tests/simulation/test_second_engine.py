"""Other engines judge ours: Pinocchio accelerations, Drake flights (docs/reports/second_engine.md)."""

from __future__ import annotations

import runpy
from importlib import import_module
from pathlib import Path
from typing import Any

import casadi as ca
import mujoco
import numpy as np
import pytest

from skylimb.base.rotations import rotation_from_quaternion
from skylimb.control.records import Command
from skylimb.flight.takeoff import take_off
from skylimb.robots.description import Servo
from skylimb.simulation.plant_tick import plant_numbers
from skylimb.simulation.rotors import RotorNumbers, rotor_tick
from skylimb.simulation.servo_friction import servo_brakes
from skylimb.simulation.vehicle import actuator_function

pin: Any = import_module("pinocchio")
BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "second_engine.py"
STATES = 200


def with_rotors(description: Any) -> Any:
    """Pinocchio's model from the URDF, with a joint for each rotor that carries its inertia."""
    urdf = str(description.folder / description.sources[1].path.name)
    model = pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer())
    for rotor in description.rotors:
        frame = model.frames[model.getFrameId(rotor.link, pin.FrameType.BODY)]
        placement = frame.placement * pin.SE3(rotor.R, rotor.xyz)
        turning = np.diag([0.0, 0.0, rotor.inertia])
        # The link's inertia has the rotor's in it already.
        link, R = model.inertias[frame.parentJoint], placement.rotation
        model.inertias[frame.parentJoint] = pin.Inertia(
            link.mass, link.lever, link.inertia - R @ turning @ R.T
        )
        joint = model.addJoint(frame.parentJoint, pin.JointModelRZ(), placement, f"turn {rotor.name}")
        model.appendBodyToJoint(joint, pin.Inertia(0.0, np.zeros(3), turning), pin.SE3.Identity())
    model.gravity.linear = np.array([0.0, 0.0, -description.gravity])
    return model


def test_accelerations_with_turning_rotors_are_pinocchios() -> None:
    """Thrusts, drag, servos, their friction, a force on the tip, pushes, and rotors that speed up."""
    (takeoff,) = take_off("paper", ("hybrid",))
    plant, robot, dt = takeoff.plant, takeoff.plant.robot, takeoff.period
    engine, d = plant.model, robot.description
    assert plant.turning
    model = with_rotors(d)
    data, mine, rng = model.createData(), mujoco.MjData(engine), np.random.default_rng(8)
    names = [*d.shape_joints, *d.vectoring_joints]
    joints = [model.joints[model.getJointId(name)] for name in names]
    described = {joint.name: joint for joint in d.joints}
    places, n, m = [*plant.joint_qpos, *plant.vectoring_qpos], robot.n_rotors, len(names)
    rates_at, columns = [i - 1 for i in places], [*range(6), *(one.idx_v for one in joints)]
    drive, numbers = actuator_function(plant, dt), plant_numbers(plant, dt)
    scales = rng.uniform(0.5, 1.5, n)  # of rotors that give another thrust than they are told
    engine.actuator_gainprm[:n, 0] = scales
    servos = [Servo(*numbers) for numbers in zip(*vars(d.servos).values(), strict=True)]
    brakes = servo_brakes(engine)
    spins, worst = np.array([rotor.spin for rotor in d.rotors]), 0.0
    frames = [model.getFrameId(rotor.link, pin.FrameType.BODY) for rotor in d.rotors]
    tip_link, tip_force = model.getFrameId(d.tip.link, pin.FrameType.BODY), rng.normal(size=(STATES, 3))
    for state in range(STATES):
        mine.qpos[:3] = [-50.0, 0.0, 50.0]  # far from the board
        quaternion = rng.normal(size=4)
        mine.qpos[3:7] = quaternion / np.linalg.norm(quaternion)
        mine.qpos[places] = rng.uniform(-1.2, 1.2, m)
        mine.qvel[:] = 0.0
        mine.qvel[:6], mine.qvel[rates_at] = rng.normal(size=6), rng.normal(size=m)
        thrusts, commanded = rng.uniform(2.0, 25.0, (2, n))
        mine.act[:] = np.concatenate([thrusts, mine.qpos[places] + rng.uniform(-0.05, 0.05, m)])
        command = Command(commanded, mine.act[n : n + robot.n_joints], mine.act[n + robot.n_joints :])
        turns = np.concatenate([mine.qvel[3:6], mine.qvel[rates_at]])
        outputs = mine.qpos, mine.qvel, mine.act, mine.history
        controls, forces, _ = drive(*outputs, numbers, scales, 0.0, turns, *command)
        mine.ctrl[: n + m], mine.qfrc_applied[:] = (
            np.array(controls).ravel()[: n + m],
            np.array(forces).ravel(),
        )
        mujoco.mj_kinematics(engine, mine)
        mujoco.mj_comPos(engine, mine)
        tip = mine.site("tip").xpos
        body = engine.site_bodyid[engine.site("tip").id]
        mujoco.mj_applyFT(engine, mine, tip_force[state], np.zeros(3), tip, body, mine.qfrc_applied)
        mujoco.mj_forward(engine, mine)

        rotors = RotorNumbers(*map(ca.DM, np.split(numbers, 6)))
        rotors = rotors._replace(drag=rotors.drag * scales)
        tick = rotor_tick(rotors, ca.DM(thrusts), ca.DM(commanded), dt)
        R = np.asarray(rotation_from_quaternion(mine.qpos[3:7]))
        x, v = pin.neutral(model), np.zeros(model.nv)
        x[:3], x[3:7] = mine.qpos[:3], np.roll(mine.qpos[3:7], -1)
        v[:3], v[3:6] = R.T @ mine.qvel[:3], mine.qvel[3:6]
        for joint, angle, rate in zip(joints, mine.qpos[places], mine.qvel[rates_at], strict=True):
            at = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            x[joint.idx_q : joint.idx_q + joint.nq], v[joint.idx_v] = at, rate
        v[-n:] = spins * np.array(tick.mean_speeds).ravel()
        rest, still = pin.nonLinearEffects(model, data, x, v).copy(), np.zeros(model.nv)
        weight = pin.rnea(model, data, x, still, still).copy()
        # Joints that were added last are in no order that Pinocchio's own mass matrix could take.
        M = np.array([pin.rnea(model, data, x, still, unit) - weight for unit in np.eye(model.nv)]).T
        pin.computeJointJacobians(model, data, x)
        pin.updateFramePlacements(model, data)
        tau = np.zeros(model.nv)
        for rotor, frame, thrust in zip(d.rotors, frames, scales * thrusts, strict=True):
            J = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
            force = thrust * rotor.R[:, 2]
            torque = np.cross(rotor.xyz, force) + rotor.drag_torque_coefficient * force
            tau += J.T @ np.concatenate([force, torque])
        J, pose = pin.getFrameJacobian(model, data, tip_link, pin.LOCAL), data.oMf[tip_link]
        force = pose.rotation.T @ tip_force[state]
        tau += J.T @ np.concatenate([force, np.cross(d.tip.position, force)])
        for joint, name, servo, place, rate_at, set_point in zip(
            joints, names, servos, places, rates_at, mine.act[n:], strict=True
        ):
            angle, rate, one = mine.qpos[place], mine.qvel[rate_at], described[name]
            wanted = servo.stiffness * (set_point - angle) - servo.damping * rate
            tau[joint.idx_v] += np.clip(wanted, -servo.torque_limit, servo.torque_limit) - one.damping * rate
            tau[joint.idx_v] -= np.clip(brakes[rate_at] * rate, -one.friction, one.friction)
        tau -= M[:, -n:] @ (spins * np.array(tick.accelerations).ravel()) + rest
        a = np.linalg.solve(M[np.ix_(columns, columns)], tau[columns])
        a[:3] = R @ (a[:3] + np.cross(v[3:6], v[:3]))
        found = mine.qacc[[*range(6), *rates_at]]
        worst = max(worst, float(np.abs(a - found).max() / np.abs(found).max()))
    assert worst < 1e-9


@pytest.mark.slow
def test_drake_flies_the_papers_flight_as_mujoco_does() -> None:
    """The friction model, then the integrator, make the rest (docs/reports/second_engine.md)."""
    pytest.importorskip("pydrake", reason="Drake has no wheel for this machine")
    benchmark = runpy.run_path(str(BENCHMARK))
    cog, pen, force, joints = benchmark["differences"]("paper:hybrid", 5e-4)
    assert max(cog, pen) < 0.2  # mm rms
    assert force < 7.0  # mN rms; 3 at half the step
    assert joints < 0.3  # mrad rms
