"""The body's state, smoothed along its own motion, which the model says, or an IMU.

Rotors and estimated wrench say how the robot moves between two measurements; each measurement then corrects
that motion with a pole of its own:

    x = a (x + dt f(x, u + w)) + (1 - a) x_measured,    a = exp(-bandwidth dt).

Motion that the rotors make comes without delay, the sensors' noise is low-passed. With the momentum
observer behind it (gain K, pole b) the wrench is K b / (s^2 + b s + K b) of the true one: at b = 4 K a double
pole at 2 K, about as fast as K alone, with far less of the noise.

With an IMU position, velocity and attitude are those of `inertial.py`, of now and not of the latest frame,
and the pole of the angular velocity is that of its rates. A pole should be below a quarter of the inverse of
the capture's latency there.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration, refused
from skylimb.base.rotations import rotation_error, rotation_from_quaternion, small_rotation
from skylimb.control.estimation.body_state import AngleRateState
from skylimb.control.estimation.inertial import Inertial, Place, navigated
from skylimb.control.estimation.momentum_observer import ObserverState
from skylimb.control.estimation.records import BodyState, Imu, Measurement, Sensed, Signals
from skylimb.robots.model import ImuPlace, Robot
from skylimb.symbolic import Array, cross, exp, low_pass, right_inverse


@configuration
class Smoothing:
    """How fast measurements correct the motion that the model says."""

    on: Annotated[bool, Key("", "whether the state is smoothed")] = False
    position: Annotated[float, Key("rad/s", "pole of the position", above=0.0, high=1e4)] = 20.0
    velocity: Annotated[float, Key("rad/s", "pole of the velocity", above=0.0, high=1e4)] = 40.0
    attitude: Annotated[float, Key("rad/s", "pole of the attitude", above=0.0, high=1e4)] = 40.0
    angular_velocity: Annotated[float, Key("rad/s", "pole of the angular velocity", above=0.0, high=1e4)] = (
        40.0
    )
    imu: Annotated[bool, Key("", "whether an IMU says the motion, not the model; needs on = true")] = False
    bias: Annotated[
        float, Key("rad/s", "pole of the IMU's biases, behind those of the state", low=0.0, high=1e3)
    ] = 0.3

    def check(self) -> None:
        """Refuse an IMU that nothing is made of."""
        if self.imu and not self.on:
            raise refused(self, "imu", "needs on = true beside it")


class Smoothed(NamedTuple):
    """The smoothed state of the last tick.

    Attributes:
        position: of the centre of gravity, W, m, (3,).
        velocity: W, m/s, (3,).
        R_WB: attitude of the measured body, (3, 3).
        angular_velocity: C, rad/s, (3,).
        inertial: what else is remembered with an IMU.
    """

    position: Array = np.zeros(3)
    velocity: Array = np.zeros(3)
    R_WB: Array = np.eye(3)
    angular_velocity: Array = np.zeros(3)
    inertial: Inertial | tuple[()] = ()


class Felt(NamedTuple):
    """What a state is made of with an IMU.

    Attributes:
        imu: what it says.
        seen: the measured body as the motion capture sees it.
        age: of that, s.
        place: of the IMU in the measured body.
        speeds: of joint and vectoring angles, rad/s.
    """

    imu: Imu
    seen: Place
    age: Any
    place: ImuPlace
    speeds: Array


def felt_of(robot: Robot, measurement: Measurement, speeds: Array) -> Felt | None:
    """What a measurement has of it; None without an IMU.

    Args:
        robot: the controller's model.
        measurement: of this tick.
        speeds: of joint and vectoring angles, rad/s.
    """
    if measurement.imu is None:
        return None
    R = rotation_from_quaternion(measurement.quaternion)
    seen = Place(measurement.position, measurement.velocity, R, measurement.angular_velocity)
    place = robot.imu_at(measurement.joint_angles, measurement.vectoring_angles, speeds)
    return Felt(measurement.imu, seen, measurement.capture_age, place, speeds)


def smoothed_body(
    gains: Any, state: Any, seen: BodyState, angles: AngleRateState, sensed: Sensed
) -> tuple[Smoothed | tuple[()], BodyState, Signals]:
    """What a law keeps, the body's state, as it is seen where nothing is smoothed, and what is recorded.

    Args:
        gains: a `Smoothing`.
        state: of the law at the last tick, with `smoothed` and `observer`.
        seen: as measured.
        angles: with the rates of joint and vectoring angles.
        sensed: of this tick.
    """
    kept, felt = state.smoothed, None
    if not isinstance(kept, Smoothed):
        return kept, seen, {}
    if gains.imu:
        felt = felt_of(sensed.robot, sensed.measurement, angles.rates)
    kept, body = smoothed(gains, kept, seen, state.observer, sensed.dt, felt)
    return kept, body, bias_signals(kept)


def bias_signals(kept: Smoothed) -> Signals:
    """What is recorded of an IMU's biases."""
    if not isinstance(kept.inertial, Inertial):
        return {}
    imu = kept.inertial.imu
    return {"gyro_bias_estimate": imu.gyro_bias, "accelerometer_bias_estimate": imu.accelerometer_bias}


def smoothed(
    gains: Any, state: Smoothed, seen: BodyState, observer: ObserverState, dt: float, felt: Felt | None = None
) -> tuple[Smoothed, BodyState]:
    """One step.

    Args:
        gains: a `Smoothing`.
        state: of the last tick.
        seen: as measured.
        observer: of the last tick: known and estimated wrench.
        dt: control period, s.
        felt: what an IMU says, where there is one.
    """
    model, started = seen.model, observer.started
    force = observer.known_force + observer.force
    torque = observer.known_torque + observer.torque
    spin = dt * (right_inverse(model.inertia_C) @ torque)

    def corrected(moved: Array, measured: Array, pole: Any) -> Array:
        # Nothing is known of the motion before the first tick.
        return low_pass(measured + started * (moved - measured), measured, pole, dt)

    if felt is not None and isinstance(state.inertial, Inertial):
        inertial, body = navigated(gains, state.inertial, *felt[:4], started, model.gravity, dt)
        omega, R_WC = model.R_root_C.T @ body.rates, body.R @ model.R_root_C
        angular = corrected(state.angular_velocity + spin, omega, gains.angular_velocity)
        lever = cross(body.rates, model.cog_root) + model.cog_jacobian @ felt.speeds
        position, velocity = body.position + body.R @ model.cog_root, body.velocity + body.R @ lever
        kept = Smoothed(position, velocity, body.R, angular, inertial)
        return kept, BodyState(position, velocity, R_WC, angular, model)
    push = (dt / model.mass) * force
    position = corrected(state.position + dt * (state.velocity + 0.5 * push), seen.position, gains.position)
    velocity = corrected(state.velocity + push, seen.velocity, gains.velocity)
    angular = corrected(state.angular_velocity + spin, seen.angular_velocity, gains.angular_velocity)
    measured = seen.R_WC @ model.R_root_C.T
    turn = model.R_root_C @ (dt * (state.angular_velocity + 0.5 * spin))
    away = rotation_error(state.R_WB @ small_rotation(turn), measured)
    share = exp(-gains.attitude * dt) * started
    R_WB = measured @ small_rotation(share * away)
    body = seen._replace(
        position=position, velocity=velocity, R_WC=R_WB @ model.R_root_C, angular_velocity=angular
    )
    return Smoothed(position, velocity, R_WB, angular), body
