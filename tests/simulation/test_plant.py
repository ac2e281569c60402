"""The plant against its description, against the model of the same robot, and against conservation laws."""

import mujoco
import numpy as np
import pytest

import skylimb
from skylimb.base.errors import SkylimbError
from skylimb.flight.plan import mission_of
from skylimb.robots.model import Robot
from skylimb.simulation.plant import Plant, build_plant, initial_data, plant_description
from skylimb.simulation.plant_config import PlantConfig
from skylimb.simulation.surfaces import surface_from_mapping


@pytest.fixture(scope="module")
def robot() -> Robot:
    return skylimb.load_robot("hydrus_xi_quad")


@pytest.fixture(scope="module")
def plant(robot: Robot) -> Plant:
    return build_plant(robot, surface_from_mapping({"position": [50.0, 0.0, 1.2]}), PlantConfig(), 0.005)


Q, PSI = np.array([1.0, 1.0, -0.5]), np.array([3.0, 0.2, 2.9, -0.1])


def hovering(robot: Robot) -> tuple[Plant, mujoco.MjData]:
    experiment = skylimb.load_experiment("push")
    built = build_plant(robot, experiment.surface, experiment.plant, experiment.control_period)
    return built, initial_data(built, mission_of(experiment, robot))


def test_mass_and_inertia_are_the_models(robot: Robot, plant: Plant) -> None:
    data = mujoco.MjData(plant.model)
    rng = np.random.default_rng(0)
    for _ in range(10):
        q, psi = rng.uniform(-1.5, 1.5, 3), rng.uniform(-3.0, 3.0, 4)
        data.qpos[list(plant.joint_qpos)], data.qpos[list(plant.vectoring_qpos)] = q, psi
        mujoco.mj_forward(plant.model, data)
        state = robot.at(q, psi)
        np.testing.assert_allclose(data.subtree_com[0], state.cog_root, atol=1e-9)
        dense = np.zeros((plant.model.nv, plant.model.nv))
        mujoco.mj_fullM(plant.model, data, dense)
        assert dense[0, 0] == pytest.approx(robot.mass, abs=1e-9)
        about_root = dense[3:6, 3:6]
        c = state.cog_root
        about_cog = about_root - robot.mass * (c @ c * np.eye(3) - np.outer(c, c))
        R = state.R_root_C
        np.testing.assert_allclose(R.T @ about_cog @ R, state.inertia_C, atol=1e-8)


def test_rotors_push_as_the_allocation_matrix_says(robot: Robot, plant: Plant) -> None:
    data = mujoco.MjData(plant.model)
    q, psi, thrusts = (
        np.array([0.9, 1.1, -0.5]),
        np.array([3.0, 0.2, 2.9, -0.1]),
        np.array([8.0, 12.0, 9.0, 11.0]),
    )
    data.qpos[list(plant.joint_qpos)], data.qpos[list(plant.vectoring_qpos)] = q, psi
    data.act[:] = np.concatenate([thrusts, q, psi])
    mujoco.mj_forward(plant.model, data)
    state = robot.at(q, psi)
    wrench = state.allocation_C @ thrusts
    force = state.R_root_C @ wrench[:3]
    torque = state.R_root_C @ wrench[3:] + np.cross(state.cog_root, force)
    np.testing.assert_allclose(data.qfrc_actuator[:3], force, atol=1e-9)
    np.testing.assert_allclose(data.qfrc_actuator[3:6], torque, atol=1e-9)


def test_before_take_off_nothing_accelerates(robot: Robot) -> None:
    built, data = hovering(robot)
    mujoco.mj_forward(built.model, data)
    assert np.abs(data.qacc).max() < 2e-2


def test_momentum_is_kept_without_gravity_and_rotors(robot: Robot, plant: Plant) -> None:
    """Servos and friction are inner forces: they change neither linear nor angular momentum."""
    model = plant.model
    gravity, step = model.opt.gravity.copy(), model.opt.timestep
    model.opt.gravity[:] = 0.0
    model.opt.timestep = 1e-4
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    data.qpos[list(plant.joint_qpos)] = [0.9, 1.0, -0.6]
    data.qvel[:] = 0.3 * rng.standard_normal(model.nv)
    data.act[4:7] = [0.7, 1.2, -0.4]
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    before = np.concatenate([data.subtree_linvel[0], data.subtree_angmom[0]])
    for _ in range(3000):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    after = np.concatenate([data.subtree_linvel[0], data.subtree_angmom[0]])
    model.opt.gravity[:], model.opt.timestep = gravity, step
    # In joint coordinates momentum is kept to the first order of the step, 0.1 ms here.
    np.testing.assert_allclose(after, before, atol=1e-4)


def test_a_thrust_follows_its_command_with_the_rotors_lag(robot: Robot) -> None:
    built, data = hovering(robot)
    start = data.act[0]
    data.ctrl[0] = start + 2.0
    lag = robot.description.rotors[0].lag
    for _ in range(round(lag / 0.001)):
        mujoco.mj_step(built.model, data)
    assert data.act[0] - start == pytest.approx(2.0 * (1.0 - np.exp(-1.0)), rel=1e-6)


def test_servos_keep_their_speed_limit_and_their_torque_limit(robot: Robot) -> None:
    built, data = hovering(robot)
    data.ctrl[:4] = data.act[:4]
    data.ctrl[4] = 100.0
    first = data.act[4]
    for _ in range(1000):
        mujoco.mj_step(built.model, data)
    assert data.act[4] - first == pytest.approx(robot.description.shape_servos.speed_limit[0] * 1.0, rel=1e-6)
    data.act[4] += 10.0
    mujoco.mj_forward(built.model, data)
    assert data.actuator_force[4] == robot.description.shape_servos.torque_limit[0]


@pytest.mark.parametrize(
    ("changes", "mass"),
    [({"mass_scale": 1.02}, 1.02), ({"cog_offset": (0.01, 0.0, 0.0)}, 1.0)],
)
def test_the_plant_may_differ_from_the_description(
    robot: Robot, changes: dict[str, object], mass: float
) -> None:
    config = PlantConfig(**changes)  # type: ignore[arg-type]
    true = Robot(plant_description(robot.description, config))
    assert true.mass == pytest.approx(robot.mass * mass)
    moved = true.at(Q, PSI).cog_root - robot.at(Q, PSI).cog_root
    np.testing.assert_allclose(moved, config.cog_offset, atol=1e-12)


def test_a_thrust_deficit_sinks_the_impedance_as_its_spring_says(robot: Robot) -> None:
    """A 2 % deficit sinks the robot by about 0.1 m at a stiffness of 1.5 /s^2."""
    run = skylimb.run("push", controller="impedance", set={"plant.thrust_scale": 0.98, "events": []})
    log = run.log
    late = log.where(log["time"] > 18.0, drop=True)
    sunk = float((late["cog_position"] - late["cog_position_reference"]).sel(axis="z").mean())
    assert sunk == pytest.approx(-0.02 * 9.80665 / 1.5, rel=0.1)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"plant.mass_scale": -1.0}, "mass_scale"),
        ({"plant.rotor_scale": [1.0, 1.0]}, "rotor_scale"),
        ({"plant.physics_step": 0.0013}, "physics_step"),
        ({"plant.thrust_scale": 98.0}, "thrust_scale"),
        ({"controller_rate": 333.0}, "physics_step"),
    ],
)
def test_nonsense_is_refused(setting: dict[str, object], message: str) -> None:
    with pytest.raises(SkylimbError, match=message):
        skylimb.run("paper", set=setting)
