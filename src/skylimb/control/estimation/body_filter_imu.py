"""What an IMU shows of the filter of a body: the wrench at once, and the rates without the capture's age.

The specific force at the IMU is what the model says of the last tick,

    R_IW (u + f) / m + R_IC (alpha x r + omega x (omega x r)) + bias,    alpha = I^-1 (tau_u + tau),

with r from the centre of gravity to the IMU. So it shows f and tau without a derivative of what is seen. That
the joints' servos give way is not in it: the accelerometer counts for less than its noise alone would say.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import hat
from skylimb.control.estimation.body_filter import (
    ACCELEROMETER,
    FORCE,
    GYRO,
    RATES,
    TORQUE,
    Biases,
    Filtered,
)
from skylimb.control.estimation.gates import BEYOND
from skylimb.control.estimation.kalman import Seen
from skylimb.control.estimation.records import Imu
from skylimb.robots.model import ImuPlace
from skylimb.robots.posed import RobotState
from skylimb.symbolic import cross, right_inverse, stack, where, within


@configuration
class ImuSpread:
    """What an IMU is off by; standard deviations."""

    on: Annotated[bool, Key("", "whether an IMU is used")] = False
    accelerometer: Annotated[
        float,
        Key("m/s^2", "error of its specific force, by what joints give way too", above=0.0, high=1e3),
    ] = 0.2
    gyro: Annotated[float, Key("rad/s", "error of its rates", above=0.0, high=1e2)] = 0.01
    accelerometer_bias: Annotated[
        float, Key("m/s^2", "bias of the specific force that may be at take-off", low=0.0, high=10.0)
    ] = 0.1
    gyro_bias: Annotated[float, Key("rad/s", "the same of the rates", low=0.0, high=1.0)] = 0.01
    accelerometer_drift: Annotated[
        float, Key("m/s^2", "how far the bias of the specific force drifts in a second", low=0.0, high=10.0)
    ] = 0.002
    gyro_drift: Annotated[float, Key("rad/s", "the same of the rates", low=0.0, high=1.0)] = 0.0002


def first_biases(gains: Any) -> tuple[float, ...]:
    """How sure biases are at take-off, (6,); nothing without an IMU."""
    return (gains.accelerometer_bias,) * 3 + (gains.gyro_bias,) * 3 if gains.on else ()


def drifts(gains: Any) -> tuple[Any, ...]:
    """Variances by which they spread in a second, (6,); nothing without an IMU."""
    return (gains.accelerometer_drift**2,) * 3 + (gains.gyro_drift**2,) * 3 if gains.on else ()


def felt(gains: Any, state: Filtered, said: Imu, place: ImuPlace, model: RobotState) -> tuple[Seen, ...]:
    """What an IMU shows of the filter's errors; what is no number does not count.

    Args:
        gains: an `ImuSpread`.
        state: moved to this tick; its known wrench is that of the last one.
        said: by the IMU.
        place: of it in the measured body.
        model: at the measured angles.
    """
    assert isinstance(state.biases, Biases)
    both = stack(said.specific_force, said.angular_velocity)
    good = within(both, -BEYOND, BEYOND)
    both = where(good > 0.5, both, np.zeros(6))
    counts = good * state.started
    inverse, omega = right_inverse(model.inertia_C), state.angular_velocity
    from_C, from_W = place.R.T @ model.R_root_C, place.R.T @ state.R_WB.T
    lever = model.R_root_C.T @ (place.xyz - model.cog_root)
    pushed = (state.known_force + state.force) / model.mass + model.gravity
    spin = inverse @ (state.known_torque + state.torque)
    force = from_W @ pushed + from_C @ (cross(spin, lever) + cross(omega, cross(omega, lever)))
    rates = from_C @ omega + place.R.T @ place.rates
    unit = np.eye(3)
    return (
        Seen(
            {
                FORCE: from_W / model.mass,
                TORQUE: -1.0 * (from_C @ hat(lever) @ inverse),
                ACCELEROMETER: unit,
            },
            both[0:3] - force - state.biases.accelerometer,
            gains.accelerometer,
            counts,
        ),
        Seen({RATES: from_C, GYRO: unit}, both[3:6] - rates - state.biases.gyro, gains.gyro, counts),
    )
