"""Find the surface and keep to it as `following` does, land and leave softly, and know the friction ahead.

Pressing tilts the robot, and a tilt moves the pen: 1 N of force is 20 mrad of hydrus_xi_quad, and 15 mm at
its tip. A press that comes or goes at once draws that as a tail. So it comes over `load_time` after a touch,
and it goes before the pen leaves: at the end of a stroke, which the mission shows `AHEAD`, the path rests for
`unload_time` while the press goes down to a share `unload_to`. The force follows that ramp late, so the
command is `unload_lead` ahead of it. Then the pen leaves, and that share goes over `leave_time`. It goes back
from where it is, by `hop` at least: the mission's way out begins at the nominal surface, which may lie behind
the real one.

What surface and friction are expected to push with across the contact axis goes to the laws after this one
(`ContactView.across`), so that force and torque are there when the path turns, not when the observer has seen
it. Before the first slide nothing of that is known: until the path goes on, `ContactView.landing` says so.
"""

from __future__ import annotations

from dataclasses import field, replace
from typing import Annotated, Any, NamedTuple

from skylimb.base.keys import Key, configuration
from skylimb.control.contact.laws import following
from skylimb.control.contact.lead import is_lifted
from skylimb.control.contact.machine import FREE, RETREAT, MachineState, is_in
from skylimb.control.estimation.friction import (
    Climbed,
    FrictionGains,
    FrictionState,
    direction,
    expected_across,
    follow_friction,
    initial_friction_state,
)
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.needs import Needs
from skylimb.control.press import EASED, LOADING, UNLOADING, wanted_force
from skylimb.control.records import ContactView, LawInput, Reference
from skylimb.symbolic import Array, clip, cross, dot, max, min, norm, sqrt, vector, where

PROVIDES = (*following.PROVIDES, "contact.across", "contact.landing", "contact.own_speed")
REQUIRES, OPTIONAL = following.REQUIRES, following.OPTIONAL

AHEAD, SEEN = 0.05, 1.5
"""How long before the end of a stroke the path rests, and how long before that is known, on its clock, s."""

GOES, LANDING_TIME = 0.005, 0.3
"""Speed of a path that goes on, m/s; time constant in which a landing is over then, s."""

OWN_PACE = 0.05
"""Below that pace the path's own speed is not known."""

HURRY = 5.0
"""Pace at which the mission's ways out and back go by where the pen need not go as far."""

CLEARED = 0.5
"""Part of the clearance that a pen may still have to go when it is clear."""

ENDS = 0.0005
"""So far from the end of its stroke the path need not brake, m: the mission brings it to rest by itself."""


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
        float,
        Key(
            "s",
            "time in which the press goes while the path rests at the end of a stroke",
            above=0.0,
            high=60.0,
        ),
    ] = 0.8
    unload_to: Annotated[
        float, Key("", "share of the press that is left when the pen leaves", above=0.0, high=1.0)
    ] = 0.35
    unload_lead: Annotated[
        float, Key("s", "by which the press goes ahead of that, as the force comes late", low=0.0, high=1.0)
    ] = 0.0
    leave_time: Annotated[
        float, Key("s", "time in which that share goes as the pen leaves", above=0.0, high=60.0)
    ] = 0.3
    hop: Annotated[
        float, Key("m", "way back from the surface which no lift falls short of", above=0.0, high=1.0)
    ] = 0.025
    retreat_ramp: Annotated[
        float, Key("s", "time over which the tip gets to its speed on the way back", above=0.0, high=60.0)
    ] = 0.3


class State(NamedTuple):
    """What the law remembers.

    Attributes:
        following: of that law.
        friction: what is learnt of it.
        engaged: 1 where the pen touched at the last tick.
        leaving: 1 while the press goes and the pen leaves.
        left: where along the contact axis the pen touched last, m.
        loaded: how much of the time after a touch has gone by, 0 to 1.
        ending: how much of the rest at the end of the stroke has gone by, 0 to 1.
        landing: 1 until the path goes on after the first touch, then down to 0.
    """

    following: following.State
    friction: FrictionState
    engaged: Any
    leaving: Any
    left: Any
    loaded: Any
    ending: Any
    landing: Any


def needs(gains: Gains) -> Needs:
    """It sets the pace, and looks ahead for the end of a stroke."""
    return replace(
        following.needs(gains), preview=(AHEAD, SEEN), slowest=min(gains.least_pace, gains.waiting_pace)
    )


