"""A spring and a damper on the centre of gravity, nothing else."""

from typing import Annotated

from skylimb.base.keys import Key, configuration


@configuration
class Gains:
    """A spring and a damper."""

    stiffness: Annotated[float, Key("1/s^2", "stiffness over mass", above=0.0, high=100.0)]
    damping: Annotated[float, Key("1/s", "damping over mass", above=0.0, high=100.0)]


def initial_state(gains, start):
    return ()


def step(gains, state, inputs):
    body, reference = inputs.estimate.body, inputs.reference
    pull = gains.stiffness * (reference.position - body.position)
    brake = gains.damping * (reference.velocity - body.velocity)
    force = body.model.mass * (pull + brake + body.model.gravity)
    return state, force, {"spring_force": body.model.mass * pull}
