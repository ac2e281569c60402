"""Gain scheduling in the translation slot: stiff in the air, soft where it presses.

    skylimb run --controller examples/laws/scheduled.toml

The stiffness along the contact axis is read off a table over the force that the robot presses with. The
damping follows the stiffness, so that the damping ratio stays.
"""

from typing import Annotated

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.symbolic import dot, interp, sqrt

FORCES = (0.0, 1.0, 3.0)  # N


@configuration
class Gains:
    stiffness: Annotated[Vector3, Key("1/s^2", "at 0, 1 and 3 N", above=0.0, high=100.0)] = (4.0, 2.0, 1.0)
    across: Annotated[float, Key("1/s^2", "across the contact axis, over mass", above=0.0, high=100.0)] = 4.0
    damping_ratio: Annotated[float, Key("", "of every axis", low=0.0, high=5.0)] = 1.1


def initial_state(gains, start):
    return ()


def step(gains, state, inputs):
    estimate, reference = inputs.estimate, inputs.reference
    body, axis = estimate.body, reference.contact_axis
    stiffness = interp(-estimate.contact_force, FORCES, gains.stiffness)

    def pull(error, rate, k):
        return -k * error - 2.0 * gains.damping_ratio * sqrt(k) * rate

    error, rate = body.position - reference.position, body.velocity - reference.velocity
    along, along_rate = dot(axis, error), dot(axis, rate)
    acceleration = axis * pull(along, along_rate, stiffness)
    acceleration = acceleration + pull(error - axis * along, rate - axis * along_rate, gains.across)
    return state, body.model.mass * (acceleration + body.model.gravity), {"stiffness": stiffness}