def initial_state(gains: Gains, start: Start) -> State:
    """In the air, at rest."""
    return State(
        following.initial_state(gains, start),
        initial_friction_state(gains.friction),
        *(0.0, 0.0, 0.0, 0.0, 0.0),
        landing=1.0,
    )


def step(gains: Any, state: State, inputs: LawInput) -> tuple[State, ContactView, Signals]:
    """What `following` knows, softer at both ends, and the force across the axis that is expected now."""
    inner, view, signals = following.step(gains, state.following, inputs)
    reference, estimate = inputs.reference, inputs.estimate
    a, u = reference.contact_axis, reference.sliding_axis
    v = cross(a, u)

    leaving = _leaving(gains, state, inner.machine)
    ease = where(leaving > 0.5, 1.0 - inner.machine.since / gains.leave_time, 1.0)
    loaded = clip(state.loaded + inputs.dt / gains.load_time, 0.0, 1.0) * view.engaged
    ease = ease * where(view.engaged > 0.5, gains.load_from + (1.0 - gains.load_from) * loaded, 1.0)
    engaged = clip(view.engaged + leaving, 0.0, 1.0)
    # Who steers by hand has nothing ahead: then the press goes as the pen leaves.
    soon = reference.ahead[0] if reference.ahead else reference
    ends = where(soon.touch < 0.5, 1.0, 0.0) * where(reference.touch > 0.5, 1.0, 0.0)
    ending, off = _ending(gains, state, inputs.dt, ends, engaged)
    ease = ease * (1.0 - (1.0 - gains.unload_to) * ending)
    # What is asked for, and what is commanded: the force comes late.
    ramp = ease
    ease = ease - where(ending > 0.0, gains.unload_lead / gains.unload_time, 0.0)
    # The way back begins where the pen is when the press has gone.
    here = dot(a, estimate.body.position + estimate.arm)
    left = where(engaged > 0.5, here, state.left)
    back, velocity = _back(gains, state, inner.machine, left, inputs)
    retreating = is_in(inner.machine.state, RETREAT)
    place = where(leaving > 0.5, here, where(retreating > 0.5, back, inner.axis_position))
    velocity = where(leaving > 0.5, 0.0, where(retreating > 0.5, velocity, view.axis_velocity))
    # Speeds are those of the last tick's pace; divided by it, they are those of the mission's own.
    own = view.speed / clip(state.following.pace, OWN_PACE, 1.0)
    # The path rests at the end of a stroke until the press has gone, and comes to rest there in time.
    pace = min(inner.pace, _in_time(gains, reference, own))
    pace = where(ends * engaged * (1.0 - ending) > 1e-9, 0.0, pace)
    pace = where(off > 0.5, 1.0, pace)
    pace = where(_hurries(gains, inner, inputs, soon, own) > 0.5, HURRY, pace)
    begun = clip(loaded, gains.least_pace, 1.0)
    pace = where(view.engaged * where(pace > begun, 1.0, 0.0) > 0.5, begun, pace)
    inner = inner._replace(axis_position=place, pace=pace)
    goes = view.engaged * where(view.speed > GOES, inputs.dt / LANDING_TIME, 0.0)
    landing = state.landing * (1.0 - goes)
    view = view._replace(landing=landing * view.engaged, own_speed=own)
    # What is felt while the press goes says nothing of the surface.
    view = view._replace(gone=view.gone * where(ending > 0.0, 0.0, 1.0))
    signals = {**signals, "surface_gone": view.gone}
    loads = view.engaged * where(loaded < 1.0, 1.0, 0.0) * where(view.reason == EASED, 0.0, 1.0)
    reason = where(loads > 0.5, LOADING, view.reason)
    reason = where(where(ending > 0.0, 1.0, leaving) > 0.5, UNLOADING, reason)
    view = view._replace(ramp=ramp, reason=reason)
    view = view._replace(engaged=engaged, ease=view.ease * ease, axis_position=place, axis_velocity=velocity)

    path = _way(gains, inputs, view.engaged)
    seen = vector(dot(u, estimate.wrench.force), dot(v, estimate.wrench.force))
    # Friction grows with the force: where the path says that, it is learnt for each newton.
    share = max(view.ease, 0.0) * engaged * wanted_force(reference.force, 1.0)
    whole = where(reference.force > 0.0, 1.0, inputs.force)
    slope, covariance = inner.surface.estimate, inner.surface.covariance
    climbed = Climbed(whole * slope[1:3], vector(covariance[1, 1], covariance[2, 2]), own)
    friction = follow_friction(gains.friction, state.friction, seen, share, path, climbed, inputs.dt)
    across = expected_across(state.friction, share, direction(gains.friction, path))
    view = view._replace(across=(u * across[0] + v * across[1]) * (1.0 - view.gone))
    signals = {**signals, "pace": pace, "friction_estimate": friction.friction}
    return State(inner, friction, engaged, leaving, left, loaded, ending, landing), view, signals


