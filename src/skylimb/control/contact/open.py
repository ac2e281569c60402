"""No judgement of the contact: the paper's controllers follow the clock, whatever they touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from skylimb.control.records import ContactView, LawInput, no_contact

PACED = False
"""Whether the law sets the mission's pace."""


@dataclass(frozen=True)
class Gains:
    """Nothing to choose."""


def initial_state(gains: Gains) -> tuple[()]:
    """No memory."""
    return ()


def step(gains: Any, state: tuple[()], inputs: LawInput) -> tuple[tuple[()], ContactView, dict[str, Any]]:
    """Nothing is known, and nothing is recorded."""
    return state, no_contact(), {}
