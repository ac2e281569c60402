"""The IMU's truth against Pinocchio, the engine's own sensors and the flown path; its noise and biases."""

from __future__ import annotations

from importlib import import_module
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.errors import SkylimbError
from skylimb.base.rotations import quaternion_from_rotation, rotation_from_rpy, rotation_from_vector
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import take_off
from skylimb.robots import load_robot
from skylimb.robots.model import Robot
from skylimb.simulation.imu import (
    ImuConfig,
    ImuMotion,
    ImuState,
    draw_imu_errors,
    imu_motion,
    initial_imu_state,
    sense_imu,
)

pin: Any = import_module("pinocchio")
Z3, NONE = np.zeros(3), (np.zeros(3), np.zeros(3))
G = 9.80665
EXACT = {
    "sensors.imu.on": True,
    "sensors.imu.gyro_noise": 0.0,
    "sensors.imu.accelerometer_noise": 0.0,
    "sensors.imu.gyro_bias_drawn": 0.0,
    "sensors.imu.accelerometer_bias_drawn": 0.0,
}


def felt(before: ImuMotion, now: ImuMotion, dt: float) -> Any:
    """What a perfect IMU says after two ticks."""
    state = initial_imu_state(ImuConfig(on=True), dt)
    assert isinstance(state, ImuState)
    for motion in (before, now):
        state, said = sense_imu(state, motion, G, 0.0, NONE, dt)
    return said


