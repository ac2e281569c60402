"""Why a law presses as it does at the moment: one reason a tick, which the log holds as `press_reason`."""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.symbolic import where

REASONS = (
    "as commanded", "searching", "waiting", "loading", "unloading", "eased for lag", "saturated",
)  # fmt: skip
PLAIN, SEARCHING, WAITING, LOADING, UNLOADING, EASED, SATURATED = (float(i) for i in range(len(REASONS)))
"""Searching: there is no touch, and the surface is looked for. Waiting: the press is whole, and the path
rests until it is calm. Loading and unloading: the commanded force itself grows after a touch, or goes before
the pen leaves. Eased for lag: the law presses less, as the pen is behind its path. Saturated: the law asks
for what its integral, its energy or the rotors do not give.
"""

HARD = 2.0
"""A press of more than this is a hard one, N: what tilt and friction then do to a pen is counted in."""


def wanted_force(along: Any, own: Any) -> Any:
    """The normal force that is wanted, N: what the path says (`Reference.force`), else the law's own."""
    return where(along > 0.0, along, own)


def own_force(gains: Any) -> Any:
    """The normal force that a translation law has to press with, its gain `force`, N.

    1 where it has none, or one for each axis.
    """
    own = getattr(gains, "force", 1.0)
    return 1.0 if isinstance(own, tuple | list | np.ndarray) else own
