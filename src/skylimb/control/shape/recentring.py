"""The arm makes up the surface's motion, and brings the centre of gravity back to its anchor.

    r' = (1 - share) v_surface + k (x - x_anchor),      |r'| <= rate_limit,

so that the force stays with the thrust: a force admittance on the arm at the thrust's bandwidth pumps a
bounce. Out of contact the arm goes back to its nominal reach.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from skylimb.config import require_positive, require_range
from skylimb.control.records import ArmTarget, LawInput
from skylimb.estimation.records import Signals, Start
from skylimb.spatial import dot
from skylimb.symbolic import clip, where


@dataclass(frozen=True)
class Gains:
    """How the arm moves.

    Attributes:
        rate: k, 1/s.
        arm_share: share of the surface's motion that the arm takes ahead of any error, 0 to 1.
        rate_limit: m/s.
        offset: of the reach in contact before the slide from the nominal one, m.
    """

    rate: float = 0.3
    arm_share: float = 0.5
    rate_limit: float = 0.08
    offset: float = 0.0

    def __post_init__(self) -> None:
        require_positive("shape", "rate", self.rate, "1/s")
        require_range("shape", "arm_share", self.arm_share, 0.0, 1.0)
        require_positive("shape", "rate_limit", self.rate_limit, "m/s")
        require_range("shape", "offset", self.offset, -0.5, 0.5, "m")


class State(NamedTuple):
    """Commanded reach, m, and its rate, m/s."""

    reach: Any
    rate: Any


def initial_state(gains: Gains, start: Start) -> State:
    """At the nominal reach."""
    return State(start.reach, 0.0)


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
