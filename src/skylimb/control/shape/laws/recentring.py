"""The arm makes up the surface's motion, and brings the centre of gravity back to its anchor.

    r' = arm_share v_surface + k (x - x_anchor),      |r'| <= rate_limit,

so that the force stays with the thrust: a force admittance on the arm at the thrust's bandwidth pumps a
bounce. Out of contact the arm goes back to its nominal reach.
"""

from __future__ import annotations

from typing import Annotated, Any

from skylimb.base.keys import Key, configuration
from skylimb.control.estimation.records import Signals
from skylimb.control.records import ArmTarget, LawInput
from skylimb.control.shape.laws.admittance import State, initial_state
from skylimb.symbolic import clip, dot, where

__all__ = ["PROVIDES", "REQUIRES", "Gains", "State", "initial_state", "step"]
PROVIDES = ("arm.reach", "arm.rate")
REQUIRES = ("estimate.body", "contact.engaged", "contact.anchor", "contact.surface_velocity")


@configuration
class Gains:
    """How the arm moves."""

    rate: Annotated[
        float, Key("1/s", "k, speed of the arm per distance from the anchor", above=0.0, high=100.0)
    ] = 0.3
    arm_share: Annotated[
        float,
        Key("", "share of the surface's motion that the arm takes ahead of any error", low=0.0, high=1.0),
    ] = 0.5
    rate_limit: Annotated[float, Key("m/s", "greatest speed of the arm", above=0.0, high=10.0)] = 0.08
    offset: Annotated[
        float, Key("m", "difference of the reach out of contact from the nominal one", low=-0.5, high=0.5)
    ] = 0.0


def step(
    gains: Any, state: State, inputs: LawInput, reach_limits: tuple[float, float]
) -> tuple[State, ArmTarget, Signals]:
    """The commanded reach, m, within its limits."""
    contact, dt = inputs.contact, inputs.dt
    ahead = dot(inputs.reference.contact_axis, inputs.estimate.body.position) - contact.anchor
    following = gains.arm_share * contact.surface_velocity + gains.rate * ahead
    home = inputs.reference.reach + gains.offset
    rate = where(contact.engaged > 0.5, following, gains.rate * (home - state.reach))
    reach = state.reach + clip(rate, -gains.rate_limit, gains.rate_limit) * dt
    reach = clip(reach, reach_limits[0], reach_limits[1])
    return State(reach, (reach - state.reach) * (1.0 / dt)), ArmTarget(reach, state.rate), {}
