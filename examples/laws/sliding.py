"""Sliding mode with a boundary layer in the translation slot: as stiff as it must be, and no stiffer.

    skylimb run --controller examples/laws/sliding.toml

The error is to fall along the line s = e' + slope e = 0. Off that line it is pulled back by at most `reach`;
within the layer |s| < width the pull is linear, so that the thrusts do not chatter.
"""

from typing import Annotated

from skylimb.base.keys import Key, configuration
from skylimb.symbolic import clip


@configuration
class Gains:
    slope: Annotated[float, Key("1/s", "of the error along the line", above=0.0, high=20.0)] = 1.5
    reach: Annotated[float, Key("m/s^2", "greatest pull back to the line", above=0.0, high=20.0)] = 2.0
    width: Annotated[float, Key("m/s", "of half of the layer", above=0.0, high=5.0)] = 0.6


def initial_state(gains, start):
    return ()


def step(gains, state, inputs):
    body, reference = inputs.estimate.body, inputs.reference
    error = body.position - reference.position
    rate = body.velocity - reference.velocity
    off = rate + gains.slope * error
    pull = gains.reach * clip(off / gains.width, -1.0, 1.0)
    acceleration = reference.acceleration - gains.slope * rate - pull
    return state, body.model.mass * (acceleration + body.model.gravity), {"off_the_line": off}
