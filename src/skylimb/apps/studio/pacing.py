"""The wall clock of a live flight: which ticks are due, and how fast it really goes."""

from __future__ import annotations

import time as clock
from collections import deque
from collections.abc import Callable

from skylimb.base.errors import ConfigError

SLOWEST, FASTEST = 0.1, 20.0
"""Speeds over real time that may be wanted."""

LATE = 0.005
"""A tick counts as late that is flown this much after its time, s."""

LEAD = 0.01
"""A tick may be flown this much before its time, s: a system that is busy elsewhere for a moment then makes
nothing late. What a page does acts this much later."""

_SLICE = 0.02  # s of work at most before commands are heard again
_FORGIVEN = 0.1  # s by which a flight may lag behind before its schedule begins anew
_WINDOW = 1.0  # s over which the speed is measured


class Pacing:
    """Flies ticks when they are due, or `LEAD` before. Deadlines are absolute, so that no error adds up.

    `flown` counts the ticks, `late` those that came more than `LATE` after their time.

    Args:
        period: of a tick, s of flight.
        now: the wall clock, s.
    """

    def __init__(self, period: float, now: Callable[[], float] = clock.perf_counter) -> None:
        self._period, self._now = period, now
        self._speed = 1.0
        self.late = self.flown = 0
        self.restart()

    @property
    def speed(self) -> float:
        """The speed that is wanted, over real time."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        if not SLOWEST <= speed <= FASTEST:
            raise ConfigError(f"speed = {speed:g} is outside of {SLOWEST:g} .. {FASTEST:g}")
        self._speed = float(speed)
        self.restart()

    @property
    def reached(self) -> float:
        """The speed of the last second, or since it began, over real time; 0 while nothing is flown."""
        now = self._now()
        while self._recent and now - self._recent[0] > _WINDOW:
            self._recent.popleft()
        return len(self._recent) * self._period / min(_WINDOW, now - self._begun + LEAD)

    @property
    def wait(self) -> float:
        """Seconds until the next tick may be flown."""
        return max(0.0, self._due() - LEAD - self._now())

    def restart(self) -> None:
        """Begin a new schedule here, as after a pause."""
        self._begun = self._origin = self._now()
        self._done = 0
        self._recent: deque[float] = deque()

    def fly(self, advance: Callable[[int], int]) -> int:
        """Fly what may be flown, for `_SLICE` of work at most; returns how many ticks.

        A flight that is too slow for its speed goes on as fast as it can: what it lags behind is forgotten.

        Args:
            advance: flies some ticks and returns how many it really flew.
        """
        begun, total = self._now(), 0
        while (now := self._now()) >= self._due() - LEAD and now - begun < _SLICE:
            behind = now - self._due()
            if behind > _FORGIVEN:
                self._origin += behind
            if not advance(1):
                self.restart()
                break
            self.late += behind > LATE
            self.flown += 1
            self._done += 1
            self._recent.append(now)
            total += 1
        return total

    def _due(self) -> float:
        return self._origin + self._done * self._period / self._speed
