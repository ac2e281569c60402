"""Sampling model-predictive control (MPPI): the simulator itself is the model.

    skylimb run --controller examples/sampling/mppi.toml

A spring and a damper hold the centre of gravity behind the pen, f = m (k (r + d - p) + c (r' - p') + g). What
is planned is d, how far the spring's end is moved: `KNOTS` places over `HORIZON` along each axis of the task.
Every `every` ticks `samples` plans are drawn about the last one and flown in the simulator (`rollouts.py`),
by the same spring, from the state that is estimated now; the new plan is their mean, each weighed by

    exp(-(J - least J) / (temperature (mean J of the better half - least J))),

J the mean square of the pen off its path and of the force off the wanted one, and of d (Williams, Aldrich,
Theodorou, J. Guidance, Control, and Dynamics 40, 2017). Friction that is felt and that the model's board has
not moves the spring's end besides. Random numbers follow from `seed` and the tick: the same flight has the
same bits.

It is for simulation alone: it flies in Python, needs a C compiler, takes several times longer than the
flight, and is not exported. Contact axes other than W's x are refused.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from rollouts import AHEAD, PERIOD, Begin, Rollouts  # beside this file

from skylimb.control.needs import Needs
from skylimb.control.press import wanted_force

KNOTS, HORIZON = 4, 0.6  # s
TICKS = round(HORIZON / PERIOD)
TIMES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
AT = np.linspace(0.0, HORIZON, KNOTS)
NOW = PERIOD * np.arange(TICKS + 1)
REQUIRES = tuple(f"estimate.{name}" for name in ("body", "wrench", "arm")) + tuple(
    f"contact.{name}"
    for name in ("engaged", "axis_position", "axis_velocity", "surface_velocity", "normal_force", "speed")
)
OPTIONAL = {"contact.ease": ""}


@dataclass(frozen=True)
class Gains:
    stiffness: tuple[float, float, float] = (4.0, 16.0, 16.0)  # 1/s^2, contact axis first
    damping_ratio: tuple[float, float, float] = (0.5, 0.8, 0.8)
    force: float = 1.0  # N
    friction: float = 0.35  # of the model's board
    felt_pole: float = 2.0  # 1/s, of the friction that is felt beyond it
    spread: tuple[float, float, float] = (0.008, 0.005, 0.005)  # m, of the samples
    line_cost: float = 1.0  # 1/mm^2
    force_cost: float = 100.0  # 1/N^2
    move_cost: float = 0.01  # 1/mm^2
    temperature: float = 0.2
    every: float = 10.0  # ticks
    samples: float = 32.0
    seed: float = 1.0


class State(NamedTuple):
    """Plan (places of the knots, axis by axis, m), its age (s), the tick, the anchor (m), friction (N)."""

    plan: np.ndarray
    age: float
    tick: float
    anchor: float
    felt: np.ndarray


def needs(gains: Gains) -> Needs:
    return Needs(preview=TIMES, force=gains.force)


def prepare(gains: Gains, robot: Any) -> Rollouts:
    spring = {"normalized_stiffness": list(gains.stiffness), "damping_ratio": list(gains.damping_ratio)}
    return Rollouts(robot, int(gains.samples), TICKS, spring, float(gains.friction))


def initial_state(gains: Gains, start: Any) -> State:
    return State(np.zeros(3 * KNOTS), 0.0, 0.0, 0.0, np.zeros(2))


def step(
    gains: Any, state: State, inputs: Any, rollouts: Rollouts
) -> tuple[State, np.ndarray, dict[str, Any]]:
    estimate, reference, contact = inputs.estimate, inputs.reference, inputs.contact
    body, engaged = estimate.body, float(contact.engaged) > 0.5
    axis, u = reference.contact_axis, reference.sliding_axis
    if np.abs(axis - AHEAD).max() > 1e-6:
        raise ValueError("its model has a board across W's x axis; this contact axis is another one")
    task = np.stack([axis, u, np.cross(axis, u)])
    mass, stiffness = body.model.mass, np.asarray(gains.stiffness)
    commanded = float(wanted_force(reference.force, gains.force))
    share = 1.0 if contact.ease is None else float(contact.ease)
    wanted = commanded * share * engaged

    fresh = state.tick % gains.every == 0.0 and (float(reference.touch) > 0.5 or engaged)
    age = 0.0 if fresh else state.age + inputs.dt
    felt = _felt(gains, state, inputs, task, engaged)
    anchor = float(axis @ body.position) + wanted / (mass * stiffness[0]) if fresh else state.anchor
    ends = _ends(state._replace(anchor=anchor, felt=felt), inputs, task, engaged, mass * stiffness)
    plan = state.plan if not fresh else _shifted(state.plan, gains.every * PERIOD)
    if not engaged:
        plan = plan * np.repeat([0.0, 1.0, 1.0], KNOTS)
    if fresh:
        plan = _planned(gains, plan, int(state.tick), inputs, rollouts, (ends, task, wanted, engaged, felt))

    # The spring's end of now: the path, and what is planned for it.
    moved = np.array([np.interp(age, AT, row) for row in plan.reshape(3, KNOTS)])
    end = ends[0] + moved @ task
    rate = (ends[1] - ends[0]) / PERIOD
    damping = 2.0 * np.asarray(gains.damping_ratio) * np.sqrt(stiffness)
    pull = task.T @ (stiffness * (task @ (end - body.position)) + damping * (task @ (rate - body.velocity)))
    signals = {
        "cog_position_target": end,
        "contact_force_reference": commanded * float(reference.touch),
        "planned_moves": moved,
        "plan_age": age,
    }
    return State(plan, age, state.tick + 1.0, anchor, felt), mass * (body.model.gravity + pull), signals


def _felt(gains: Any, state: State, inputs: Any, task: np.ndarray, engaged: bool) -> np.ndarray:
    """Low-passed force along the sliding axes beyond what the model's board rubs with, N, (2,)."""
    way = task[1:] @ inputs.reference.tip_velocity
    rubs = -gains.friction * float(inputs.contact.normal_force) * way / max(float(np.linalg.norm(way)), 1e-3)
    off = (task[1:] @ inputs.estimate.wrench.force - rubs) * engaged
    decay = np.exp(-gains.felt_pole * inputs.dt)
    return decay * state.felt + (1.0 - decay) * off


