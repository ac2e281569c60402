"""What a law adds up, as proportional, integral and derivative accelerations: for people to tune by.

A translation law says its own in W, m/s^2, an attitude law in C, rad/s^2, among its signals. They are shown
where a robot is flown, and recorded nowhere else: a cascade leaves them out unless it is asked for them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from skylimb.base.signal_table import PLACE_TERMS, TURN_TERMS
from skylimb.symbolic import Array

_ZERO = np.zeros(3)


def place_terms(proportional: Array, derivative: Array, integral: Array = _ZERO) -> dict[str, Array]:
    """Signals of a translation law: what it adds up, W, m/s^2, (3,) each."""
    return dict(zip(PLACE_TERMS, (proportional, integral, derivative), strict=True))


def turn_terms(proportional: Array, derivative: Array, integral: Array = _ZERO) -> dict[str, Array]:
    """Signals of an attitude law: what it adds up, C, rad/s^2, (3,) each."""
    return dict(zip(TURN_TERMS, (proportional, integral, derivative), strict=True))


def without_terms(signals: Mapping[str, Any]) -> dict[str, Any]:
    """The signals that are recorded."""
    return {name: value for name, value in signals.items() if name not in (*PLACE_TERMS, *TURN_TERMS)}
