"""Ticks on the wall clock: every deadline counts from the start, so that nothing drifts."""

from __future__ import annotations

import time
from collections.abc import Callable

SPIN = 0.0003
"""Seconds before a deadline at which sleeping ends and waiting begins: a sleeper is woken late."""


class Pacer:
    """Waits for tick k until start + k * period.

    Args:
        period: between two ticks, s.
        now: a clock that never goes back, ns.
        sleep: for some seconds.
        spin: seconds before a deadline that are waited awake; 0 leaves the processor to others.
    """

    def __init__(
        self,
        period: float,
        now: Callable[[], int] = time.monotonic_ns,
        sleep: Callable[[float], None] = time.sleep,
        spin: float = SPIN,
    ) -> None:
        self.period = period
        self._period, self._spin = round(period * 1e9), round(spin * 1e9)
        self._now, self._sleep = now, sleep
        self._origin = self._start = self._deadline = self._begun = now()

    def start(self, delay: float = 0.0) -> None:
        """Tick 0 is due in `delay` seconds."""
        self._origin = self._start = self._deadline = self._begun = self._now() + round(delay * 1e9)

    def wait(self, k: int) -> float:
        """Return when tick `k` is due, at once if that is over; how late it then is, s."""
        self._deadline = self._start + k * self._period
        left = self._deadline - self._now()
        while left > 0:
            if left > self._spin:
                self._sleep((left - self._spin) * 1e-9)
            left = self._deadline - self._now()
        self._begun = self._deadline - left
        return -left * 1e-9

    def forgive(self) -> None:
        """What was lost is not caught up: later ticks are due as if the present one had begun in time.

        Caught up, hundreds of ticks fly by one measurement, and their commands come at once.
        """
        self._start += self._begun - self._deadline
        self._deadline = self._begun

    @property
    def late(self) -> float:
        """How late the present tick began, s."""
        return (self._begun - self._deadline) * 1e-9

    @property
    def missed(self) -> bool:
        """Whether the present tick began when the next one was due already."""
        return self._begun - self._deadline >= self._period

    def stood_still(self, ticks: float) -> bool:
        """Whether the present tick began more than so many periods late: nobody ticked meanwhile."""
        return self._begun - self._deadline > ticks * self._period

    def clock(self) -> float:
        """The clock itself, s; no start changes it."""
        return self._now() * 1e-9

    @property
    def started(self) -> float:
        """When tick 0 was due, s on the clock."""
        return self._origin * 1e-9

    def time(self) -> float:
        """Time since tick 0 was due, s."""
        return self.clock() - self.started

    def elapsed(self) -> float:
        """Time since the present tick was due, s."""
        return (self._now() - self._deadline) * 1e-9


def stepped(period: float) -> Pacer:
    """A pacer whose clock goes on only while it waits: whoever works by it may take any time."""
    time_ns = [0]

    def sleep(seconds: float) -> None:
        time_ns[0] += round(seconds * 1e9)

    return Pacer(period, lambda: time_ns[0], sleep, spin=0.0)
