"""An extended Kalman filter of a body that something pushes: its motion, the wrench, an IMU's biases.

    p' = v,    m v' = u + f - m g,    R' = R omega^,    I omega' = tau_u - omega x I omega + tau,
    f' = white,    tau' = white,      and each bias likewise

u and tau_u are what the rotors make. An error of the attitude turns u, so both halves are one filter, of 18
numbers (24 with an IMU). Its covariance weighs each measurement by what is known at the moment.
`body_filter_sight.py` says what a frame of motion capture shows of it, `body_filter_imu.py` what an IMU does.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import hat, small_rotation
from skylimb.control.estimation.inertial import DEPTH, Place
from skylimb.control.estimation.kalman import Seen, mirrored, propagated, taken_in, unit_but_for
from skylimb.control.estimation.records import BodyState
from skylimb.robots.posed import RobotState
from skylimb.symbolic import Array, right_inverse, stack

POSITION, VELOCITY, ATTITUDE, RATES, FORCE, TORQUE, ACCELEROMETER, GYRO = range(0, 24, 3)
"""Where each error begins in the filter's vector; that of the attitude is a turn about the axes of C."""

_FIRST = (1.0, 0.1)
"""Standard deviations of force (N) and torque (N m) before the first tick."""
_ZERO = np.zeros(3)


@configuration
class Spread:
    """What drifts, and what a frame of motion capture is off by; standard deviations."""

    force: Annotated[
        float, Key("N", "how far the external force drifts in a second", above=0.0, high=1e3)
    ] = 0.35
    torque: Annotated[
        float, Key("N m", "how far the external torque drifts in a second", above=0.0, high=1e3)
    ] = 0.03
    jolts: Annotated[
        float, Key("m/s", "how far the velocity drifts in a second, besides by forces", low=0.0, high=100.0)
    ] = 0.005
    twists: Annotated[
        float, Key("rad/s", "the same of the rates, besides by torques", low=0.0, high=100.0)
    ] = 0.05
    position: Annotated[float, Key("m", "error of a frame's position", above=0.0, high=1.0)] = 0.003
    velocity: Annotated[
        float, Key("m/s", "error of its velocity, and of the arm's in it", above=0.0, high=10.0)
    ] = 0.008
    attitude: Annotated[float, Key("rad", "error of its attitude", above=0.0, high=1.0)] = 0.001
    rates: Annotated[float, Key("rad/s", "error of its angular velocity", above=0.0, high=10.0)] = 0.01


class Biases(NamedTuple):
    """Of an IMU, in its axes: specific force (m/s^2, (3,)) and rates (rad/s, (3,))."""

    accelerometer: Array = _ZERO
    gyro: Array = _ZERO


class Filtered(NamedTuple):
    """State of the filter; without arguments it is that before the first tick.

    Attributes:
        position: of the centre of gravity, W, m, (3,).
        velocity: W, m/s, (3,).
        R_WB: attitude of the measured body, (3, 3).
        angular_velocity: C, rad/s, (3,).
        force: external, W, N, (3,).
        torque: external, C, N m, (3,).
        biases: of an IMU; nothing without one.
        covariance: of the errors of all these, in this order.
        past: where the measured body was at the last ticks, newest first.
        known_force: rotor force less weight, W, N, (3,).
        known_torque: rotor torque less omega x I omega, C, N m, (3,).
        age: of the frame that was seen last, s.
        started: 0 before the first frame, 1 after it.
    """

    position: Array = _ZERO
    velocity: Array = _ZERO
    R_WB: Array = np.eye(3)
    angular_velocity: Array = _ZERO
    force: Array = _ZERO
    torque: Array = _ZERO
    biases: Biases | tuple[()] = ()
    covariance: Array = np.zeros((18, 18))
    past: tuple[Place, ...] = (Place(),) * DEPTH
    known_force: Array = _ZERO
    known_torque: Array = _ZERO
    age: Any = 0.0
    started: Any = 0.0


