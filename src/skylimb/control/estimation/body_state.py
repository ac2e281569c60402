"""The centre of gravity's state from the measured body's pose and twist and the measured angles."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.control.estimation.records import BodyState, Measurement, Sensed, Wrench
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, cross, low_pass, matrix, stack


@configuration
class AngleRateFilter:
    """The low pass behind which the encoders' angles are differenced.

    30 rad/s pass the arm's motion (below 0.5 Hz) and keep the encoders' noise below that of motion capture
    for an observer of 3 1/s; a faster observer wants less of it.
    """

    bandwidth: Annotated[
        float,
        Key("rad/s", "low pass on the measured angles before they are differenced", above=0.0, high=1e4),
    ] = 30.0


class AngleRateState(NamedTuple):
    """State of the filtered difference of the measured angles.

    Attributes:
        smoothed: low-pass filtered joint and vectoring angles, rad.
        started: 0 before the first tick, 1 after it.
        rates: of the angles at the last tick, rad/s.
    """

    smoothed: Array
    started: float | Array
    rates: Array


def initial_angle_rate_state(robot: Robot) -> AngleRateState:
    """The state before the first tick."""
    still = np.zeros(robot.n_joints + robot.n_vectoring)
    return AngleRateState(still, 0.0, still)


def angle_rates(gains: Any, state: AngleRateState, angles: Array, dt: float) -> tuple[AngleRateState, Array]:
    """Angle rates: the slope of the low-passed angles, the filter's pole held exactly."""
    previous = state.smoothed * state.started + angles * (1.0 - state.started)
    smoothed = low_pass(previous, angles, gains.bandwidth, dt)
    rates = (smoothed - previous) * (1.0 / dt)
    return AngleRateState(smoothed, 1.0, rates), rates


def body_state(robot: Robot, measurement: Measurement, rates: Array) -> BodyState:
    """Position, velocity and attitude of {C} from those of the measured body.

    The velocity holds the arm's own motion: v_cog = v_B + R_WB (omega x p_BC + J_cog [q'; psi']). Without the
    last term a reaching arm looks like a moving robot, by several cm/s at the joints' speed limit. The
    turning of {C} inside the body is left out, as in the paper's quasi-static model.

    Args:
        robot: the controller's model; its measured link must be the root link.
        measurement: of this tick.
        rates: of the joint and vectoring angles, rad/s, (n_joints + n_vectoring,).
    """
    model = robot.at(measurement.joint_angles, measurement.vectoring_angles)
    R_WB = rotation_from_quaternion(measurement.quaternion)
    arm = model.cog_jacobian @ rates
    velocity = measurement.velocity + R_WB @ (cross(measurement.angular_velocity, model.cog_root) + arm)
    return BodyState(
        position=measurement.position + R_WB @ model.cog_root,
        velocity=velocity,
        R_WC=R_WB @ model.R_root_C,
        angular_velocity=model.R_root_C.T @ measurement.angular_velocity,
        model=model,
    )


def seen_from(body: BodyState, R_root_L: Array) -> BodyState:
    """The same body in other axes {L} of the measured link, in place of {C}'s, (3, 3).

    {C} stands where all rotors hover at their present angles. Where they turn to balances that the posture
    does not have, it turns by itself, and stands on its side where the rotors give no yaw.
    """
    model = body.model
    turn = R_root_L.T @ model.R_root_C
    lines, none = [[turn[i, j] for j in range(3)] for i in range(3)], [0.0] * 3
    both = matrix([line + none for line in lines] + [none + line for line in lines])
    model = model._replace(
        R_root_C=R_root_L,
        inertia_C=turn @ model.inertia_C @ turn.T,
        allocation_C=both @ model.allocation_C,
        tip_C=turn @ model.tip_C,
    )
    return body._replace(R_WC=body.R_WC @ turn.T, angular_velocity=turn @ body.angular_velocity, model=model)


def see_body(gains: Any, state: AngleRateState, sensed: Sensed) -> tuple[AngleRateState, BodyState]:
    """The body's state from a measurement; `gains` is an `AngleRateFilter`."""
    measurement = sensed.measurement
    angles = stack(measurement.joint_angles, measurement.vectoring_angles)
    state, rates = angle_rates(gains, state, angles, sensed.dt)
    return state, body_state(sensed.robot, measurement, rates)


def rotor_wrench(body: BodyState, thrusts: Array) -> Wrench:
    """What the rotors do, eq:allocation for wrench: force in W (N) and torque in C (N m)."""
    wrench = body.model.allocation_C @ thrusts
    return Wrench(body.R_WC @ wrench[0:3], wrench[3:6])
