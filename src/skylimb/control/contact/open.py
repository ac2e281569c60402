"""No judgement of the contact: the paper's controllers follow the clock, whatever they touch."""

from __future__ import annotations

from typing import Any

from skylimb.base.keys import configuration
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.records import ContactView, LawInput

PROVIDES = REQUIRES = ()


@configuration
class Gains:
    """Nothing to choose."""


def initial_state(gains: Gains, start: Start) -> tuple[()]:
    """No memory."""
    return ()


def step(gains: Any, state: tuple[()], inputs: LawInput) -> tuple[tuple[()], ContactView, Signals]:
    """Nothing is known, and nothing is recorded."""
    return state, ContactView(), {}
