"""What laws prepare of their gains: made once when gains change, and handed to every step in their place."""

from __future__ import annotations

from typing import Any

from skylimb.base.packing import Layout, is_numeric, numeric, with_floats
from skylimb.control.laws.preset import Preset
from skylimb.control.laws.slots import SLOTS, LiveGains
from skylimb.control.laws.user_functions import Prepared
from skylimb.robots.model import Robot
from skylimb.symbolic import is_symbolic


def preparing(preset: Preset) -> list[str]:
    """Slots whose laws prepare something of their gains."""
    return [name for name, slot in zip(SLOTS, preset.slots, strict=True) if hasattr(slot.law, "prepare")]


def settled(preset: Preset, robot: Robot, gains: LiveGains) -> LiveGains:
    """The gains with what laws prepare of them, computed anew.

    Raises:
        UserCodeError: where a law's `prepare` fails.
    """
    made = {slot: with_floats(_made(preset, robot, slot, gains)) for slot in preparing(preset)}
    return gains._replace(prepared={slot: numeric(one) for slot, one in made.items() if is_numeric(one)})


def handed(preset: Preset, robot: Robot, gains: LiveGains, of_preset: LiveGains) -> Any:
    """The gains as the laws are handed them; an object of a law's own is prepared where it is called.

    Args:
        preset: the laws.
        robot: the controller's model of it.
        gains: numbers or symbols.
        of_preset: numbers to prepare objects of where `gains` are symbols.
    """
    together = {}
    for slot in preparing(preset):
        own, made = getattr(gains, slot), gains.prepared.get(slot)
        if made is None:
            made = _made(preset, robot, slot, of_preset if is_symbolic(Layout(own).pack(own)) else gains)
        together[slot] = Prepared(own, made)
    return gains._replace(**together)


def _made(preset: Preset, robot: Robot, slot: str, gains: Any) -> Any:
    return getattr(preset.laws, slot).prepare(getattr(gains, slot), robot)
