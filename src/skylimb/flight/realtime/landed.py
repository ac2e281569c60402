"""How a robot behind a link is brought down: with the flight's log, or, where that fails, without it."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence

import numpy as np

from skylimb.flight.drivers.free import FreeDriver
from skylimb.flight.realtime.guard import GuardedController
from skylimb.flight.realtime.landing import Landing, landing_from
from skylimb.flight.realtime.look import Look

_log = logging.getLogger(__name__)


class Landed:
    """Follows a landing by what is seen of the robot and commanded.

    Args:
        guard: that leads it down.
        driver: flies.
        look: knows where the robot is.
        hover: sum of its thrusts in hover, N.
        floor: height of the centre of gravity at which it is down, m.
    """

    def __init__(
        self, guard: GuardedController, driver: FreeDriver, look: Look, hover: float, floor: float
    ) -> None:
        self._guard, self._driver, self._look = guard, driver, look
        self._hover, self._floor = hover, floor
        self._landing: Landing | None = None

    @property
    def over(self) -> bool:
        """Whether it is down."""
        return self._landing is not None and self._landing.over

    def next(self, seen: Sequence[np.ndarray], thrusts: np.ndarray, dt: float) -> None:
        """A tick of the landing, by the measurement's first six entries and the commanded thrusts, N."""
        landing = self._landing or self._begun()
        place = self._look.place(seen) if self._guard.sees else None
        height = None if place is None else float(place[2])
        self._landing = landing.after(height, float(np.sum(thrusts)) / self._hover, dt)

    def _begun(self) -> Landing:
        """A landing from the reference that is flown, or from the first one where none was."""
        above = float((self._guard.flown or self._driver.first).position[2])
        return landing_from(above, self._floor)

    def without_log(self, due: Iterator[int], dt: float, error: BaseException) -> None:
        """Bring the robot down after an error that would end its flight, and note that on the error.

        Args:
            due: the flight's ticks, which go on.
            dt: control period, s.
            error: what was raised.
        """
        _log.warning("%s: %s; the robot is led back and down first", type(error).__name__, error)
        self._guard.retreat("the flight's loop failed")
        landing = self._landing = self._landing or self._begun()
        for k in due:
            try:
                measured, command = self._driver.fly_on(k)
                self.next(measured.entries[:6], np.asarray(command.thrusts), dt)
            except Exception:  # a tick without a command: the next one may have one
                self._landing = landing.after(None, 1.0, dt)
            landing = self._landing
            if self.over:
                break
        error.add_note("the robot was led back and down before this was raised")
