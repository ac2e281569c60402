"""Hold the pen on its path with body and thrust, and press with a regulated force.

In the sliding plane (u, v) the centre of gravity follows the tip's reference less the arm, stiffly:

    f = m (a_ref - D (p' - p'_ref) - K (p - p_ref)) - c f_hat,    c = cancel min(1, |v_path| / cancel_speed),

where the estimated force is cancelled only as the pen moves: a pen that sticks makes any integral action
hunt. A force that the contact law expects is made up for at once (`feed`), and only what is estimated beyond
it is cancelled. A robot that presses harder tilts, and its pen swings about the centre of gravity. The damper
must not hold back the way by which the centre of gravity makes up for that, so p' may count the swing, as
p' + share (omega x r) behind a low pass, the less the faster the path itself goes; and by a share of its own
while the press goes at the end of a stroke (`leaving_swing`): a body that is late by then draws its lag as a
tail when the pen comes off.

Along the contact axis it is soft while the force is regulated, around an anchor that the contact law carries
along, and heavier or lighter than it is by the mass ratio mu = M_d / m:

    f = -m (D_a (x' - x'_surface + r') + K_a (x - x_anchor)) + (1/mu - 1) (f_hat + N_ref) + N_ref + I,
    I' = k_i (N_ref - N_hat).

The integral lives on a tank of energy (`control.translation.tank`).
Where the surface has gone from under the tip N_ref is 0, and the damper is firmer.
Out of contact the tip is led along the axis by position.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.needs import Needs
from skylimb.control.press import HARD, UNLOADING
from skylimb.control.records import LawInput
from skylimb.control.terms import place_terms
from skylimb.control.translation.hanging import slow_arm
from skylimb.control.translation.rubbing import (
    Cancel,
    CancelCutoff,
    CancelLimit,
    Feed,
    expected_across,
    made_up,
    upright,
)
from skylimb.control.translation.tank import Pressed, gone, regulated
from skylimb.symbolic import Array, clip, cross, dot, low_pass, max, where

REQUIRES = (
    "estimate.body",
    "estimate.arm",
    "estimate.wrench",
    "contact.engaged",
    "contact.axis_position",
    "contact.axis_velocity",
    "contact.anchor",
    "contact.surface_velocity",
    "contact.normal_force",
    "contact.speed",
    "contact.ease",
    "arm.rate",
)
OPTIONAL = {
    "contact.across": "feed",
    "contact.landing": "landing_cancel",
    "contact.own_speed": "",
    "contact.ramp": "",
    "contact.reason": "",
    "contact.gone": "",
    "residual": "",
}

FREELY = 0.5
"""Share of the pen's swing that counts out of touch, and where a fast path waits for its pen: with all of it
the pen flutters."""

BRAKE = 2.0
"""By how many times itself the damper along the axis grows where the surface has gone: to three times, as
more would tilt the robot."""


@configuration
class Gains:
    """Gains in the frame of the task: contact axis, then the two sliding axes."""

    stiffness: Annotated[
        Vector3,
        Key(
            "1/s^2",
            "stiffness K / m; along the contact axis only out of contact",
            above=0.0,
            high=1e4,
        ),
    ]
    damping_ratio: Annotated[Vector3, Key("", "damping ratio of those springs", above=0.0, high=100.0)]
    stiffening: Annotated[
        float,
        Key(
            "", "how much the sliding axes' stiffness grows with a force of more than 2 N", low=0.0, high=1.0
        ),
    ] = 0.0
    press_stiffness: Annotated[float, Key("1/s^2", "stiffness K_a / m of the anchor", low=0.0, high=1e4)] = (
        0.3
    )
    press_damping: Annotated[
        float, Key("1/s", "damping D_a / m of the motion along the axis", above=0.0, high=1e3)
    ] = 3.3
    press_mass_ratio: Annotated[
        float,
        Key(
            "",
            "virtual over true mass, mu = M_d / m, along the axis while the force is regulated",
            above=0.0,
            high=1e3,
        ),
    ] = 0.6
    force: Annotated[
        float,
        Key("N", "N_ref, the wanted force", low=0.0, high=20.0),
    ] = 1.0
    force_integral: Annotated[
        float, Key("1/s", "k_i, integral gain of the force error", low=0.0, high=1e3)
    ] = 0.5
    force_integral_limit: Annotated[
        float, Key("N", "greatest size of the integral I", low=0.0, high=100.0)
    ] = 3.0
    tank: Annotated[float, Key("J", "greatest energy of the tank", above=0.0, high=1e3)] = 0.5
    cancel: Cancel = (1.0, 1.0)
    cancel_cutoff: CancelCutoff = (5.0, 5.0)
    cancel_limit: CancelLimit = 1.0
    cancel_speed: Annotated[
        float, Key("m/s", "speed of the path from which it is cancelled in full", above=0.0, high=10.0)
    ] = 0.06
    landing_cancel: Annotated[
        tuple[float, float],
        Key(
            "",
            "shares of that force that are cancelled from the first touch until the path goes on",
            low=0.0,
            high=0.95,
        ),
    ] = (0.0, 0.0)
    feed: Feed = 0.0
    swing: Annotated[
        tuple[float, float],
        Key(
            "",
            "shares of the pen's motion about the centre of gravity that the sliding axes' damping counts",
            low=0.0,
            high=1.0,
        ),
    ] = (0.0, 0.0)
    swing_cutoff: Annotated[
        float, Key("Hz", "cut-off of the low pass on that motion", above=0.0, high=1e4)
    ] = 1.0
    swing_speed: Annotated[
        float,
        Key("m/s", "speed of the path from which none of that motion is counted", above=0.0, high=10.0),
    ] = 10.0
    leaving_swing: Annotated[
        tuple[float, float],
        Key(
            "",
            "shares of the pen's motion that are counted at least while the press goes at a stroke's end",
            low=0.0,
            high=1.0,
        ),
    ] = (0.0, 0.0)
    error_limit: Annotated[
        float,
        Key(
            "m",
            "position error beyond which a sliding spring pulls no harder; upright, at half the weight",
            above=0.0,
            high=10.0,
        ),
    ] = 0.1
    pen: Annotated[
        float, Key("", "1: the pen follows the path; 0: the centre of gravity does", low=0.0, high=1.0)
    ] = 1.0
    hanging: Annotated[
        float,
        Key(
            "",
            "share of what a tilt moves a pen that hangs below the body which is made up for slowly; for "
            "robots that tilt to go aside",
            low=0.0,
            high=1.0,
        ),
    ] = 0.0


class State(NamedTuple):
    """What the law remembers.

    Attributes:
        press: what the press remembers.
        rubbing: low-passed force in the sliding plane, N, (2,).
        swing: low-passed velocity of the pen about the centre of gravity, W, m/s, (3,).
        hung: low-passed way by which the tilt has moved a pen that hangs, W, m, (3,).
    """

    press: Pressed
    rubbing: Array
    swing: Array
    hung: Array = np.zeros(3)


def needs(gains: Gains) -> Needs:
    """The force that is commanded."""
    return Needs(force=gains.force)


def initial_state(gains: Gains, start: Start) -> State:
    """No integral, a full tank."""
    return State(Pressed(0.0, gains.tank, 0.0), np.zeros(2), np.zeros(3))


def step(gains: Any, state: State, inputs: LawInput) -> tuple[State, Array, Signals]:
    """f_cmd in W, N, (3,)."""
    estimate, reference, contact = inputs.estimate, inputs.reference, inputs.contact
    body, dt = estimate.body, inputs.dt
    m = body.model.mass
    a, u = reference.contact_axis, reference.sliding_axis
    v = cross(a, u)
    # Friction grows with the press: so does the spring that holds the pen against it.
    firmer = 1.0 + gains.stiffening * (max(inputs.force / HARD, 1.0) - 1.0)
    stiffness = [gains.stiffness[0], firmer * gains.stiffness[1], firmer * gains.stiffness[2]]
    damping = [2.0 * gains.damping_ratio[i] * stiffness[i] ** 0.5 for i in range(3)]

    hanging = slow_arm(estimate, gains.hanging, state.hung, dt)
    target = cog_target(gains, inputs, hanging.arm)
    expected = expected_across(contact)
    landing = 0.0 if contact.landing is None else contact.landing
    share = clip(contact.speed / gains.cancel_speed, 0.0, 1.0)
    shares = [share * gains.cancel[i] + landing * (1.0 - share) * gains.landing_cancel[i] for i in range(2)]
    rubbing, known = made_up(gains, expected, shares, state.rubbing, inputs, (u, v))
    swing = cross(body.R_WC @ body.angular_velocity, hanging.swings)
    swing = low_pass(state.swing, swing, 2.0 * math.pi * gains.swing_cutoff, dt)
    # Neither a path that waits for its pen, nor a hover with slow rotors, nor a press whose surface has gone
    # bears all of the swing.
    own_speed = contact.speed if contact.own_speed is None else contact.own_speed
    rests, slow = (1.0 - clip(one / gains.swing_speed, 0.0, 1.0) for one in (contact.speed, own_speed))
    counted = max(slow * contact.engaged * (1.0 - gone(inputs)), FREELY * rests)
    leaving = 0.0 if contact.reason is None else where(contact.reason == UNLOADING, 1.0, 0.0)
    total, proportional, derivative = m * body.model.gravity, np.zeros(3), np.zeros(3)
    for axis, i in ((u, 1), (v, 2)):
        limit = _error_limit(gains, axis, stiffness[i], body.model.gravity)
        error = clip(dot(axis, body.position - target), -limit, limit)
        swings = max(gains.swing[i - 1] * counted, gains.leaving_swing[i - 1] * leaving)
        error_rate = dot(axis, body.velocity + swings * swing - reference.tip_velocity)
        damper, spring = hanging.firmness * damping[i] * error_rate, stiffness[i] * error
        wanted = dot(axis, reference.tip_acceleration) - damper - spring
        total = total + axis * (m * wanted - known[i - 1])
        proportional, derivative = proportional - axis * spring, derivative - axis * damper

    speed = dot(a, body.velocity)
    tip = dot(a, body.position + estimate.arm)
    damper = -damping[0] * (speed - contact.axis_velocity)
    spring = gains.stiffness[0] * (tip - contact.axis_position)
    led = m * (damper - spring)
    # The body follows what the surface does less what the arm makes up.
    relative = speed - (contact.surface_velocity - inputs.arm.rate)
    held = m * gains.press_damping * (1.0 + BRAKE * gone(inputs)) * relative
    push, press, pressing = regulated(gains, state, inputs, relative, held)
    anchored = -m * gains.press_stiffness * (dot(a, body.position) - contact.anchor)
    pressed = push + anchored
    engaged = contact.engaged > 0.5
    total = total + a * where(engaged, pressed, led)
    terms = place_terms(
        proportional + a * where(engaged, anchored / m, -spring),
        derivative + a * where(engaged, -held / m, damper),
        a * (pressing["contact_force_integral"] / m),
    )
    signals = {"cog_position_target": target, **pressing, **terms}
    return State(press, rubbing, swing, hanging.slow), total, signals


def cog_target(gains: Any, inputs: LawInput, arm: Array) -> Array:
    """Where the centre of gravity should be, W, m: behind the tip's reference by the arm (3,) of W, m."""
    reference, contact = inputs.reference, inputs.contact
    a = reference.contact_axis
    by_pen = reference.tip_position - arm
    target = reference.position + gains.pen * (by_pen - reference.position)
    along = contact.axis_position - dot(a, inputs.estimate.arm)
    along = where(contact.engaged > 0.5, contact.anchor, along)
    return target + a * (along - dot(a, target))


def _error_limit(gains: Any, axis: Array, stiffness: Any, gravity: Array) -> Any:
    """The error beyond which a spring (1/s^2) pulls no harder, m: one that carries gives half the weight."""
    g = dot(gravity, gravity) ** 0.5
    most = clip(0.5 * g / stiffness - gains.error_limit, 0.0, 10.0)
    return gains.error_limit + upright(axis, gravity) * most