def _ends(state: State, inputs: Any, task: np.ndarray, engaged: bool, pull: np.ndarray) -> np.ndarray:
    """Where the spring's end goes by itself over the horizon, W, m, (ticks + 1, 3).

    Args:
        state: with the anchor and the friction that is felt.
        inputs: of the tick.
        task: axes of the task, rows.
        engaged: whether the force is regulated.
        pull: stiffness of the spring, N/m, (3,).
    """
    reference, contact, arm = inputs.reference, inputs.contact, inputs.estimate.arm
    ways = np.zeros((len(TIMES) + 1, 3))
    if reference.ahead:
        ways[1:] = [later.tip_position - reference.tip_position for later in reference.ahead]
    first = max(float(np.linalg.norm(ways[1])), 1e-6)
    ways = min(TIMES[0] * float(contact.speed) / first, 1.0) * ways
    path = np.stack([np.interp(NOW, (0.0, *TIMES), ways[:, k]) for k in range(3)], axis=1)
    places = (reference.tip_position - arm + path) @ task.T
    here, speed = float(task[0] @ arm), float(contact.axis_velocity)
    places[:, 0] = float(contact.axis_position) - here + speed * NOW
    if engaged:
        places[:, 0] = state.anchor + float(contact.surface_velocity) * (NOW + state.age)
    places[:, 1:] -= state.felt / pull[1:]
    return places @ task


def _shifted(plan: np.ndarray, time: float) -> np.ndarray:
    """A plan as it looks some time later; its last place stays."""
    return np.concatenate([np.interp(AT + time, AT, row) for row in plan.reshape(3, KNOTS)])


def _planned(
    gains: Any, plan: np.ndarray, tick: int, inputs: Any, rollouts: Rollouts, given: tuple[Any, ...]
) -> np.ndarray:
    """The mean of the samples, weighed by what they cost."""
    ends, task, wanted, engaged, felt = given
    count, body = int(gains.samples), inputs.estimate.body
    draws = np.random.default_rng([int(gains.seed), tick]).normal(size=(count, 3 * KNOTS))
    draws[0] = 0.0
    spread = np.repeat(np.asarray(gains.spread) * [engaged, 1.0, 1.0], KNOTS)
    plans = plan + spread * draws
    plans[1] = 0.0
    knots = plans.reshape(count, 3, KNOTS)
    moves = np.array([[np.interp(NOW, AT, row) for row in each] for each in knots])
    pull = body.model.mass * np.asarray(gains.stiffness)
    helped = (felt / pull[1:]) @ task[1:]  # the board of the model does not rub so much
    positions = ends + helped + np.einsum("nat,ax->ntx", moves, task)
    depth = float(inputs.contact.normal_force) / 5000.0 if engaged else -0.3
    begin = Begin(
        body, inputs.measurement.joint_angles, inputs.measurement.vectoring_angles, inputs.estimate.arm, depth
    )
    speed = float(inputs.contact.surface_velocity) if engaged else 0.0
    flown = rollouts.fly(begin, inputs.reference, positions, speed)
    path = ends[:TICKS] + helped + inputs.estimate.arm
    off = 1e3 * np.einsum("ntx,ax->nta", flown.tip - path, task[1:])
    cost = gains.line_cost * (off**2).sum(-1).mean(-1)
    cost = cost + engaged * gains.force_cost * ((flown.force - wanted) ** 2).mean(-1)
    cost = cost + gains.move_cost * (1e6 * plans**2).sum(-1)
    cost = np.where(np.isfinite(cost), cost, 1e9)
    least = cost.min()
    weights = np.exp(
        -(cost - least) / max(gains.temperature * (np.mean(np.sort(cost)[: count // 2]) - least), 1e-9)
    )
    return weights @ plans / weights.sum()
