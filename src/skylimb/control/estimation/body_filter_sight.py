"""What a frame of motion capture shows of the filter of a body.

It is held against where the measured body was when the frame was made, as in `inertial.py`; a correction
moves that past along, so no frame corrects again what the one before it has corrected. A frame counts once.
One that is too old for the memory, and whatever is no place, does not count: the filter goes on by its model.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.base.rotations import hat, rotation_error, rotation_from_quaternion
from skylimb.control.estimation.body_filter import ATTITUDE, POSITION, RATES, VELOCITY, Filtered
from skylimb.control.estimation.gates import BEYOND, numbers
from skylimb.control.estimation.inertial import DEPTH, MEMORY, Place
from skylimb.control.estimation.kalman import Seen
from skylimb.control.estimation.records import Measurement
from skylimb.robots.posed import RobotState
from skylimb.symbolic import Array, between, clip, cross, dot, stack, where, within


def frame_of(measurement: Measurement) -> tuple[Place, Any]:
    """Where the motion capture sees the body, and 1; another place and 0 where it is no place."""
    nowhere = np.eye(13)[3]
    pose = stack(*measurement[:4])
    size = dot(measurement.quaternion, measurement.quaternion)
    good = within(pose, -BEYOND, BEYOND) * within(size, 0.81, 1.21)
    pose = where(good > 0.5, pose, nowhere)
    size = where(good > 0.5, size, 1.0)
    R = rotation_from_quaternion(pose[3:7] / size**0.5)
    return Place(pose[0:3], pose[7:10], R, pose[10:13]), good


def placed(state: Filtered, model: RobotState, arm: Array) -> Place:
    """Where the filter has the measured body.

    Args:
        state: of now.
        model: at the measured angles.
        arm: velocity of the centre of gravity in the body, body axes, m/s, (3,).
    """
    rates = model.R_root_C @ state.angular_velocity
    velocity = state.velocity - state.R_WB @ (cross(rates, model.cog_root) + arm)
    return Place(state.position - state.R_WB @ model.cog_root, velocity, state.R_WB, rates)


def looked(
    gains: Any, state: Filtered, measurement: Measurement, model: RobotState, arm: Array, dt: float
) -> tuple[Filtered, tuple[Seen, ...]]:
    """What a frame shows of the filter's errors, and the filter that remembers where the body is.

    The first frame that is one is believed.

    Args:
        gains: a `Spread`.
        state: moved to this tick.
        measurement: of this tick.
        model: at the measured angles.
        arm: velocity of the centre of gravity in the body, body axes, m/s, (3,).
        dt: control period, s.
    """
    seen, good = frame_of(measurement)
    known = state.started
    state = _begun(state, seen, model, arm)
    now = placed(state, model, arm)
    past = (now, *(_either(known, row, now) for row in state.past[:-1]))
    age = numbers(measurement.capture_age, DEPTH * dt)
    ticks = clip(age * (1.0 / dt), 0.0, MEMORY)
    then = Place(*(between(rows, ticks) for rows in zip(*past, strict=True)))
    fresh = where(age < state.age + 0.5 * dt, 1.0, 0.0)
    counts = good * fresh * known * where(age * (1.0 / dt) < MEMORY, 1.0, 0.0)
    to_C, unit = model.R_root_C.T, np.eye(3)
    lever = state.R_WB @ hat(model.cog_root) @ model.R_root_C
    frame = (
        Seen({POSITION: unit, ATTITUDE: lever}, seen.position - then.position, gains.position, counts),
        Seen({VELOCITY: unit, RATES: lever}, seen.velocity - then.velocity, gains.velocity, counts),
        Seen({ATTITUDE: unit}, to_C @ rotation_error(seen.R, then.R), gains.attitude, counts),
        Seen({RATES: unit}, to_C @ (seen.rates - then.rates), gains.rates, counts),
    )
    started = where(known + good > 0.5, 1.0, 0.0)
    return state._replace(past=past, age=age, started=started), frame


def _begun(state: Filtered, seen: Place, model: RobotState, arm: Array) -> Filtered:
    """The filter as it is; before the first frame, what is seen."""
    kept = Place(state.position, state.velocity, state.R_WB, state.angular_velocity)
    velocity = seen.velocity + seen.R @ (cross(seen.rates, model.cog_root) + arm)
    first = Place(seen.position + seen.R @ model.cog_root, velocity, seen.R, model.R_root_C.T @ seen.rates)
    position, velocity, R, rates = _either(state.started, kept, first)
    return state._replace(position=position, velocity=velocity, R_WB=R, angular_velocity=rates)


def _either(started: Any, kept: Place, first: Place) -> Place:
    """A place as it is kept, or what it is first."""
    return Place(*(where(started > 0.5, one, other) for one, other in zip(kept, first, strict=True)))
