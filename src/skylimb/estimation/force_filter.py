"""The filtered contact force f_hat of eq:admittance control. The paper prints no filter; this one is ours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from skylimb.config import require_positive
from skylimb.symbolic import low_pass


@dataclass(frozen=True)
class ForceFilter:
    """The low pass.

    Attributes:
        cutoff: Hz.
    """

    cutoff: float = 2.0

    def __post_init__(self) -> None:
        require_positive("force_filter", "cutoff", self.cutoff, "Hz")


def filter_force(gains: Any, before: Any, force: Any, dt: float) -> Any:
    """f_hat, N, of a force along the contact axis, N.

    Args:
        gains: a `ForceFilter`.
        before: f_hat of the last tick, N.
        force: now, N.
        dt: control period, s.
    """
    return low_pass(before, force, 2.0 * math.pi * gains.cutoff, dt)
