"""Admittance of the tip in six directions: soft where it may give way, a wanted force or torque elsewhere.

In the axes of the task, with x the way of the tip's target from its reference, along and about each axis,

    M x'' + D x' + K x = w + w_push,

with w the wrench on the robot at its tip and w_push what the tip shall push with. Along an axis with K = 0
the target goes on until the push is w_push: force or torque is kept there. Along an axis with K > 0 the tip
gives way by w / K. It is the admittance of the paper's arm, eq:admittance control, in all directions of the
task frame (Mason, IEEE Trans. SMC 11(6), 1981), and there is nothing to switch between the two.

The push comes after the approach, as a target that runs ahead lands hard. It does not go on against rotors
that are at their limits. Once touch is no longer wanted, the target goes back to the reference. Along an axis
with a spring it still gives way then: what pushed the tip aside, a lever or the walls of a hole, may lie
between it and its reference until it is out.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.needs import Needs
from skylimb.control.press import LOADING, PLAIN, wanted_force
from skylimb.control.records import NOTHING, ContactView, LawInput, TipMove
from skylimb.control.task_frame import task_axes, tip_wrench
from skylimb.control.windup import unless_short
from skylimb.symbolic import Array, clip, cross, low_pass, vector, where

PROVIDES = ("contact.engaged", "contact.normal_force", "contact.tip")
REQUIRES = ("estimate.body", "estimate.wrench")
OPTIONAL = {"residual": ""}

_AXES = "along the contact axis, u and v"
_ABOUT = "about the contact axis, u and v"
LOADED = 0.95
"""Share of the push from which all of it has come."""
_HOME, _TURN_HOME = 2.0, 0.5
"""Rates at which a target goes back, and turns back, out of touch, 1/s: a body that swings back quickly while
its face still lies on a surface throws itself off."""


@configuration
class Gains:
    """Virtual mass, damper and spring of the tip, its push, and how far its target may go."""

    mass: Annotated[Vector3, Key("kg", f"virtual mass {_AXES}", above=0.0, high=1e4)] = (4.0, 4.0, 4.0)
    damping: Annotated[Vector3, Key("N s/m", f"virtual damper {_AXES}", above=0.0, high=1e6)] = (
        30.0,
        200.0,
        200.0,
    )
    stiffness: Annotated[
        Vector3, Key("N/m", f"virtual spring {_AXES}; 0 where the force is kept", low=0.0, high=1e6)
    ] = (0.0, 2000.0, 2000.0)
    inertia: Annotated[Vector3, Key("kg m^2", f"virtual inertia {_ABOUT}", above=0.0, high=1e4)] = (
        1.0,
        1.0,
        1.0,
    )
    turn_damping: Annotated[Vector3, Key("N m s/rad", f"virtual damper {_ABOUT}", above=0.0, high=1e6)] = (
        50.0,
        50.0,
        50.0,
    )
    turn_stiffness: Annotated[
        Vector3, Key("N m/rad", f"virtual spring {_ABOUT}; 0 where the torque is kept", low=0.0, high=1e6)
    ] = (500.0, 500.0, 500.0)
    force: Annotated[
        Vector3, Key("N", f"wanted push of the tip on its surroundings {_AXES}", low=-20.0, high=20.0)
    ] = (1.0, 0.0, 0.0)
    torque: Annotated[
        Vector3, Key("N m", f"wanted torque of the tip on its surroundings {_ABOUT}", low=-5.0, high=5.0)
    ] = (0.0, 0.0, 0.0)
    load_time: Annotated[
        float, Key("s", "time constant with which the push comes after the approach", above=0.0, high=60.0)
    ] = 0.5
    travel: Annotated[float, Key("m", "greatest way of the target along an axis", above=0.0, high=2.0)] = 0.6
    turn: Annotated[float, Key("rad", "greatest turn of the target about an axis", above=0.0, high=1.0)] = 0.6
    speed: Annotated[
        float, Key("m/s", "greatest speed of the target along an axis", above=0.0, high=10.0)
    ] = 0.05
    turn_speed: Annotated[
        float, Key("rad/s", "greatest speed of the target about an axis", above=0.0, high=10.0)
    ] = 0.2


class State(NamedTuple):
    """The target's way from its reference.

    Attributes:
        way: along the task's axes, m, (3,).
        rate: of it, m/s, (3,).
        turn: about the task's axes, rad, (3,).
        turn_rate: of it, rad/s, (3,).
        place: the way in W, m, (3,); the task's axes may turn.
        rotation: the turn in W, rad, (3,).
        axes: R_WT of the last tick, (3, 3); zeros before the first.
        load: share of the push that has come.
        met: 1 from the first touch on.
    """

    way: Array
    rate: Array
    turn: Array
    turn_rate: Array
    place: Array
    rotation: Array
    axes: Array
    load: Any
    met: Any


def needs(gains: Gains) -> Needs:
    """The force along the contact axis that is commanded."""
    return Needs(force=max(gains.force[0], 0.0))


def initial_state(gains: Gains, start: Start) -> State:
    """The target is the reference."""
    z3 = np.zeros(3)
    return State(z3, z3, z3, z3, z3, z3, np.zeros((3, 3)), 0.0, 0.0)


def step(gains: Any, state: State, inputs: LawInput) -> tuple[State, ContactView, Signals]:
    """Where the tip's target is, and what it feels."""
    reference, estimate, dt = inputs.reference, inputs.estimate, inputs.dt
    touch, R_WT, short = reference.touch, task_axes(reference), inputs.residual or NOTHING
    felt = tip_wrench(estimate, R_WT)
    load = low_pass(state.load, reference.wait, 1.0 / gains.load_time, dt)
    met = where(touch > 0.5, 1.0, state.met)
    soft = where(gains.stiffness > 0.0, met, touch)
    turn_soft = where(gains.turn_stiffness > 0.0, met, touch)
    force = vector(wanted_force(reference.force, gains.force[0]), gains.force[1], gains.force[2])
    push = unless_short(soft * felt.force + touch * load * force, R_WT.T @ short.force)
    twist = unless_short(
        turn_soft * felt.torque + touch * load * gains.torque,
        R_WT.T @ (estimate.body.R_WC @ short.torque),
    )
    along = Spring(gains.mass, gains.damping, _held(gains.stiffness, _HOME * gains.damping, soft))
    about = Spring(
        gains.inertia,
        gains.turn_damping,
        _held(gains.turn_stiffness, _TURN_HOME * gains.turn_damping, turn_soft),
    )
    way, rate = advance(along, state.way, state.rate, push, (gains.travel, gains.speed), dt)
    turn, turn_rate = advance(about, state.turn, state.turn_rate, twist, (gains.turn, gains.turn_speed), dt)
    place, rotation = R_WT @ way, R_WT @ turn
    moved, turned = (place - state.place) * (1.0 / dt), (rotation - state.rotation) * (1.0 / dt)
    turned = turned + turning_rate(state.axes, R_WT, dt)
    view = ContactView(
        engaged=touch, normal_force=-felt.force[0], tip=TipMove(place, moved, rotation, turned)
    )
    signals = {
        "contact_force_reference": force[0] * load * reference.wait,
        "contact_force_target": force[0] * load * touch,
        "press_reason": where(reference.wait * where(load < LOADED, 1.0, 0.0) > 0.5, LOADING, PLAIN),
        "tip_force_estimate": felt.force,
        "tip_torque_estimate": felt.torque,
        "tip_move": way,
        "tip_turn": turn,
    }
    return State(way, rate, turn, turn_rate, place, rotation, R_WT, load, met), view, signals


