"""Unconstrained model-predictive control in the translation slot: it sees where the path will go.

    skylimb run --controller examples/laws/preview.toml

Each axis is a double integrator, p'' = u. Of all accelerations u over the horizon, held for a step each, it
takes those that keep p near the references ahead with little effort,

    min |p_ref - (p + v t + S u)|^2 + effort |u|^2    =>    u = (S^T S + effort E)^-1 S^T (p_ref - p - v t),

applies the first one, and begins anew at the next tick. So what is left of it is a row of numbers.
"""

from dataclasses import dataclass

import numpy as np

from skylimb.control.needs import Needs
from skylimb.symbolic import dot

STEP, STEPS, EFFORT = 0.15, 12, 0.1  # s, how many, s^4
TIMES = STEP * np.arange(1, STEPS + 1)
LEFT = np.clip(TIMES[:, None] - TIMES[None, :] + STEP, 0.0, None)  # time left at t_k when u_j begins
S = 0.5 * (LEFT**2 - np.clip(LEFT - STEP, 0.0, None) ** 2)
ROW = np.linalg.solve(S.T @ S + EFFORT * np.eye(STEPS), S.T)[0]


@dataclass(frozen=True)
class Gains:
    preview: bool = True  # false: the path ahead goes on as it goes now


def needs(gains):
    return Needs(preview=tuple(TIMES) if gains.preview else ())


def initial_state(gains, start):
    return ()


def step(gains, state, inputs):
    body, reference, force = inputs.estimate.body, inputs.reference, inputs.estimate.wrench.force
    wanted = [reference.position + reference.velocity * t for t in TIMES]
    if gains.preview:
        wanted = [later.position for later in reference.ahead]
    missing = [p - body.position - body.velocity * t for p, t in zip(wanted, TIMES, strict=True)]
    acceleration = sum(k * error for k, error in zip(ROW, missing, strict=True))
    # What pushes across the contact axis is made up for; along it, the robot gives way.
    pushed = force - reference.contact_axis * dot(reference.contact_axis, force)
    return state, body.model.mass * (acceleration + body.model.gravity) - pushed, {}
