"""The body's state, smoothed along its own motion.

Rotors and estimated wrench say how the robot moves between two measurements; each measurement then corrects
that motion with a pole of its own:

    x = a (x + dt f(x, u + w)) + (1 - a) x_measured,    a = exp(-bandwidth dt).

Motion that the rotors make comes without delay, the sensors' noise is low-passed. With the momentum
observer behind it (gain K, pole b) the wrench is K b / (s^2 + b s + K b) of the true one: at b = 4 K a double
pole at 2 K, about as fast as K alone, with far less of the noise.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import rotation_error, small_rotation
from skylimb.control.estimation.momentum_observer import ObserverState
from skylimb.control.estimation.records import BodyState
from skylimb.symbolic import Array, exp, low_pass, right_inverse


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


class Smoothed(NamedTuple):
    """The smoothed state of the last tick.

    Attributes:
        position: of the centre of gravity, W, m, (3,).
        velocity: W, m/s, (3,).
        R_WB: attitude of the measured body, (3, 3).
        angular_velocity: C, rad/s, (3,).
    """

    position: Array = np.zeros(3)
    velocity: Array = np.zeros(3)
    R_WB: Array = np.eye(3)
    angular_velocity: Array = np.zeros(3)


def smoothed(
    gains: Any, state: Smoothed, seen: BodyState, observer: ObserverState, dt: float
) -> tuple[Smoothed, BodyState]:
    """One step.

    Args:
        gains: a `Smoothing`.
        state: of the last tick.
        seen: as measured.
        observer: of the last tick: known and estimated wrench.
        dt: control period, s.
    """
    model, started = seen.model, observer.started
    force = observer.known_force + observer.force
    torque = observer.known_torque + observer.torque
    spin = dt * (right_inverse(model.inertia_C) @ torque)

    def corrected(moved: Array, measured: Array, pole: Any) -> Array:
        # Nothing is known of the motion before the first tick.
        return low_pass(measured + started * (moved - measured), measured, pole, dt)

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
