"""Motion capture with rate, latency and noise, joint encoders, and an IMU where there is one.

A frame of motion capture shows the plant as it was `latency` before the frame came, and stays until the next
one. Both follow from one number a tick, the age of what is seen: the measurement is the plant's state that
long ago, interpolated in a short history. So the sensor is a pure function of a shift register, an age and a
row of noise, the same in every driver.
"""

from __future__ import annotations

import math
from dataclasses import field
from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import quaternion_product
from skylimb.control.estimation.records import Measurement
from skylimb.simulation.imu import (
    ImuConfig,
    ImuMotion,
    ImuState,
    draw_imu_errors,
    initial_imu_state,
    sense_imu,
)
from skylimb.symbolic import Array, between, stack, vector, where

LONGEST = 0.2
"""Greatest age of a frame when it comes, s."""


@configuration
class SensorConfig:
    """Motion capture of the robot's measured link, and encoders. Noise as standard deviations."""

    rate: Annotated[
        float,
        Key(
            "Hz", "frames a second of the motion capture; 0 for one at every control tick", low=0.0, high=1e4
        ),
    ] = 100.0
    latency: Annotated[float, Key("s", "age of a frame when it comes", low=0.0, high=LONGEST)] = 0.010
    position_noise: Annotated[float, Key("m", "noise of the position", low=0.0, high=0.1)] = 0.001
    velocity_noise: Annotated[float, Key("m/s", "noise of the velocity", low=0.0, high=1.0)] = 0.005
    attitude_noise: Annotated[
        float, Key("rad", "noise of the attitude, about each axis", low=0.0, high=0.2)
    ] = 0.001
    angular_velocity_noise: Annotated[
        float, Key("rad/s", "noise of the angular velocity", low=0.0, high=1.0)
    ] = 0.005
    joint_noise: Annotated[float, Key("rad", "noise of the shape joints' encoders", low=0.0, high=0.1)] = (
        0.0005
    )
    vectoring_noise: Annotated[
        float, Key("rad", "noise of the vectoring joints' encoders", low=0.0, high=0.1)
    ] = 0.0005
    attitude_misalignment: Annotated[
        tuple[float, float, float],
        Key("rad", "constant rotation vector from the true to the measured body axes", low=-0.3, high=0.3),
    ] = (0.0, 0.0, 0.0)
    imu: ImuConfig = field(default_factory=ImuConfig)


class SensorNoise(NamedTuple):
    """Errors of one tick, in the units of the measurement; those of a frame stay as long as the frame."""

    position: Array
    velocity: Array
    attitude: Array
    angular_velocity: Array
    joint_angles: Array
    vectoring_angles: Array
    gyro: Array = np.zeros(3)
    accelerometer: Array = np.zeros(3)


class SensorFailure(NamedTuple):
    """How the sensors fail at a tick; all 0 where they do not.

    Attributes:
        held: 1 where no frame comes, and the last one is seen still.
        frozen: 1 where a frame comes that shows what the last one did.
        stamp: by which the frame's stamp is older than the frame, s.
        velocity: what is added to the share of the true velocity that is seen, 1.
        rates: likewise of the rates.
        stuck_velocity: 1 where the velocity that is seen stays what it was.
        stuck_rates: 1 where the rates do.
        stuck_angles: 1 for each encoder that stays, of shape and vectoring joints, (n_joints + nv,).
    """

    held: Any
    frozen: Any
    stamp: Any
    velocity: Any
    rates: Any
    stuck_velocity: Any
    stuck_rates: Any
    stuck_angles: Array


def no_failure(encoders: int) -> SensorFailure:
    """Sensors that work, of a robot of so many encoders."""
    return SensorFailure(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.zeros(encoders))


class SensorState(NamedTuple):
    """What a tick hands on to the next.

    Attributes:
        history: true root pose and twist at the last ticks, newest first, each (13,).
        shown: pose and twist of the frame that was seen last, (13,).
        angles: that the encoders showed last, (n_joints + nv,).
        age: of that frame, s.
        imu: of the IMU, where there is one.
    """

    history: tuple[Array, ...]
    shown: Array
    angles: Array
    age: Any
    imu: ImuState | tuple[()] = ()


def history_depth(config: SensorConfig, dt: float) -> int:
    """Ticks that the history must hold for the oldest state ever looked at, and its older neighbour."""
    frame = 1.0 / config.rate if config.rate > 0.0 else 0.0
    # Just before a frame comes, the last one is a frame's time old, less a tick where frames and ticks keep
    # step.
    in_step = abs(frame / dt - round(frame / dt)) < 1e-9
    oldest = config.latency + (max(frame - dt, 0.0) if in_step else frame)
    return math.ceil(oldest / dt - 1e-9) + 1


