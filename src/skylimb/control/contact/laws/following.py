"""Find the surface, keep to it, and go no faster than it allows.

Five parts share the estimate of the tip's place: the state machine (`control.contact.machine`), the surface
under the pen (`estimation.surface`) and whether it has gone (`control.contact.felt`), where the tip is led
out of touch (`control.contact.lead`), and the pace of the mission (`control.contact.pace`). A pen that stays
behind its reference presses less: with high friction on a slope that comes toward the robot, the force that
drags it along makes the contact force, and the friction with it, grow until the pen is wedged.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, configuration, refused
from skylimb.control.contact.felt import felt_by
from skylimb.control.contact.lead import led, wanted_out
from skylimb.control.contact.machine import (
    APPROACH,
    LOST,
    RECONTACT,
    SETTLE,
    SLIDE,
    Cues,
    MachineGains,
    MachineState,
    advance,
    is_in,
)
from skylimb.control.contact.pace import pace_of
from skylimb.control.contact.task_axes import in_task, normal_force_on, seen_across
from skylimb.control.estimation.calibration import is_sound
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.estimation.surface import (
    SurfaceGains,
    SurfaceState,
    expected_height,
)
from skylimb.control.needs import Needs
from skylimb.control.press import EASED, HARD, LOADING, PLAIN, SEARCHING, WAITING
from skylimb.control.records import ContactView, LawInput
from skylimb.symbolic import Array, clip, cross, dot, max, min, where

PROVIDES = (
    "contact.engaged",
    "contact.axis_position",
    "contact.axis_velocity",
    "contact.anchor",
    "contact.surface_velocity",
    "contact.normal_force",
    "contact.speed",
    "contact.ease",
    "contact.reason",
    "contact.gone",
    "contact.ramp",
)
REQUIRES = ("estimate.body", "estimate.arm", "estimate.wrench", "estimate.contact_force")
OPTIONAL = {"estimate.bias": "", "estimate.scale": ""}


@configuration
class Gains:
    """Machine, surface estimate and pace."""

    approach_speed: Annotated[
        float, Key("m/s", "speed at which the tip looks for the surface", above=0.0, high=10.0)
    ] = 0.05
    return_speed: Annotated[
        float,
        Key("m/s", "speed at which it goes to a surface that it knows, until near it", above=0.0, high=10.0),
    ] = 0.05
    approach_ramp: Annotated[
        float, Key("s", "time over which the tip gets to that speed", above=0.0, high=60.0)
    ] = 1.0
    retreat_speed: Annotated[float, Key("m/s", "speed at which the tip goes back", above=0.0, high=10.0)] = (
        0.10
    )
    axis_speed: Annotated[
        float,
        Key(
            "m/s",
            "greatest speed along the contact axis that body and arm follow",
            above=0.0,
            high=100.0,
        ),
    ] = 0.04
    least_pace: Annotated[
        float, Key("", "the path never goes slower than this for the surface's sake", low=0.01, high=1.0)
    ] = 0.25
    path_acceleration: Annotated[
        float, Key("m/s^2", "acceleration at which the path gathers speed", above=0.0, high=100.0)
    ] = 0.1
    wait_beyond: Annotated[
        float,
        Key(
            "m",
            "distance of the pen from its path at which the path waits for it",
            above=0.0,
            high=10.0,
        ),
    ] = 0.08
    waiting_pace: Annotated[float, Key("", "pace of a path that waits for its pen", low=0.01, high=1.0)] = 0.1
    waiting_speed: Annotated[
        float, Key("m/s", "speed of a fast path that waits, down to `least_pace`", above=0.0, high=100.0)
    ] = 100.0
    body_share: Annotated[
        float,
        Key(
            "",
            "share of the surface's motion that the body takes; the arm's is shape.arm_share",
            low=0.0,
            high=1.0,
        ),
    ] = 0.5
    ease_beyond: Annotated[
        tuple[float, float],
        Key(
            "m",
            "distances of the pen from its path between which the press eases, up to 1 N; they grow with it",
            low=0.0,
            high=1.0,
        ),
    ] = (0.015, 0.04)
    ease_grows: Annotated[
        float,
        Key(
            "N",
            "wanted force up to which those distances grow with it; beyond, force times distance stays",
            low=1.0,
            high=20.0,
        ),
    ] = 2.0
    least_ease: Annotated[
        float, Key("", "share of the wanted force beyond the second; 1 to press on", low=0.05, high=1.0)
    ] = 1.0
    ease_ahead: Annotated[
        float, Key("", "share of the way ahead of its path by which a pen's press eases", low=0.0, high=1.0)
    ] = 1.0
    growth: Annotated[
        float,
        Key(
            "N/s",
            "rate at which a press of more than 2 N grows from there after a touch",
            above=0.0,
            high=1e3,
        ),
    ] = 1e3
    machine: MachineGains = field(default_factory=MachineGains)
    surface: SurfaceGains = field(default_factory=SurfaceGains)

    def check(self) -> None:
        """The distances rise."""
        if not self.ease_beyond[1] > self.ease_beyond[0]:
            raise refused(self, "ease_beyond", "has to rise from the first to the second")


class State(NamedTuple):
    """What the law remembers.

    Attributes:
        machine: of the contact.
        surface: under the pen.
        axis_position: at which the tip is wanted along the contact axis, m.
        lost_at: where along it the last touch was lost, m.
        anchor: of the centre of gravity along it, m.
        pace: of the mission.
        speed: of the path at that pace, m/s.
        place: of the tip in the task's frame, m, (3,).
        sunk: how far it has gone on into where the surface should be, lately, m.
        pressed: normal force that was felt lately, N.
        touched: where in the sliding plane the tip touched last, m, (2,).
        known: 1 once it has slid on the surface, until nothing is found there.
        loaded: how far the press has grown beyond `HARD` since the touch, N.
    """

    machine: MachineState
    surface: SurfaceState
    axis_position: Any
    lost_at: Any
    anchor: Any
    pace: Any
    speed: Any
    place: Array = np.zeros(3)
    sunk: Any = 0.0
    pressed: Any = 0.0
    touched: Array = np.zeros(2)
    known: Any = 0.0
    loaded: Any = 0.0


def needs(gains: Gains) -> Needs:
    """It sets the pace, and presses beside people: it is supervised."""
    return Needs(paced=True, supervised=True)


def initial_state(gains: Gains, start: Start) -> State:
    """In the air, at rest."""
    return State(MachineState(), SurfaceState(), 0.0, 0.0, 0.0, 1.0, 0.0)


def step(gains: Any, state: State, inputs: LawInput) -> tuple[State, ContactView, Signals]:
    """Machine, surface, references along the contact axis, and pace of one tick."""
    reference, estimate, dt = inputs.reference, inputs.estimate, inputs.dt
    a, u = reference.contact_axis, reference.sliding_axis
    axes = a, u, cross(a, u)
    tip = estimate.body.position + estimate.arm
    place = in_task(tip, axes)
    out = out_of_touch(gains, state, inputs)

    # 1. The machine.
    normal_force = normal_force_on(estimate.wrench, state.surface.estimate[1:3], axes)
    before = state.machine
    machine = advance(gains.machine, before, _cues(state, inputs, out), dt)
    engaged, engaged_before = is_in(machine.state, SETTLE, SLIDE), is_in(before.state, SETTLE, SLIDE)

    # 2. The surface under the pen.
    path = in_task(reference.tip_velocity, axes)[1:3]
    speed = (path[0] ** 2 + path[1] ** 2) ** 0.5
    across = seen_across(estimate.wrench, path, speed, axes)
    felt = felt_by(gains, state, inputs, place, across, normal_force, (engaged, engaged_before))
    slope = felt.surface.estimate[1:3]
    surface_velocity = engaged * (slope[0] * path[0] + slope[1] * path[1])

    # 3. Along the contact axis.
    height = expected_height(gains.surface, state.surface, felt.ways[0], felt.ways[1])
    axis_position, axis_velocity = led(gains, machine, state.axis_position, out, state.known, height, inputs)
    axis_position = where(engaged > 0.5, place[0], axis_position)
    lost = is_in(machine.state, LOST) * (1.0 - is_in(before.state, LOST))
    lost_at = where(lost > 0.5, place[0], state.lost_at)
    carried = state.anchor + gains.body_share * surface_velocity * dt
    anchor = where(engaged * engaged_before > 0.5, carried, dot(a, estimate.body.position))

    # 4. The pace, and how hard to press.
    off = in_task(tip - reference.tip_position, axes)
    behind = engaged * (off[1] ** 2 + off[2] ** 2) ** 0.5
    pace, speed_next = pace_of(
        gains, state.pace, state.speed, machine, reference, speed, surface_velocity, behind, dt
    )
    ease = _ease(gains, inputs.force, engaged * _easing(gains, off, path, speed))
    loaded = engaged * min(state.loaded + gains.growth * dt, 1e3)
    ramp = where(engaged > 0.5, clip((HARD + loaded) / max(inputs.force, HARD), 0.0, 1.0), 1.0)

    reason = where(is_in(machine.state, SETTLE) > 0.5, WAITING, PLAIN)
    reason = where(ease < 1.0, EASED, where(ramp < 1.0, LOADING, reason))
    reason = where(is_in(machine.state, APPROACH, LOST, RECONTACT) > 0.5, SEARCHING, reason)
    view = ContactView(
        engaged, axis_position, axis_velocity, anchor, surface_velocity, normal_force, speed, ease * ramp
    )._replace(ramp=ramp, reason=reason, gone=felt.gone)
    signals = {
        "pace": pace,
        "contact_state": machine.state,
        "contact_reason": machine.reason,
        "normal_force_estimate": normal_force,
        "surface_slope_estimate": slope[0] * u + slope[1] * axes[2],
        "tip_position_estimate": tip,
        "surface_gone": felt.gone,
    }
    there = (1.0 - machine.given_up) * where(felt.gone > 0.5, 0.0, 1.0)
    new = State(
        machine,
        felt.surface,
        axis_position,
        lost_at,
        anchor,
        pace,
        speed_next,
        place,
        felt.sunk,
        felt.pressed,
        touched=where(felt.touching > 0.5, place[1:3], state.touched),
        known=max(state.known, is_in(machine.state, SLIDE)) * there,
        loaded=loaded,
    )
    return new, view, signals


def _cues(state: State, inputs: LawInput, out: Any) -> Cues:
    """What the machine goes by; `out` is where the tip is wanted out of touch, m."""
    reference, estimate = inputs.reference, inputs.estimate
    a = reference.contact_axis
    return Cues(
        touch=reference.touch * is_sound(estimate),
        force=-dot(a, estimate.wrench.force),
        smooth_force=-estimate.contact_force,
        beyond=state.axis_position - dot(a, reference.tip_position),
        sunk=state.axis_position - state.lost_at,
        clear=where(abs(state.axis_position - out) < 1e-3, 1.0, 0.0),
    )


def _easing(gains: Any, off: Array, path: Array, speed: Any) -> Any:
    """How far a pen is off its path, m, less what of the way ahead of it does not ease.

    Args:
        gains: `ease_ahead`.
        off: of the path, in the task's frame, m, (3,).
        path: its velocity in the sliding plane, m/s, (2,).
        speed: its length, m/s.
    """
    ahead = max(off[1] * path[0] + off[2] * path[1], 0.0) / (speed + 1e-6)
    return max(off[1] ** 2 + off[2] ** 2 - (1.0 - gains.ease_ahead) * ahead**2, 0.0) ** 0.5


def _ease(gains: Any, force: Any, behind: Any) -> Any:
    """Share of the wanted force `force`, N, for a pen that is `behind` its path, m.

    Friction grows with the press, and with it how far a sound pen stays behind.
    """
    most = gains.ease_grows
    further = clip(min(force, most**2 / max(force, 1.0)), 1.0, most)
    begin, end = further * gains.ease_beyond[0], further * gains.ease_beyond[1]
    return clip((end - behind) / (end - begin), gains.least_ease, 1.0)


def out_of_touch(gains: Any, state: State, inputs: LawInput) -> Any:
    """Where along the contact axis the tip is wanted out of touch, m."""
    reference, body = inputs.reference, inputs.estimate.body
    a, u = reference.contact_axis, reference.sliding_axis
    axes = a, u, cross(a, u)
    place = in_task(body.position + inputs.estimate.arm, axes)
    soon = in_task(reference.ahead[-1].tip_position, axes) if reference.ahead else place
    ways = (np.zeros(2), place[1:3] - state.touched, soon[1:3] - state.touched)
    heights = [expected_height(gains.surface, state.surface, way[0], way[1]) for way in ways]
    return wanted_out(reference, dot(a, reference.tip_position), state.known, heights)
