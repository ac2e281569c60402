"""What of a controller flies in Python and why, and how long it takes in a tick."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.control.cascade import Cascade
from skylimb.control.controller import Controller, is_traceable
from skylimb.control.laws.user_controller import UserController


class PythonTime(NamedTuple):
    """Time in Python in a tick, over a flight.

    Attributes:
        median: s.
        longest: s.
        period: control period, s.
    """

    median: float
    longest: float
    period: float

    def __str__(self) -> str:
        share, worst = self.median / self.period, self.longest / self.period
        at_worst = f", at worst {worst:.2g}" if worst > 1.0 else ""
        return f"{1e6 * self.median:.0f} us a tick ({share:.2g} control periods{at_worst})"

    def notes(self, who: str) -> tuple[str, ...]:
        """That a controller is too slow for a clock, where it is.

        Args:
            who: takes the time, as in "controller 'own'".
        """
        if self.median <= self.period:
            return ()
        return (
            f"{who} takes {self.median / self.period:.2g} times the control period of "
            f"{1e3 * self.period:g} ms: a robot does not wait for it",
        )


def python_time(took: np.ndarray, period: float) -> PythonTime | None:
    """Median and longest of some ticks' times in Python, s; None where there was none."""
    return (
        PythonTime(float(np.median(took)), float(np.max(took)), period) if len(took) and took.any() else None
    )


def python_parts(controller: Controller) -> dict[str, str]:
    """What of a controller is not compiled, each with the reason; empty where the whole of it is."""
    if is_traceable(controller):
        return controller.in_python if isinstance(controller, Cascade) else {}
    why = controller.untraceable if isinstance(controller, UserController) else ""
    return {f"controller '{controller.name}'": why}
