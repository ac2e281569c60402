"""A stiff arm: the reach stays at its reference."""

from __future__ import annotations

from typing import Any

from skylimb.base.keys import configuration
from skylimb.control.estimation.records import Signals
from skylimb.control.records import ArmTarget, LawInput, no_memory

PROVIDES = ("arm.reach", "arm.rate")
REQUIRES = ()


@configuration
class Gains:
    """Nothing to choose."""


initial_state = no_memory


def step(
    gains: Any, state: tuple[()], inputs: LawInput, reach_limits: tuple[float, float]
) -> tuple[tuple[()], ArmTarget, Signals]:
    """The reference's reach, m."""
    return state, ArmTarget(inputs.reference.reach, 0.0), {}
