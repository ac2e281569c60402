"""The filtered contact force f_hat of eq:admittance control. The paper prints no filter; this one is ours."""

from __future__ import annotations

import math
from typing import Annotated, Any

from skylimb.base.keys import Key, configuration
from skylimb.symbolic import low_pass


@configuration
class ForceFilter:
    """The low pass."""

    cutoff: Annotated[float, Key("Hz", "low pass on the contact force, f_hat", above=0.0, high=1e4)] = 2.0


def filter_force(gains: Any, before: Any, force: Any, dt: float) -> Any:
    """f_hat, N, of a force along the contact axis, N.

    Args:
        gains: a `ForceFilter`.
        before: f_hat of the last tick, N.
        force: now, N.
        dt: control period, s.
    """
    return low_pass(before, force, 2.0 * math.pi * gains.cutoff, dt)