def _way(gains: Any, inputs: LawInput, engaged: Any) -> Array:
    """The velocity that friction opposes, along u and v, m/s, (2,): on a small stroke to its place."""
    reference, body = inputs.reference, inputs.estimate.body
    u = reference.sliding_axis
    off = reference.tip_position - body.position - inputs.estimate.arm
    way = reference.tip_velocity + off * (gains.friction.chase * reference.fine * engaged)
    return vector(dot(u, way), dot(cross(reference.contact_axis, u), way))


def _hurries(gains: Any, inner: following.State, inputs: LawInput, soon: Reference, own: Any) -> Any:
    """1 while the path of a lifted pen rests for the mission's ways, which are longer than the pen's own.

    On the way out once the pen is clear of the surface. On the way back until the mission waits for touch.
    """
    resting = is_lifted(inputs.reference, inner.known) * where(own < GOES, 1.0, 0.0)
    off = inner.place[0] - following.out_of_touch(gains, inner, inputs)
    clear = is_in(inner.machine.state, FREE) * where(off < CLEARED * inputs.reference.clearance, 1.0, 0.0)
    out = clear * where(soon.touch < 0.5, 1.0, 0.0)
    back = where(inputs.reference.touch > 0.5, 1.0, 0.0) * where(soon.wait < 0.5, 1.0, 0.0)
    return resting * max(out, back)


def _ending(gains: Any, state: State, dt: float, ends: Any, engaged: Any) -> tuple[Any, Any]:
    """How much of the rest at the end of a stroke has gone by, and 1 where the pen came off before that.

    Such a pen has ended its stroke: it does not land once more for the rest.
    """
    ending = clip(state.ending + ends * dt / gains.unload_time, 0.0, 1.0) * engaged
    off = ends * (1.0 - engaged) * where(state.ending > 0.0, 1.0, 0.0)
    return where(off > 0.5, 1.0, ending), off


def _in_time(gains: Any, reference: Reference, own: Any) -> Any:
    """The pace at which a path of its own speed `own` (m/s) still comes to rest before its stroke ends."""
    if not reference.ahead:
        return 1.0
    end, a = reference.ahead[-1], reference.contact_axis
    way = end.tip_position - reference.tip_position
    left = clip(norm(way - a * dot(a, way)) - AHEAD * own, 0.0, 1e3)
    pace = sqrt(2.0 * gains.path_acceleration * (left + ENDS)) / (own + 1e-6)
    ends = reference.touch * (1.0 - end.touch)
    return where(ends > 0.5, clip(pace, OWN_PACE, 1.0), 1.0)


def _leaving(gains: Any, state: State, machine: MachineState) -> Any:
    """1 while the pen should leave and its press has not gone."""
    from_touch = where(state.engaged + state.leaving > 0.5, 1.0, 0.0)
    soon = where(machine.since < gains.leave_time, 1.0, 0.0)
    return is_in(machine.state, RETREAT) * soon * from_touch


def _back(gains: Any, state: State, machine: MachineState, left: Any, inputs: LawInput) -> tuple[Any, Any]:
    """Place (m) and speed (m/s) along the axis on the way back, to where the lifted pen is wanted."""
    reference, before = inputs.reference, state.following.axis_position
    out = following.out_of_touch(gains, state.following, inputs)
    aim = where(reference.touch < 0.5, min(out, left - gains.hop), out)
    gathering = clip((machine.since - gains.leave_time) / gains.retreat_ramp, 0.05, 1.0)
    most = gains.retreat_speed * gathering * inputs.dt
    step = clip(aim - before, -most, most)
    return before + step, step / inputs.dt
