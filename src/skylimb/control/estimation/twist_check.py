"""Whether velocity and rates fit the poses that come, and what stands in for those that do not.

A gyro that sticks is near to any prediction that it feeds, and so are the poses of the next tick. What it
hides adds up: over some tenths of a second the robot turns otherwise than its rates say. Per new pose

    error = way from the last pose to this one - sum of velocity times period,    off = fading sum of errors,

and the same of turns. Speeds that are scaled show long before that adds up to much: the errors go with the
ways. So they are held to a share of them as well,

    |mean of off . gone| <= least^2 + share * mean of gone . gone,    gone = fading sum of ways,

which is blind to errors that go another way, as noise makes them, or a twist that is some hundredths of a
second older or younger than its pose. Sensors that have stopped show soonest: they give the same bits while
poses change.

Once they do not fit they are not believed again. The model's take their place, drawn to the differences of
poses: its accelerations are fast, and differences know where it ends up.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import small_turn
from skylimb.control.estimation.records import Measurement
from skylimb.symbolic import Array, clip, dot, stack, where, within

FADES = 0.3
"""Time over which errors add up, s."""

SAME = 10
"""New poses without a bit of change in velocity, or in the rates: a sensor that works has noise."""

FOLLOWS = 30.0
"""How fast the model's twist follows the differences of poses, 1/s."""

STEP = 0.015
"""Greatest error that one pose adds, m or rad: a jump of the capture says nothing of the twist."""

LEAST = 0.15
"""Of how far twist and poses may be apart, below which no share is looked at: more than one pose comes to."""


@configuration
class TwistGates:
    """How far apart twist and poses may be."""

    twist_way: Annotated[
        float,
        Key(
            "m",
            "way in 0.3 s by which poses and velocity may differ; beyond, it is not believed",
            above=0.0,
            high=1e3,
        ),
    ] = 0.1
    twist_turn: Annotated[float, Key("rad", "the same of turns and rates", above=0.0, high=1e3)] = 0.12
    twist_share: Annotated[
        float,
        Key(
            "",
            "share of the way that poses go, along which velocity or rates may be off",
            above=0.0,
            high=1e3,
        ),
    ] = 0.35


class TwistCheck(NamedTuple):
    """What is remembered of twist and poses.

    Attributes:
        position: of the last new pose, W, m, (3,).
        quaternion: of it.
        time: since it, s.
        way: that the velocity says since it, m, (3,).
        turn: that the rates say since it, in the axes of the measured body, rad, (3,).
        off_way: fading sum of errors, m, (3,).
        off_turn: the same of turns, rad, (3,).
        gone_way: fading sum of the ways that poses go, m, (3,).
        gone_turn: the same of turns, rad, (3,).
        along_way: fading means of off . gone and of gone . gone, m^2, (2,).
        along_turn: the same of turns, rad^2, (2,).
        same_velocity: poses since the velocity changed a bit.
        same_rates: poses since the rates did.
        wrong: 1 from the first time on that they did not fit.
    """

    position: Array = np.zeros(3)
    quaternion: Array = np.array([1.0, 0.0, 0.0, 0.0])
    time: Any = 0.0
    way: Array = np.zeros(3)
    turn: Array = np.zeros(3)
    off_way: Array = np.zeros(3)
    off_turn: Array = np.zeros(3)
    gone_way: Array = np.zeros(3)
    gone_turn: Array = np.zeros(3)
    along_way: Array = np.zeros(2)
    along_turn: Array = np.zeros(2)
    same_velocity: Any = 0.0
    same_rates: Any = 0.0
    wrong: Any = 0.0