def initial_filter(gains: Spread, imu: tuple[float, ...] = ()) -> Filtered:
    """Nothing is known of any wrench, nor of the place before a frame shows it.

    Args:
        gains: say how sure the first frame is.
        imu: how sure an IMU's biases are, standard deviations, (6,); none without one.
    """
    each = (gains.position, gains.velocity, gains.attitude, gains.rates, *_FIRST)
    sizes = (*(size for size in each for _ in range(3)), *imu)
    return Filtered(biases=Biases() if imu else (), covariance=np.diag(np.square(sizes)))


def body_of(state: Filtered, model: RobotState) -> BodyState:
    """The body's state as the filter has it."""
    R_WC = state.R_WB @ model.R_root_C
    return BodyState(state.position, state.velocity, R_WC, state.angular_velocity, model)


def moved(gains: Any, state: Filtered, drifts: tuple[Any, ...], model: RobotState, dt: float) -> Filtered:
    """The filter a tick later, by the model alone.

    Args:
        gains: a `Spread`.
        state: at the last tick, with the known wrench that acted since.
        drifts: variances by which an IMU's biases spread in a second, (6,); none without one.
        model: at this tick's angles.
        dt: control period, s.
    """
    inverse, mass, R_WC = right_inverse(model.inertia_C), model.mass, state.R_WB @ model.R_root_C
    push = (dt / mass) * (state.known_force + state.force)
    spin = dt * (inverse @ (state.known_torque + state.torque))
    turn = model.R_root_C @ (dt * (state.angular_velocity + 0.5 * spin))
    rotors = state.known_force + mass * model.gravity
    unit = np.eye(3)
    F = unit_but_for(
        state.covariance.shape[0],
        {
            (POSITION, VELOCITY): dt * unit,
            (VELOCITY, ATTITUDE): (-dt / mass) * (hat(rotors) @ R_WC),
            (VELOCITY, FORCE): (dt / mass) * unit,
            (ATTITUDE, RATES): dt * unit,
            (RATES, TORQUE): dt * inverse,
        },
    )
    each = (0.0, gains.jolts, 0.0, gains.twists, gains.force, gains.torque)
    drift = stack(*(size**2 for size in each for _ in range(3)), *drifts)
    return state._replace(
        position=state.position + dt * (state.velocity + 0.5 * push),
        velocity=state.velocity + push,
        R_WB=state.R_WB @ small_rotation(turn),
        angular_velocity=state.angular_velocity + spin,
        covariance=mirrored(propagated(state.covariance, F, dt * drift)),
    )


def settled(state: Filtered, model: RobotState, measured: tuple[Seen, ...]) -> Filtered:
    """The filter that knows what was measured; so does its past."""
    x, P = taken_in(state.covariance, measured)
    turn = model.R_root_C @ x[ATTITUDE : ATTITUDE + 3]
    spin = model.R_root_C @ x[RATES : RATES + 3]
    lever = state.R_WB @ hat(model.cog_root)
    way, drift = x[POSITION : POSITION + 3] + lever @ turn, x[VELOCITY : VELOCITY + 3] + lever @ spin
    R, biases = small_rotation(turn), state.biases
    if isinstance(biases, Biases):
        biases = Biases(
            biases.accelerometer + x[ACCELEROMETER : ACCELEROMETER + 3], biases.gyro + x[GYRO : GYRO + 3]
        )
    past = tuple(
        Place(row.position + way, row.velocity + drift, row.R @ R, row.rates + spin) for row in state.past
    )
    return state._replace(
        position=state.position + x[POSITION : POSITION + 3],
        velocity=state.velocity + x[VELOCITY : VELOCITY + 3],
        R_WB=state.R_WB @ R,
        angular_velocity=state.angular_velocity + x[RATES : RATES + 3],
        force=state.force + x[FORCE : FORCE + 3],
        torque=state.torque + x[TORQUE : TORQUE + 3],
        biases=biases,
        covariance=P,
        past=past,
    )