def initial_sensor_state(
    config: SensorConfig, dt: float, root: np.ndarray, angles: np.ndarray
) -> SensorState:
    """A robot that has been at rest for as long as the history goes back.

    Args:
        config: of the sensors.
        dt: control period, s.
        root: pose and twist of the measured link, (13,).
        angles: of shape and vectoring joints, rad.
    """
    past = np.asarray(root, dtype=float)
    history = (past,) * history_depth(config, dt)
    return SensorState(
        history, past, np.asarray(angles, dtype=float), config.latency, initial_imu_state(config.imu, dt)
    )


def frame_numbers(config: SensorConfig, times: np.ndarray) -> np.ndarray:
    """Number of the frame seen at each tick, (k,)."""
    if config.rate == 0.0:
        return np.arange(len(times))
    return np.floor(times * config.rate + 1e-9).astype(int)


def frame_ages(config: SensorConfig, times: np.ndarray) -> np.ndarray:
    """Age of what is seen at each tick, s, (k,)."""
    if config.rate == 0.0:
        return np.full(len(times), config.latency)
    return config.latency + np.maximum(times - frame_numbers(config, times) / config.rate, 0.0)


def draw_noise(
    config: SensorConfig, times: np.ndarray, n_joints: int, n_vectoring: int, rng: np.random.Generator
) -> SensorNoise:
    """The errors of a whole run, each entry (k, width): a draw a frame, and one a tick for the encoders.

    The constant misalignment is among them, so that `sense` itself depends on no number of the
    configuration.
    """
    frames = frame_numbers(config, times)
    per_frame = rng.standard_normal((int(frames[-1]) + 1, 12))[frames] if len(times) else np.zeros((0, 12))
    per_tick = rng.standard_normal((len(times), n_joints + n_vectoring))
    return SensorNoise(
        per_frame[:, 0:3] * config.position_noise,
        per_frame[:, 3:6] * config.velocity_noise,
        per_frame[:, 6:9] * config.attitude_noise + np.asarray(config.attitude_misalignment),
        per_frame[:, 9:12] * config.angular_velocity_noise,
        per_tick[:, :n_joints] * config.joint_noise,
        per_tick[:, n_joints:] * config.vectoring_noise,
        # Last, so that a flight without an IMU keeps its noise.
        *draw_imu_errors(config.imu, len(times), rng),
    )


def sense(
    state: SensorState,
    root: Array,
    joint_angles: Array,
    vectoring_angles: Array,
    age: Any,
    noise: SensorNoise,
    dt: float,
    failure: SensorFailure,
    imu: tuple[ImuMotion, float, Any] | None = None,
) -> tuple[SensorState, Measurement]:
    """What the sensors say at this tick.

    Args:
        state: history of the last tick.
        root: true pose and twist of the measured link now, (13,); twist as (v in W, omega in the link).
        joint_angles: true q, rad.
        vectoring_angles: true psi, rad.
        age: of the frame seen now, s.
        noise: errors of this tick.
        dt: control period, s.
        failure: of this tick.
        imu: how the IMU moves, gravity (m/s^2), and the age of what it says, s.
    """
    rows = (root, *state.history[:-1])
    seen = between(rows, age * (1.0 / dt))
    quaternion = seen[3:7] / (seen[3] ** 2 + seen[4] ** 2 + seen[5] ** 2 + seen[6] ** 2) ** 0.5
    error = noise.attitude
    turned = quaternion_product(quaternion, vector(1.0, 0.5 * error[0], 0.5 * error[1], 0.5 * error[2]))
    turned = turned / (1.0 + 0.25 * (error[0] ** 2 + error[1] ** 2 + error[2] ** 2)) ** 0.5
    velocity = (1.0 + failure.velocity) * seen[7:10] + noise.velocity
    velocity = where(failure.stuck_velocity > 0.5, state.shown[7:10], velocity)
    omega = (1.0 + failure.rates) * seen[10:13] + noise.angular_velocity
    omega = where(failure.stuck_rates > 0.5, state.shown[10:13], omega)
    fresh = stack(seen[0:3] + noise.position, turned, velocity, omega)
    shown = where(failure.held + failure.frozen > 0.5, state.shown, fresh)
    age = where(failure.held > 0.5, state.age + dt, age)
    angles = stack(joint_angles + noise.joint_angles, vectoring_angles + noise.vectoring_angles)
    angles = where(failure.stuck_angles > 0.5, state.angles, angles)
    joints = noise.joint_angles.shape[0]
    measurement = Measurement(
        position=shown[0:3],
        quaternion=shown[3:7],
        velocity=shown[7:10],
        angular_velocity=shown[10:13],
        # Of no joints there is nothing to part: CasADi makes a row of what is left of a single symbol.
        joint_angles=angles[:joints] if joints else joint_angles,
        vectoring_angles=angles[joints:] if angles.shape[0] > joints else vectoring_angles,
        capture_age=age + failure.stamp,
    )
    state = SensorState(rows, shown, angles, age, state.imu)
    if imu is None or not isinstance(state.imu, ImuState):
        return state, measurement
    felt, said = sense_imu(state.imu, *imu, (noise.gyro, noise.accelerometer), dt)
    return state._replace(imu=felt), measurement._replace(imu=said)
