"""Model-predictive control: the pen follows the path ahead and presses, within what tilt and rotors give.

For each axis of the task a plan of moves over one second is made anew at every tick, of which the first is
flown (`translation.horizon`). Along the sliding axes, and along the contact axis out of contact, y is the
place of the centre of gravity behind the pen, and the wanted places are those of the path ahead, at the pace
at which it goes on. In contact y is the normal force over the mass, with the arm's stiffness in the model. A
move is an acceleration,

    minimise |A (u - u_free)|^2    with -limit <= u_k <= limit,    |u_k - u_last| <= rate (k + 1) h,

    level axes: limit = g tan(tilt),      upright: limit = lift g,      f = m (u_0 + g) - c f_hat,

so there always is a plan. Where the search for it does not end in time, or something is not a number, the
last plan goes on for the rest of its second. Then the law commands no number, and the supervisor flies. What
friction pulls is not predicted: it is taken for what it is now, and cancelled in part
(`translation.rubbing`). What the model of the press leaves out, an integral finds.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.base.packing import chosen
from skylimb.control.box_least_squares import ITERATIONS, nearest_in_box
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.needs import Needs
from skylimb.control.press import PLAIN, SATURATED, wanted_force
from skylimb.control.records import NOTHING, LawInput
from skylimb.control.translation.horizon import STAGE, STAGES, TIMES, Axis, Plan, free_moves, plan
from skylimb.control.translation.rubbing import (
    Cancel,
    CancelCutoff,
    CancelLimit,
    Feed,
    expected_across,
    made_up,
    upright,
)
from skylimb.control.windup import unless_short
from skylimb.robots.model import Robot
from skylimb.symbolic import (
    Array,
    as_numpy,
    between,
    clip,
    cross,
    dot,
    low_pass,
    max,
    min,
    norm,
    stack,
    tan,
    vector,
    where,
)

REQUIRES = (
    "estimate.body",
    "estimate.arm",
    "estimate.wrench",
    "contact.engaged",
    "contact.axis_position",
    "contact.axis_velocity",
    "contact.surface_velocity",
    "contact.normal_force",
    "contact.speed",
    "contact.ease",
    "arm.rate",
)
OPTIONAL = {
    "contact.across": "feed",
    "contact.ramp": "",
    "contact.reason": "",
    "contact.gone": "",
    "residual": "",
}


FINITE = 1e9
"""What is larger counts as no number."""


@configuration
class Gains:
    """Costs beside 1 for a squared acceleration, models, and limits; contact axis, then the sliding axes."""

    place_cost: Annotated[Vector3, Key("1/s^4", "cost of a squared error of place", above=0.0, high=1e6)] = (
        25.0,
        300.0,
        200.0,
    )
    speed_cost: Annotated[Vector3, Key("1/s^2", "cost of a squared error of speed", low=0.0, high=1e6)] = (
        10.0,
        10.0,
        10.0,
    )
    force_cost: Annotated[float, Key("", "cost of a squared error of force over mass", low=0.0, high=1e4)] = (
        10.0
    )
    press_cost: Annotated[
        float, Key("1/s^2", "cost of the squared speed into the surface", low=0.0, high=1e6)
    ] = 10.0
    lag: Annotated[
        Vector3, Key("s", "of the acceleration behind the move: attitude, or rotors", above=0.0, high=2.0)
    ] = (0.1, 0.05, 0.05)
    contact_stiffness: Annotated[
        float, Key("N/m", "of arm and surface together, along the contact axis", above=0.0, high=1e6)
    ] = 50.0
    tilt: Annotated[float, Key("rad", "greatest tilt that is planned", above=0.0, high=1.0)] = 0.2
    lift: Annotated[
        float, Key("", "greatest change of lift that is planned, in weights", above=0.0, high=1.0)
    ] = 0.3
    rate: Annotated[float, Key("m/s^3", "greatest rate of a move", above=0.0, high=1e4)] = 50.0
    force: Annotated[float, Key("N", "N_ref, the wanted force", low=0.0, high=20.0)] = 1.0
    force_integral: Annotated[float, Key("1/s", "integral gain of the force error", low=0.0, high=1e3)] = 1.2
    force_integral_limit: Annotated[
        float, Key("N", "greatest size of that integral", low=0.0, high=100.0)
    ] = 3.0
    cancel: Cancel = (0.5, 0.7)
    cancel_cutoff: CancelCutoff = (5.0, 5.0)
    cancel_limit: CancelLimit = 1.0
    feed: Feed = 0.0


class State(NamedTuple):
    """What the law remembers.

    Attributes:
        made: accelerations that are believed to be made now, along the axes, m/s^2, (3,).
        integral: of the force error, N.
        rubbing: low-passed force in the sliding plane, N, (2,).
        known: force along the sliding axes that was made up for, N, (2,).
        asked: moves that were flown last, along the axes, m/s^2, (3,).
        plan: of each axis, one after the other, m/s^2, (3 STAGES,).
        age: of that plan, s.
    """

    made: Array
    integral: Any
    rubbing: Array
    known: Array
    asked: Array
    plan: Array
    age: Any


def needs(gains: Gains) -> Needs:
    """The path ahead, and the force that is commanded."""
    return Needs(preview=TIMES, force=gains.force)


def prepare(gains: Gains, robot: Robot) -> tuple[Plan, ...]:
    """Constants of the plans: three places, then the press."""
    places = (
        plan(Axis(lag, 1.0, 0.0, (place, speed)))
        for lag, place, speed in zip(gains.lag, gains.place_cost, gains.speed_cost, strict=True)
    )
    press = Axis(
        gains.lag[0], gains.contact_stiffness / robot.mass, 1.0, (gains.force_cost, gains.press_cost)
    )
    return (*places, plan(press))


def initial_state(gains: Gains, start: Start) -> State:
    """At rest."""
    z3 = np.zeros(3)
    return State(z3, 0.0, np.zeros(2), np.zeros(2), z3, np.zeros(3 * STAGES), 0.0)


def step(prepared: Any, state: State, inputs: LawInput) -> tuple[State, Array, Signals]:
    """f_cmd in W, N, (3,)."""
    gains, plans = prepared
    estimate, reference, contact, dt = inputs.estimate, inputs.reference, inputs.contact, inputs.dt
    body, arm = estimate.body, estimate.arm
    m, gravity = body.model.mass, body.model.gravity
    a, u = reference.contact_axis, reference.sliding_axis
    axes = a, u, cross(a, u)
    ways, forces = _ahead(gains, inputs)
    boxes = [_box(gains, _limit(gains, axis, gravity), state.asked[i]) for i, axis in enumerate(axes)]
    made = stack(*(low_pass(state.made[i], state.asked[i], 1.0 / gains.lag[i], dt) for i in range(3)))

    # Along the sliding axes: places of the tip's reference less the arm.
    moves = []
    for i in (1, 2):
        here = dot(axes[i], reference.tip_position - arm - body.position)
        path = stack(here, *(here + dot(axes[i], way) for way in ways))
        now = vector(0.0, dot(axes[i], body.velocity), made[i])
        moves.append(_planned(plans[i], now, path, dot(axes[i], reference.tip_velocity), boxes[i]))

    # Along the contact axis: led to the surface, or pressing on it.
    engaged, speed = contact.engaged, dot(a, body.velocity)
    here = contact.axis_position - dot(a, body.position + arm)
    led = stack(here, *(here + contact.axis_velocity * t for t in TIMES))
    leads = _planned(plans[0], vector(0.0, speed, made[0]), led, contact.axis_velocity, boxes[0])
    commanded = inputs.force
    share = contact.ease * (1.0 - (0.0 if contact.gone is None else contact.gone))
    relative = speed - (contact.surface_velocity - inputs.arm.rate)
    felt = vector(contact.normal_force / m, relative, made[0])
    presses = _planned(plans[3], felt, stack(commanded, *forces) * (share / m), 0.0, boxes[0])
    missing = gains.force_integral * (commanded * share - contact.normal_force) * dt
    integral = state.integral + unless_short(missing, dot(a, (inputs.residual or NOTHING).force))
    integral = clip(integral, -gains.force_integral_limit, gains.force_integral_limit) * engaged

    shares = [engaged * gains.cancel[i] for i in range(2)]
    rubbing, known = made_up(gains, expected_across(contact), shares, state.rubbing, inputs, axes[1:])
    plan_now = stack(where(engaged > 0.5, presses, leads), *moves)
    fresh = State(made, integral, rubbing, vector(*known), state.asked, plan_now, 0.0)
    new = chosen(_sound(fresh), fresh, state._replace(made=made, age=state.age + dt))
    wanted = _flown(gains, new, dt)
    total = m * (gravity + wanted[0] * a + wanted[1] * axes[1] + wanted[2] * axes[2])
    total = total + new.integral * a - new.known[0] * axes[1] - new.known[1] * axes[2]
    target = reference.tip_position - arm
    beside = where(engaged > 0.5, dot(a, body.position), contact.axis_position - dot(a, arm))
    reason = PLAIN if contact.reason is None else contact.reason
    full = where(abs(integral) >= gains.force_integral_limit, 1.0, 0.0) * where(reason > 0.0, 0.0, 1.0)
    ramp = 1.0 if contact.ramp is None else contact.ramp
    total = where(new.age < TIMES[-1] + 0.5 * dt, total, np.nan * np.ones(3))
    signals = {
        "cog_position_target": target + a * (beside - dot(a, target)),
        "contact_force_reference": commanded * reference.touch * ramp,
        "contact_force_target": commanded * share * engaged,
        "contact_force_integral": new.integral,
        "press_reason": where(full * engaged > 0.5, SATURATED, reason),
        "planned_moves": wanted,
        "plan_age": new.age,
    }
    return new._replace(asked=wanted), total, signals


Box = tuple[Array, Array]
"""Least and greatest moves of a plan, m/s^2, (STAGES,) each."""


def _box(gains: Any, limit: Any, last: Any) -> Box:
    """What the moves of a plan may be, where the last one was `last`."""
    reach = gains.rate * STAGE * np.arange(1.0, STAGES + 1.0)
    return clip(last - reach, -limit, limit), clip(last + reach, -limit, limit)


def _planned(constants: Plan, state: Array, path: Array, rate: Any, box: Box) -> Array:
    """The moves of the plan, m/s^2, (STAGES,); not numbers where the search has not ended."""
    free = free_moves(constants, state, path, rate)
    best, iterations = map(as_numpy, nearest_in_box(STAGES, STAGES)(constants.cost, free, *box))
    return where(iterations[0] < ITERATIONS, best, np.nan * np.ones(STAGES))


def _sound(fresh: State) -> Any:
    """Whether all that was made of this tick are numbers."""
    parts = stack(fresh.plan, fresh.integral, fresh.rubbing, fresh.known)
    return dot(parts, parts) < FINITE


def _flown(gains: Any, now: State, dt: float) -> Array:
    """The moves of the plan at its age, no faster than they may change, m/s^2, (3,)."""
    place, change = min(now.age / STAGE, STAGES - 1.0), gains.rate * dt
    rows = ([now.plan[i * STAGES + k] for k in range(STAGES)] for i in range(3))
    return clip(vector(*(between(row, place) for row in rows)), now.asked - change, now.asked + change)


def _ahead(gains: Any, inputs: LawInput) -> tuple[list[Array], list[Any]]:
    """Ways of the tip from here, m, and wanted forces, N, at the ends of the stages.

    They are those at which the path really goes on: a mission that waits shows where it would go. Where
    nobody shows what lies ahead, as in exported C, it goes on as it goes now.
    """
    reference, now = inputs.reference, inputs.force
    if not reference.ahead:
        return [reference.tip_velocity * t for t in TIMES], [now] * STAGES
    ways = [later.tip_position - reference.tip_position for later in reference.ahead]
    pace = clip(STAGE * inputs.contact.speed / max(norm(ways[0]), 1e-6), 0.0, 1.0)
    forces = (wanted_force(later.force, gains.force) for later in reference.ahead)
    return [pace * way for way in ways], [now + pace * (force - now) for force in forces]


def _limit(gains: Any, axis: Array, gravity: Array) -> Any:
    """Greatest acceleration that is planned along an axis, m/s^2."""
    level, g = 1.0 - upright(axis, gravity), dot(gravity, gravity) ** 0.5
    return g * (level * tan(gains.tilt) + (1.0 - level) * gains.lift)
