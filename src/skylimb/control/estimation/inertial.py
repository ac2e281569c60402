"""Where an IMU goes by its own rates and specific force, and what the motion capture corrects of it.

    R' = R omega^,    v' = R f - g,    p' = v        (omega and f less their biases)

A frame of the capture is as old as its stamp says, so it is held against where the body was then. What it
differs by corrects what is now, with a pole for each, and slowly the biases:

    x += (1 - exp(-pole dt)) e,    b' = rate pole e        (biases have the pole `rate`, behind that of x)

A frame older than the memory corrects nothing: the state goes on by the IMU alone, and comes back with the
frames. Rates come without the capture's latency, and without any model of what pushes the robot.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.base.rotations import rotation_error, small_rotation
from skylimb.control.estimation.records import Imu
from skylimb.robots.model import ImuPlace
from skylimb.symbolic import Array, between, clip, cross, exp

DEPTH = 16
"""Ticks that are remembered, this one among them."""

MEMORY = DEPTH - 1.0
"""Ticks that a frame may be old; at 200 Hz 75 ms. One that is older corrects nothing."""

_ZERO = np.zeros(3)


class Carried(NamedTuple):
    """How the IMU moves.

    Attributes:
        position: of its origin, W, m, (3,).
        velocity: W, m/s, (3,).
        R: its axes in W, (3, 3).
        rates: of its axes in them, rad/s, (3,).
        gyro_bias: of what it says of its rates, rad/s, (3,).
        accelerometer_bias: of its specific force, m/s^2, (3,).
    """

    position: Array = _ZERO
    velocity: Array = _ZERO
    R: Array = np.eye(3)
    rates: Array = _ZERO
    gyro_bias: Array = _ZERO
    accelerometer_bias: Array = _ZERO


class Place(NamedTuple):
    """Where the measured body is: position and velocity of its origin in W (m, m/s), axes, rates in them."""

    position: Array = _ZERO
    velocity: Array = _ZERO
    R: Array = np.eye(3)
    rates: Array = _ZERO


class Inertial(NamedTuple):
    """What is remembered: the IMU's motion, and where the body was at the last ticks, newest first."""

    imu: Carried = Carried()
    past: tuple[Place, ...] = (Place(),) * DEPTH


def carried(state: Carried, said: Imu, gravity: Array, dt: float) -> Carried:
    """How the IMU moves a tick later, by what it says alone: dead reckoning.

    Args:
        state: at the last tick.
        said: at this one.
        gravity: (3,) in W, upward, m/s^2.
        dt: control period, s.
    """
    rates, force = said.angular_velocity - state.gyro_bias, said.specific_force - state.accelerometer_bias
    R = state.R @ small_rotation((0.5 * dt) * (state.rates + rates))
    # The force is the mean over the tick in the axes at its end.
    velocity = state.velocity + dt * (R @ force - gravity)
    position = state.position + (0.5 * dt) * (state.velocity + velocity)
    return state._replace(position=position, velocity=velocity, R=R, rates=rates)


def body_of(state: Carried, place: ImuPlace) -> Place:
    """The measured body that carries an IMU which moves so."""
    R = state.R @ place.R.T
    rates = place.R @ state.rates - place.rates
    velocity = state.velocity - R @ (cross(rates, place.xyz) + place.velocity)
    return Place(state.position - R @ place.xyz, velocity, R, rates)


def imu_of(body: Place, place: ImuPlace) -> Carried:
    """The other way round; nothing is known of biases."""
    velocity = body.velocity + body.R @ (cross(body.rates, place.xyz) + place.velocity)
    rates = place.R.T @ (body.rates + place.rates)
    return Carried(body.position + body.R @ place.xyz, velocity, body.R @ place.R, rates)


def navigated(
    gains: Any,
    state: Inertial,
    said: Imu,
    seen: Place,
    age: Any,
    place: ImuPlace,
    started: Any,
    gravity: Array,
    dt: float,
) -> tuple[Inertial, Place]:
    """One step.

    Args:
        gains: poles `position`, `velocity` and `attitude`, rad/s, and the biases' `bias`.
        state: of the last tick.
        said: of the IMU.
        seen: by the motion capture.
        age: of what it saw, s.
        place: of the IMU in the measured body, now.
        started: 0 at the first tick, at which what is seen is believed, then 1.
        gravity: (3,) in W, upward, m/s^2.
        dt: control period, s.

    Returns:
        What is remembered, and the measured body now.
    """
    moved = carried(_begun(state.imu, imu_of(seen, place), started), said, gravity, dt)
    moved = _begun(moved, imu_of(seen, place), started)
    now = body_of(moved, place)
    past = (now, *(_begun(row, now, started) for row in state.past[:-1]))
    ticks = age * (1.0 / dt)
    then = Place(*(between(rows, ticks) for rows in zip(*past, strict=True)))
    # Of the body then, in its own axes; in those of the IMU it is the same turn.
    away = place.R.T @ rotation_error(then.R, seen.R)
    off, drift = then.position - seen.position, then.velocity - seen.velocity
    weight = started * clip(MEMORY - ticks, 0.0, 1.0)
    shares = {name: weight * (1.0 - exp(-getattr(gains, name) * dt)) for name in _CORRECTED}
    corrected = moved._replace(
        position=moved.position - shares["position"] * off,
        velocity=moved.velocity - shares["velocity"] * drift,
        R=moved.R @ small_rotation(-shares["attitude"] * away),
        gyro_bias=moved.gyro_bias + gains.bias * shares["attitude"] * away,
        accelerometer_bias=moved.accelerometer_bias + gains.bias * shares["velocity"] * (moved.R.T @ drift),
    )
    return Inertial(corrected, past), body_of(corrected, place)


_CORRECTED = ("position", "velocity", "attitude")


def _begun(kept: Any, first: Any, started: Any) -> Any:
    """A record as it is kept; what it is first before the first tick."""
    return type(kept)(*(one + started * (other - one) for one, other in zip(first, kept, strict=True)))
