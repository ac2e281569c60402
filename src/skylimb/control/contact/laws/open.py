"""No judgement of the contact: the paper's controllers follow the clock, whatever they touch."""

from __future__ import annotations

from typing import Any

from skylimb.base.keys import configuration
from skylimb.control.estimation.records import Signals
from skylimb.control.records import ContactView, LawInput, no_memory

PROVIDES = REQUIRES = ()


@configuration
class Gains:
    """Nothing to choose."""


initial_state = no_memory


def step(gains: Any, state: tuple[()], inputs: LawInput) -> tuple[tuple[()], ContactView, Signals]:
    """Nothing is known, and nothing is recorded."""
    return state, ContactView(), {}
