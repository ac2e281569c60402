"""A stiff arm: the reach stays at its reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from skylimb.control.records import LawInput


@dataclass(frozen=True)
class Gains:
    """Nothing to choose."""


def initial_state(gains: Gains, reach: float) -> tuple[()]:
    """No memory."""
    return ()


def step(
    gains: Any, state: tuple[()], inputs: LawInput, reach_limits: tuple[float, float]
) -> tuple[tuple[()], Any]:
    """The reference's reach, m."""
    return state, inputs.reference.reach