def check_twist(
    gates: Any,
    state: TwistCheck,
    measured: Measurement,
    before: Measurement,
    predicted: Measurement,
    sane: Any,
    new: Any,
    known: Any,
    dt: float,
) -> tuple[TwistCheck, Array, Array]:
    """Look at a twist.

    Args:
        gates: a `TwistGates`.
        state: what is remembered.
        measured: at this tick.
        before: at the tick before.
        predicted: what the model says.
        sane: 1 where nothing else is wrong with it.
        new: 1 where its pose is another one than before, and believed.
        known: 1 once a pose was believed before.
        dt: control period, s.

    Returns:
        What is remembered, and velocity and rates to go on with: as measured, or what stands in for them.
    """
    counts = new * known
    own = sane * (1.0 - state.wrong)
    velocity = where(own > 0.5, measured.velocity, predicted.velocity)
    rates = where(own > 0.5, measured.angular_velocity, predicted.angular_velocity)
    time, way, turn = state.time + dt, state.way + dt * velocity, state.turn + dt * rates
    off_way = clip(measured.position - state.position - way, -STEP, STEP)
    off_turn = clip(small_turn(state.quaternion, measured.quaternion) - turn, -STEP, STEP)
    fade = clip(1.0 - time / FADES, 0.0, 1.0)
    sum_way = where(counts > 0.5, fade * state.off_way + off_way, state.off_way)
    sum_turn = where(counts > 0.5, fade * state.off_turn + off_turn, state.off_turn)
    gone_way = where(counts > 0.5, fade * state.gone_way + way + off_way, state.gone_way)
    gone_turn = where(counts > 0.5, fade * state.gone_turn + turn + off_turn, state.gone_turn)
    along_way = where(counts > 0.5, _along(state.along_way, fade, sum_way, gone_way), state.along_way)
    along_turn = where(counts > 0.5, _along(state.along_turn, fade, sum_turn, gone_turn), state.along_turn)
    same_velocity = _same(state.same_velocity, measured.velocity - before.velocity, counts)
    same_rates = _same(state.same_rates, measured.angular_velocity - before.angular_velocity, counts)

    fits = within(dot(sum_way, sum_way), 0.0, gates.twist_way**2)
    fits = fits * within(dot(sum_turn, sum_turn), 0.0, gates.twist_turn**2)
    fits = fits * _unscaled(along_way, gates.twist_way, gates.twist_share)
    fits = fits * _unscaled(along_turn, gates.twist_turn, gates.twist_share)
    fits = fits * within(stack(same_velocity, same_rates), 0.0, SAME)
    wrong = where(fits > 0.5, state.wrong, 1.0)

    share = where(new > 0.5, clip(FOLLOWS * time, 0.0, 1.0), 0.0) / time
    velocity = where(wrong > 0.5, predicted.velocity + share * off_way, measured.velocity)
    rates = where(wrong > 0.5, predicted.angular_velocity + share * off_turn, measured.angular_velocity)
    found = TwistCheck(
        position=where(new > 0.5, measured.position, state.position),
        quaternion=where(new > 0.5, measured.quaternion, state.quaternion),
        time=where(new > 0.5, 0.0, time),
        way=where(new > 0.5, 0.0, way),
        turn=where(new > 0.5, 0.0, turn),
        off_way=sum_way,
        off_turn=sum_turn,
        gone_way=gone_way,
        gone_turn=gone_turn,
        along_way=along_way,
        along_turn=along_turn,
        same_velocity=same_velocity,
        same_rates=same_rates,
        wrong=wrong,
    )
    return found, velocity, rates


def _along(last: Array, fade: Any, off: Array, gone: Array) -> Array:
    """Fading means of off . gone and of gone . gone; after a gap a pose counts less."""
    return fade * (last + (1.0 - fade) * stack(dot(off, gone), dot(gone, gone)))


def _unscaled(along: Array, gate: float, share: float) -> Any:
    """1 where errors are no great share of the ways."""
    most = (LEAST * gate) ** 2 + share * along[1]
    return within(along[0], -most, most)


def _same(count: Any, change: Array, new: Any) -> Any:
    """New poses since something changed."""
    return where(within(change, 0.0, 0.0) > 0.5, count + new, 0.0)
