"""Dry friction of a servo joint, against its equations and against the engine's own constraint."""

import mujoco
import numpy as np
import pytest

import skylimb
from skylimb.simulation.plant import build_plant
from skylimb.simulation.plant_config import PlantConfig
from skylimb.simulation.servo_friction import add_servo_friction, tune_servo_friction
from skylimb.simulation.surfaces import Board

INERTIA, FRICTION = 0.02, 0.05
DAMPING = INERTIA / 1e-3
STUCK = FRICTION / DAMPING  # rad/s


def hinge(kind: str = "motor", step: float = 1e-4) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """One joint with a weak servo that is off; friction is a "motor", the engine's "constraint" or "none"."""
    spec = mujoco.MjSpec()
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = [0.0, 0.0, 0.0]
    body = spec.worldbody.add_body(name="arm", mass=1.0, inertia=[INERTIA] * 3, explicitinertial=True)
    body.add_joint(
        name="joint",
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=[0, 0, 1],
        frictionloss=FRICTION if kind == "constraint" else 0.0,
    )
    servo = spec.add_actuator(name="servo", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="joint", group=1)
    servo.set_to_position(kp=5.0, kv=1.0)
    spec.option.disableactuator = 1 << 1
    if kind == "motor":
        add_servo_friction(spec, "joint", FRICTION)
    model = spec.compile()
    tune_servo_friction(model)
    return model, mujoco.MjData(model)


def turn(model: mujoco.MjModel, data: mujoco.MjData, load: float, duration: float) -> float:
    """The joint's speed, rad/s, after it was under a load, N m."""
    data.qfrc_applied[0] = load
    mujoco.mj_step(model, data, nstep=round(duration / model.opt.timestep))
    return float(data.qvel[0])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_joint_that_turns_is_braked_by_its_dry_friction(side: float) -> None:
    model, data = hinge()
    data.qvel[0] = side * 10.0 * STUCK
    speed = turn(model, data, 0.0, 0.005)
    assert speed == pytest.approx(side * (10.0 * STUCK - FRICTION / INERTIA * 0.005), rel=1e-9)
    assert turn(model, data, side * 3.0 * FRICTION, 0.1) == pytest.approx(
        speed + side * 2.0 * FRICTION / INERTIA * 0.1, rel=1e-9
    )


def test_a_stuck_joint_creeps_under_a_load_and_comes_to_rest_without() -> None:
    model, data = hinge()
    assert turn(model, data, 0.8 * FRICTION, 0.05) == pytest.approx(0.8 * STUCK, rel=1e-6)
    assert turn(model, data, 0.0, 0.02) == pytest.approx(0.0, abs=1e-6 * STUCK)


def test_under_a_servo_it_is_what_the_engines_constraint_is() -> None:
    kinds = [hinge(kind, step=1e-3) for kind in ("motor", "constraint", "none")]
    path = []
    for set_point in 0.03 * np.sin(np.linspace(0.0, 6.0 * np.pi, 1500)):
        for model, data in kinds:
            model.opt.disableactuator = 0
            data.ctrl[0] = set_point
            mujoco.mj_step(model, data, nstep=2)
        path.append([data.qpos[0] for _, data in kinds])
    motor, constraint, none = np.transpose(path[200:])
    effect = np.max(np.abs(none - constraint))
    assert effect > 0.2 * np.ptp(constraint)
    np.testing.assert_allclose(motor, constraint, rtol=0.0, atol=0.01 * effect)


@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_no_step_throws_a_joint_back(step: float) -> None:
    model, data = hinge(step=step)
    for start in np.linspace(0.5, 3.0, 26):
        data.qvel[0] = start * FRICTION * max(step, 1e-3) / INERTIA
        speeds = [turn(model, data, 0.0, step) for _ in range(10)]
        assert min(speeds) >= -1e-12
        assert speeds[-1] < 1e-2 * FRICTION * step / INERTIA


def test_a_heavier_joint_is_stopped_in_the_same_time() -> None:
    model, data = hinge()
    model.body_inertia[1] *= 4.0
    mujoco.mj_setConst(model, data)
    tune_servo_friction(model)
    data.qvel[0] = 0.1 * STUCK
    assert turn(model, data, 0.0, 1e-3) == pytest.approx(0.1 * STUCK * np.exp(-1.0), rel=0.06)


def test_a_robot_in_free_flight_leaves_the_solver_nothing_to_do() -> None:
    robot = skylimb.load_robot("hydrus_xi_quad")
    plant = build_plant(robot, Board(position=(50.0, 0.0, 1.2)), PlantConfig(), 0.005)
    model, data = plant.model, mujoco.MjData(plant.model)
    mujoco.mj_step(model, data, nstep=5)
    assert data.nefc == 0
    # Friction has no input and no state: controls and activations are those of rotors and servos alone.
    assert model.nu == model.na == len(robot.description.rotors) + 7
    joints = [joint for joint in robot.description.joints if joint.kind != "fixed"]
    for joint in joints:
        limits = model.actuator_forcerange[model.actuator(f"{joint.name}_friction").id]
        np.testing.assert_array_equal(limits, [-joint.friction, joint.friction])
        assert model.dof_frictionloss[model.jnt_dofadr[model.joint(joint.name).id]] == 0.0
    assert len(joints) == 7
