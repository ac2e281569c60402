"""A linear-quadratic regulator in the translation slot, whose weights are gains that may change in flight.

    skylimb run --controller examples/laws/lqr.toml

Each axis is a double integrator, x = (p - p_ref, v - v_ref), x' = A x + B u. The feedback u = -K x that costs
least, the integral of position e^2 + velocity e'^2 + effort u^2, comes from a Riccati equation. SciPy solves
it in `prepare`, once for the weights that are set, and `step` is handed K.
"""

from typing import Annotated

import numpy as np
from scipy.linalg import solve_continuous_are

from skylimb.base.keys import Key, configuration
from skylimb.symbolic import dot

A, B = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])


@configuration
class Gains:
    position: Annotated[float, Key("1/m^2", "cost of the position error", above=0.0, high=1e6)] = 16.0
    velocity: Annotated[float, Key("s^2/m^2", "cost of the velocity error", low=0.0, high=1e6)] = 4.0
    effort: Annotated[float, Key("s^4/m^2", "cost of the acceleration", above=0.0, high=1e6)] = 1.0


def prepare(gains, robot):
    cost = np.diag([gains.position, gains.velocity])
    P = solve_continuous_are(A, B, cost, [[gains.effort]])
    return (B.T @ P).ravel() / gains.effort


def initial_state(gains, start):
    return ()


def step(gains, state, inputs, K):
    body, reference, push = inputs.estimate.body, inputs.reference, inputs.estimate.wrench.force
    error = body.position - reference.position
    rate = body.velocity - reference.velocity
    acceleration = reference.acceleration - K[0] * error - K[1] * rate
    # What pushes across the contact axis is made up for; along it, the robot gives way.
    push = push - reference.contact_axis * dot(reference.contact_axis, push)
    return state, body.model.mass * (acceleration + body.model.gravity) - push, {"lqr_feedback": K}
