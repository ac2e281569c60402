"""An IMU on its link of the robot: rates and specific force, with noise and bias.

The rates are the link's own, so the joints' are in them. The specific force is the acceleration of the IMU's
origin without gravity's share: at rest g along up, nothing in free fall. It is the change of that point's
velocity over the last tick, which an IMU that integrates on board reports too. So it holds every impulse of
the contact, and needs no more of an engine than positions and velocities.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.control.estimation.records import Imu
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, between, cross, stack, vector

_Z3 = np.zeros(3)


@configuration
class ImuConfig:
    """The IMU. Noise as standard deviations; biases stay for the flight."""

    on: Annotated[bool, Key("", "whether the robot has one")] = False
    latency: Annotated[float, Key("s", "age of what it says", low=0.0, high=0.05)] = 0.0
    gyro_noise: Annotated[float, Key("rad/s", "noise of the rates", low=0.0, high=1.0)] = 0.002
    accelerometer_noise: Annotated[float, Key("m/s^2", "noise of the specific force", low=0.0, high=10.0)] = (
        0.05
    )
    gyro_bias_drawn: Annotated[
        float, Key("rad/s", "bias of the rates that is drawn from the seed", low=0.0, high=1.0)
    ] = 0.002
    accelerometer_bias_drawn: Annotated[
        float, Key("m/s^2", "bias of the specific force that is drawn from the seed", low=0.0, high=10.0)
    ] = 0.05
    gyro_bias: Annotated[Vector3, Key("rad/s", "bias of the rates besides", low=-1.0, high=1.0)] = (
        0.0,
        0.0,
        0.0,
    )
    accelerometer_bias: Annotated[
        Vector3, Key("m/s^2", "bias of the specific force besides", low=-10.0, high=10.0)
    ] = (0.0, 0.0, 0.0)


class ImuMotion(NamedTuple):
    """How the IMU really moves: its axes in W, velocity in W (m/s), rates in its axes (rad/s)."""

    R: Array
    velocity: Array
    rates: Array


class ImuState(NamedTuple):
    """What a tick hands on to the next.

    Attributes:
        velocity: of the IMU's origin at the last tick, W, m/s, (3,).
        history: true rates and specific force of the last ticks, newest first, (6,) each.
        started: 0 before the first tick, 1 after it.
    """

    velocity: Array
    history: tuple[Array, ...]
    started: float | Array = 0.0


def initial_imu_state(config: ImuConfig, dt: float) -> ImuState | tuple[()]:
    """The state before the first tick; nothing where there is no IMU."""
    depth = math.ceil(config.latency / dt - 1e-9) + 1
    return ImuState(_Z3, (np.zeros(6),) * depth) if config.on else ()


def draw_imu_errors(config: ImuConfig, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Errors of rates and specific force, (count, 3) each."""
    if not config.on:
        return np.zeros((count, 3)), np.zeros((count, 3))
    gyro, accelerometer = np.split(rng.standard_normal((count + 1, 6)), 2, axis=1)
    return (
        gyro[1:] * config.gyro_noise + gyro[0] * config.gyro_bias_drawn + np.array(config.gyro_bias),
        accelerometer[1:] * config.accelerometer_noise
        + accelerometer[0] * config.accelerometer_bias_drawn
        + np.array(config.accelerometer_bias),
    )


def imu_motion(
    robot: Robot, root: Array, joint_angles: Array, vectoring_angles: Array, rates: Array
) -> ImuMotion:
    """How the IMU moves.

    Args:
        robot: that really flies.
        root: pose and twist of the root link, (13,); twist as (v in W, omega in the link).
        joint_angles: q, rad.
        vectoring_angles: psi, rad.
        rates: of both, rad/s.
    """
    imu = robot.imu_at(joint_angles, vectoring_angles, rates)
    R_WB, omega = rotation_from_quaternion(root[3:7]), root[10:13]
    velocity = root[7:10] + R_WB @ (cross(omega, imu.xyz) + imu.velocity)
    return ImuMotion(R_WB @ imu.R, velocity, imu.R.T @ (omega + imu.rates))


def sense_imu(
    state: ImuState, motion: ImuMotion, gravity: float, age: Any, errors: tuple[Array, Array], dt: float
) -> tuple[ImuState, Imu]:
    """What the IMU says at this tick.

    Args:
        state: of the last tick.
        motion: now.
        gravity: m/s^2.
        age: of what it says, s.
        errors: of rates and specific force.
        dt: control period, s.
    """
    # Before the first tick it has moved as it does now.
    gained = state.started * (motion.velocity - state.velocity)
    now = stack(motion.rates, motion.R.T @ (gained * (1.0 / dt) + vector(0.0, 0.0, gravity)))
    rows = (now, *(now + state.started * (row - now) for row in state.history[:-1]))
    seen = between(rows, age * (1.0 / dt))
    return ImuState(motion.velocity, rows, 1.0), Imu(seen[0:3] + errors[0], seen[3:6] + errors[1])