@pytest.mark.parametrize("name", ["hydrus_xi_quad", "dragon"])
def test_rates_and_specific_force_are_pinocchios(name: str) -> None:
    """A tree in any motion: the change of velocity over a short time is the frame's acceleration."""
    robot, rng, dt = load_robot(name), np.random.default_rng(5), 1e-5
    d = robot.description
    model = pin.buildModelFromUrdf(str(d.folder / d.sources[1].path.name), pin.JointModelFreeFlyer())
    data, frame = model.createData(), model.getFrameId(d.imu.link, pin.FrameType.BODY)
    names = [*d.shape_joints, *d.vectoring_joints]
    joints = [model.joints[model.getJointId(one)] for one in names]
    middle, v, a = pin.neutral(model), rng.normal(size=model.nv), rng.normal(size=model.nv)
    turned = rotation_from_rpy(*rng.uniform(-1.0, 1.0, 3))
    middle[3:7] = np.roll(quaternion_from_rotation(turned), -1)
    for joint, angle in zip(joints, rng.uniform(-1.0, 1.0, len(names)), strict=True):
        middle[joint.idx_q : joint.idx_q + joint.nq] = (
            [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        )

    def at(time: float) -> ImuMotion:
        x, rates = pin.integrate(model, middle, time * v + 0.5 * time**2 * a), v + time * a
        R = pin.XYZQUATToSE3(x[:7]).rotation
        root = np.concatenate([x[:3], np.roll(x[3:7], 1), R @ rates[:3], rates[3:6]])
        angles = [x[j.idx_q] if j.nq == 1 else np.arctan2(x[j.idx_q + 1], x[j.idx_q]) for j in joints]
        q, psi = np.split(np.array(angles), [robot.n_joints])
        return imu_motion(robot, root, q, psi, np.array([rates[j.idx_v] for j in joints]))

    said = felt(at(-0.5 * dt), at(0.5 * dt), dt)
    pin.forwardKinematics(model, data, middle, v, a)
    pin.updateFramePlacements(model, data)
    R = data.oMf[frame].rotation
    wanted = pin.getFrameClassicalAcceleration(model, data, frame, pin.LOCAL).linear + R.T @ [0.0, 0.0, G]
    np.testing.assert_allclose(said.specific_force, wanted, atol=2e-4)
    np.testing.assert_allclose(
        at(0.0).rates, pin.getFrameVelocity(model, data, frame, pin.LOCAL).angular, atol=1e-12
    )


def test_at_rest_it_feels_gravity_along_up_and_in_free_fall_nothing() -> None:
    R = rotation_from_rpy(0.4, -0.7, 1.1)
    rest, falling = ImuMotion(R, Z3, Z3), ImuMotion(R, np.array([0.0, 0.0, -0.005 * G]), Z3)
    np.testing.assert_allclose(felt(rest, rest, 0.005).specific_force, R.T @ [0.0, 0.0, G], atol=1e-12)
    np.testing.assert_allclose(felt(rest, falling, 0.005).specific_force, 0.0, atol=1e-12)


def test_a_falling_plant_feels_nothing_and_the_engine_agrees() -> None:
    """Rotors off, joints at their set points; then a whirl, of which the engine says the board's rates."""
    (takeoff,) = take_off("paper", ("pid",), set={"plant.physics_step": 1e-4})
    plant, robot = takeoff.plant, takeoff.plant.robot
    data, site = takeoff.data(), robot.description.imu
    data.act[: robot.n_rotors] = 0.0
    angles = [*plant.joint_qpos, *plant.vectoring_qpos]
    data.act[robot.n_rotors :] = data.qpos[angles]
    dt = takeoff.period

    def now() -> ImuMotion:
        rates = data.qvel[[address - 1 for address in angles]]
        root = np.concatenate([data.qpos[:7], data.qvel[:6]])
        q, psi = np.split(data.qpos[angles], [robot.n_joints])
        return imu_motion(robot, root, q, psi, rates)

    assert site.link == "flight_controller"
    before = now()
    mujoco.mj_step(plant.model, data, plant.substeps)
    np.testing.assert_allclose(felt(before, now(), dt).specific_force, 0.0, atol=1e-9)
    data.qvel[:6] = [0.1, -0.2, 0.3, 0.5, -0.4, 0.8]
    mujoco.mj_step(plant.model, data, plant.substeps)
    mujoco.mj_forward(plant.model, data)
    # The board is fused with the link that carries it, in the same axes.
    body, wanted = plant.model.body("link2").id, np.zeros(6)
    mujoco.mj_objectVelocity(plant.model, data, mujoco.mjtObj.mjOBJ_XBODY, body, wanted, 1)
    np.testing.assert_allclose(now().rates, wanted[:3], atol=1e-12)


def test_what_is_felt_in_flight_is_the_second_difference_of_the_path() -> None:
    """Touch and retreat included: mean force over two ticks against three places of the flown IMU."""
    (takeoff,) = take_off("paper", ("hybrid",), set={**HOLD, **EXACT})
    flight, robot, dt = fly_here(takeoff), takeoff.plant.robot, takeoff.period
    qpos = flight.signal("configuration")
    poses = [place_of(robot, takeoff.plant, row) for row in qpos]
    places = np.array([place for place, _ in poses])
    said = flight.signal("imu_specific_force_measured")
    in_W = np.array([R @ force for (_, R), force in zip(poses, said, strict=True)])
    mean = 0.5 * (in_W[1:-1] + in_W[2:])
    wanted = np.diff(places, 2, axis=0) / dt**2 + [0.0, 0.0, G]
    # A velocity is no mean of its tick: the engine's steps are a fifth of it.
    assert np.sqrt(np.mean((mean - wanted) ** 2)) < 0.02
    assert np.abs(wanted[:, 0]).max() > 0.5, "nothing was felt"
    turns = [R.T @ Rn for (_, R), (_, Rn) in pairwise(poses)]
    rates = flight.signal("imu_angular_velocity_measured")
    mean_rates = 0.5 * (rates[1:] + rates[:-1])
    for turn, rate in zip(turns, mean_rates, strict=True):
        np.testing.assert_allclose(turn, rotation_from_vector(dt * rate), atol=2e-4)


def place_of(robot: Robot, plant: Any, qpos: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place and axes of the IMU in W."""
    w, x, y, z = qpos[3:7]
    R = pin.Quaternion(w, x, y, z).toRotationMatrix()
    mount = robot.description.imu
    place, axes = robot.link_poses(qpos[list(plant.joint_qpos)], qpos[list(plant.vectoring_qpos)])[mount.link]
    return qpos[:3] + R @ (place + axes @ mount.xyz), R @ axes @ mount.R


def test_noise_and_biases_are_as_asked_and_of_the_seed() -> None:
    config = ImuConfig(on=True, gyro_bias=(0.1, 0.0, 0.0), accelerometer_bias=(0.0, 0.0, 1.0))
    drawn = [draw_imu_errors(config, 4000, np.random.default_rng(seed)) for seed in range(40)]
    gyro, accelerometer = (np.array(one) for one in zip(*drawn, strict=True))
    assert (gyro - gyro.mean(axis=1, keepdims=True)).std() == pytest.approx(0.002, rel=0.02)
    assert (accelerometer - accelerometer.mean(axis=1, keepdims=True)).std() == pytest.approx(0.05, rel=0.02)
    assert (gyro.mean(axis=1) - config.gyro_bias).std() == pytest.approx(0.002, rel=0.25)
    assert (accelerometer.mean(axis=1) - config.accelerometer_bias).std() == pytest.approx(0.05, rel=0.25)
    np.testing.assert_array_equal(gyro[3], draw_imu_errors(config, 4000, np.random.default_rng(3))[0])


def test_it_says_what_was_its_latency_ago() -> None:
    config = ImuConfig(on=True, latency=0.005)
    state, said = initial_imu_state(config, 0.005), []
    assert isinstance(state, ImuState)
    for k in range(4):
        motion = ImuMotion(np.eye(3), Z3, np.array([float(k), 0.0, 0.0]))
        state, one = sense_imu(state, motion, G, config.latency, NONE, 0.005)
        said.append(one.angular_velocity[0])
    assert said == [0.0, 0.0, 1.0, 2.0]


def test_without_one_a_flight_keeps_its_bits_and_with_one_only_its_signals_are_added() -> None:
    without, with_one = (
        skylimb.run("paper", "impedance", set={**HOLD, "stop_at": 1.5, "sensors.imu.on": on}).log
        for on in (False, True)
    )
    added = {"imu_angular_velocity_measured", "imu_specific_force_measured"}
    assert set(with_one.data_vars) - set(without.data_vars) == added
    for name in without.data_vars:
        np.testing.assert_array_equal(without[name].values, with_one[name].values, err_msg=str(name))


@pytest.mark.parametrize(
    "bad", [{"gyro_noise": -1.0}, {"latency": 1.0}, {"accelerometer_bias": (0.0, 0.0, 99.0)}]
)
def test_nonsense_is_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(SkylimbError, match=next(iter(bad))):
        ImuConfig(on=True, **bad)
