"""Find the surface and keep to it as `following` does, land and leave softly, and know the friction ahead.

Pressing tilts the robot, and a tilt moves the pen: 1 N of force is 20 mrad of hydrus_xi_quad, and 15 mm at
its tip. A press that comes or goes at once draws that as a tail. So it comes over `load_time` after a touch,
and goes over `unload_time` before the pen leaves.

What surface and friction are expected to push with across the contact axis goes to the laws after this one
(`ContactView.across`), so that force and torque are there when the path turns, not when the observer has seen
it.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, NamedTuple

from skylimb.control.contact import following
from skylimb.control.contact_machine import RETREAT, SETTLE, MachineState, is_in
from skylimb.control.needs import Needs
from skylimb.control.records import ContactView, LawInput
from skylimb.estimation.friction import (
    FrictionGains,
    FrictionState,
    direction,
    expected_across,
    follow_friction,
    initial_friction_state,
)
from skylimb.estimation.records import Signals, Start
from skylimb.keys import Key, configuration
from skylimb.spatial import cross, dot
from skylimb.symbolic import clip, vector, where


@configuration
class Gains(following.Gains):
    """Machine, surface estimate, pace, friction, and how the press comes and goes."""

    friction: FrictionGains = field(default_factory=FrictionGains)
    load_time: Annotated[
        float, Key("s", "time after a touch in which the press grows to what is wanted", above=0.0, high=60.0)
    ] = 0.8
    load_from: Annotated[
        float, Key("", "share of the wanted force with which it begins", low=0.05, high=1.0)
    ] = 0.5
    unload_time: Annotated[
        float, Key("s", "time in which the press goes before the pen leaves", above=0.0, high=60.0)
    ] = 0.8


class State(NamedTuple):
    """Of `following`; friction; whether the pen touched at the last tick, and 1 while the press goes."""

    following: following.State
    friction: FrictionState
    engaged: Any
    leaving: Any


def needs(gains: Gains) -> Needs:
    """It sets the pace."""
    return following.needs(gains)


def initial_state(gains: Gains, start: Start) -> State:
    """In the air, at rest."""
    return State(following.initial_state(gains, start), initial_friction_state(gains.friction), 0.0, 0.0)


def step(gains: Any, state: State, inputs: LawInput) -> tuple[State, ContactView, Signals]:
    """What `following` knows, softer at both ends, and the force across the axis that is expected now."""
    inner, view, signals = following.step(gains, state.following, inputs)
    reference, estimate = inputs.reference, inputs.estimate
    a, u = reference.contact_axis, reference.sliding_axis
    v = cross(a, u)

    leaving = _leaving(gains, state, inner.machine)
    ease = where(leaving > 0.5, 1.0 - inner.machine.since / gains.unload_time, _loaded(gains, inner.machine))
    engaged = clip(view.engaged + leaving, 0.0, 1.0)
    # The way back begins where the pen is when the press has gone.
    here = dot(a, estimate.body.position + estimate.arm)
    held = where(leaving > 0.5, here, inner.axis_position)
    inner = inner._replace(axis_position=held)
    view = view._replace(engaged=engaged, ease=view.ease * ease, axis_position=held)

    path = vector(dot(u, reference.tip_velocity), dot(v, reference.tip_velocity))
    seen = vector(dot(u, estimate.wrench.force), dot(v, estimate.wrench.force))
    share = view.ease * engaged
    friction = follow_friction(gains.friction, state.friction, seen, share, path, inputs.dt)
    across = expected_across(state.friction, share, direction(gains.friction, path))
    view = view._replace(across=u * across[0] + v * across[1])
    signals = {**signals, "friction_estimate": friction.friction}
    return State(inner, friction, engaged, leaving), view, signals


def _leaving(gains: Any, state: State, machine: MachineState) -> Any:
    """1 while the pen should leave and its press has not gone."""
    from_touch = where(state.engaged + state.leaving > 0.5, 1.0, 0.0)
    soon = where(machine.since < gains.unload_time, 1.0, 0.0)
    return is_in(machine.state, RETREAT) * soon * from_touch


def _loaded(gains: Any, machine: MachineState) -> Any:
    """Share of the press after a touch."""
    grown = clip(gains.load_from + (1.0 - gains.load_from) * machine.since / gains.load_time, 0.0, 1.0)
    return where(is_in(machine.state, SETTLE) > 0.5, grown, 1.0)
