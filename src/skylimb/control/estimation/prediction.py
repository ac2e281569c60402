"""Where the robot goes while nobody sees it: its own rotors and the estimated wrench, by its model.

The prediction is of what the sensors would show, latency included, so that it can stand in for a measurement.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.base.packing import chosen, numeric
from skylimb.base.rotations import quaternion_product, rotation_from_quaternion
from skylimb.control.estimation.body_state import (
    AngleRateFilter,
    AngleRateState,
    angle_rates,
    initial_angle_rate_state,
    rotor_wrench,
)
from skylimb.control.estimation.delay import DelayState, delayed_wrench, remember
from skylimb.control.estimation.momentum_observer import (
    ObserverGains,
    ObserverState,
    known_wrench,
    observe,
)
from skylimb.control.estimation.records import BodyState, Measurement
from skylimb.control.estimation.slip import slip_wrench
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState
from skylimb.symbolic import Array, cross, dot, low_pass, right_inverse, stack, vector, where

_FILTER = AngleRateFilter()
_OBSERVER = numeric(ObserverGains((10.0, 10.0, 10.0), (10.0, 10.0, 10.0)))

_MEAN, _VELOCITY, _RATES = 3.0, 10.0, 40.0
"""Poles of the wrench, the velocity and the rates that a blind flight begins with, 1/s: one measurement's
noise, or a velocity that is differenced, would lead it astray."""


class Motion(NamedTuple):
    """Where the model has the robot at the next measurement.

    Attributes:
        position: of the centre of gravity in W, m, (3,).
        velocity: W, m/s, (3,).
        quaternion: of the measured body.
        angular_velocity: of the measured body, in its own axes, rad/s, (3,).
    """

    position: Array
    velocity: Array
    quaternion: Array
    angular_velocity: Array


class Prediction(NamedTuple):
    """What a prediction remembers.

    Attributes:
        motion: predicted for this tick.
        angles: joint and vectoring angles that were last believed, rad.
        rates: of these.
        observer: of the external wrench.
        mean: of what it estimates beyond friction on the tip, W and C, N and N m, (6,): while nobody sees the
            robot this goes on to act, and friction with it.
        delay: wrenches that no measurement has shown yet.
        thrusts: that the rotors make, behind their lag, N, (n,).
    """

    motion: Motion
    angles: Array
    rates: AngleRateState
    observer: ObserverState
    mean: Array
    delay: DelayState
    thrusts: Array


def initial_prediction(robot: Robot, thrusts: np.ndarray) -> Prediction:
    """Before the first tick: nothing is known but the thrusts."""
    z3 = np.zeros(3)
    motion = Motion(z3, z3, np.array([1.0, 0.0, 0.0, 0.0]), z3)
    angles, rates = np.zeros(robot.n_joints + robot.n_vectoring), initial_angle_rate_state(robot)
    return Prediction(motion, angles, rates, ObserverState(), np.zeros(6), DelayState(), thrusts)


def differenced(state: Prediction, angles: Array, dt: float) -> tuple[Prediction, Array]:
    """The prediction that knows this tick's angles, and their rates."""
    rates, speeds = angle_rates(_FILTER, state.rates, angles, dt)
    return state._replace(rates=rates, angles=angles), speeds


def parted(angles: Array, n_joints: int) -> tuple[Array, Array]:
    """Joint angles and vectoring angles of all angles together.

    Of a single symbol CasADi makes a row where nothing is left, so nothing is nothing of NumPy's.
    """
    none = np.zeros(0)
    return angles[:n_joints] if n_joints else none, angles[n_joints:] if angles.shape[0] > n_joints else none


def shown(state: Prediction, model: RobotState, n_joints: int, speeds: Array) -> Measurement:
    """What the sensors should show at this tick; angles and their rates as they were given."""
    motion = state.motion
    R, lever = rotation_from_quaternion(motion.quaternion), model.cog_root
    q, psi = parted(state.angles, n_joints)
    moving = cross(motion.angular_velocity, lever) + model.cog_jacobian @ speeds
    return Measurement(
        position=motion.position - R @ lever,
        quaternion=motion.quaternion,
        velocity=motion.velocity - R @ moving,
        angular_velocity=motion.angular_velocity,
        joint_angles=q,
        vectoring_angles=psi,
    )


def seen(
    state: Prediction,
    measurement: Measurement,
    body: BodyState,
    speeds: Array,
    axis: Array,
    pose: Any,
    dt: float,
) -> Prediction:
    """The prediction that knows this tick's measurement.

    Args:
        state: of the last tick, with this tick's angles.
        measurement: of this tick, or in its place what `shown` says.
        body: its state by that.
        speeds: of joint and vectoring angles, rad/s.
        axis: into the surface, W, (3,); 0 where nothing is to touch.
        pose: 1 while poses are believed, else 0, and then the mean wrench goes on to act; and 1 where this
            one is another than before: until the next one comes the robot goes on as the model says, (2,).
        dt: control period, s.
    """
    observer, wrench = observe(_OBSERVER, state.observer, body, dt)
    rubs = slip_wrench(body, speeds, measurement.joint_angles.shape[0], state.mean[0:3], axis, dt)
    mean = where(pose[0] > 0.5, low_pass(state.mean, stack(*wrench) - rubs, _MEAN, dt), state.mean)
    felt = where(pose[0] > 0.5, stack(*wrench), mean + rubs)
    rates = body.model.R_root_C @ body.angular_velocity
    came = Motion(
        position=body.position,
        velocity=low_pass(state.motion.velocity, body.velocity, _VELOCITY, dt),
        quaternion=measurement.quaternion,
        angular_velocity=low_pass(state.motion.angular_velocity, rates, _RATES, dt),
    )
    observer = observer._replace(force=felt[0:3], torque=felt[3:6])
    motion = chosen(pose[1] > 0.5, came, state.motion)
    return state._replace(observer=observer, mean=mean, motion=motion)


def moved(
    state: Prediction, body: BodyState, thrusts: Array, left: Array, latency: Any, lag: Any, dt: float
) -> Prediction:
    """The prediction for the next tick.

    Args:
        state: that knows this tick's measurement.
        body: by it.
        thrusts: that are commanded, N, (n,).
        left: share that each rotor makes of it, (n,).
        latency: of the sensors, s.
        lag: time constant of the rotors, s; one for all, or one for each.
        dt: control period, s.
    """
    made = low_pass(state.thrusts, thrusts, 1.0 / lag, dt)
    delay = remember(state.delay, known_wrench(body, rotor_wrench(body, 0.5 * left * (state.thrusts + made))))
    known = delayed_wrench(latency, delay, dt)
    observer = state.observer._replace(known_force=known.force, known_torque=known.torque)
    model, last = body.model, state.motion
    push = (dt / model.mass) * (known.force + observer.force)
    spin = model.R_root_C @ (dt * (right_inverse(model.inertia_C) @ (known.torque + observer.torque)))
    turn = dt * (last.angular_velocity + 0.5 * spin)
    half = quaternion_product(last.quaternion, vector(1.0, 0.5 * turn[0], 0.5 * turn[1], 0.5 * turn[2]))
    motion = Motion(
        position=last.position + dt * (last.velocity + 0.5 * push),
        velocity=last.velocity + push,
        quaternion=half / dot(half, half) ** 0.5,
        angular_velocity=last.angular_velocity + spin,
    )
    return state._replace(motion=motion, observer=observer, delay=delay, thrusts=made)