def turning_rate(before: Array, now: Array, dt: float) -> Array:
    """Rate at which axes turn, the half sum of e_i x e_i' over them, rad/s, (3,).

    Args:
        before: axes of the last tick as columns, (3, 3); zeros give no rate.
        now: axes of this tick.
        dt: s.
    """
    return sum(cross(now[:, i], now[:, i] - before[:, i]) for i in range(3)) * (0.5 / dt)


class Spring(NamedTuple):
    """Mass, damper and spring along three axes, or inertia and the like about them, (3,) each."""

    mass: Array
    damping: Array
    stiffness: Array


def _held(stiffness: Array, home: Array, soft: Array) -> Array:
    """The spring; where the tip does not give way it is at least the one with which the target goes home."""
    return where(soft > 0.5, stiffness, where(stiffness > home, stiffness, home))


def advance(
    spring: Spring, way: Array, rate: Array, wrench: Array, limits: tuple[Any, Any], dt: float
) -> tuple[Array, Array]:
    """Way and rate one tick later, each (3,).

    Damper and spring act with rate and way at the end of the tick, so that no gain is too stiff for it.

    Args:
        spring: mass, damper and spring.
        way: now, m or rad.
        rate: now, m/s or rad/s.
        wrench: on it, N or N m.
        limits: greatest way and rate.
        dt: s.
    """
    push = wrench - spring.stiffness * way
    heavy = spring.mass + dt * (spring.damping + dt * spring.stiffness)
    free = clip((spring.mass * rate + dt * push) / heavy, -limits[1], limits[1])
    there = clip(way + free * dt, -limits[0], limits[0])
    return there, (there - way) * (1.0 / dt)
