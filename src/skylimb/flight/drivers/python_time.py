"""How long what flies in Python takes in a tick, and what is to be said where it takes too long."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


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
        at_worst = f", {worst:.2g} times at worst" if worst > 1.0 else ""
        return f"{1e6 * self.median:.0f} us a tick ({share:.2g} times the control period{at_worst})"

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
