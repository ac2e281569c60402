"""The loop: one flight, tick by tick, from take-off to its end or its loss."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from skylimb.base.errors import UserCodeError
from skylimb.base.packing import Layout
from skylimb.control.loop.flight import Flight, stopped_cause, unfinished
from skylimb.control.loop.terminations import Terminations, find_loss
from skylimb.control.missions.mission import Mission

CHECK_INTERVAL = 100
"""Ticks between two looks at the flight's health: a lost flight ends within that many ticks of the loss."""

Progress = Callable[[int, int], None]
"""Called now and then with (ticks of the mission flown, ticks in all)."""


class Driver(Protocol):
    """Flies one flight tick by tick: senses, controls, records, actuates."""

    @property
    def layout(self) -> Layout[dict[str, Any]]:
        """Where each signal stands in a row of the log; known after the first tick at the latest."""
        ...

    @property
    def log(self) -> np.ndarray:
        """One row of signals a tick; NaN where nothing has been flown yet."""
        ...

    @property
    def tick(self) -> Callable[[int], int]:
        """Flies tick `k` and returns the whole tick of the mission that comes next."""
        ...

    def fault(self) -> str:
        """Why the vehicle's state can no longer be trusted; empty while it can."""
        ...

    def notes(self) -> tuple[str, ...]:
        """What is to be said of the flight so far, one line each."""
        ...


class Loop:
    """A flight that is stepped from outside.

        flight = skylimb.begin("paper", controller="hybrid")
        while flight.tick():
            ...                     # look at flight.signal("contact_force"), change a gain, wait for a clock
        run = flight.finish()

    Args:
        driver: flies the ticks.
        mission: what is flown.
        limits: beyond which the flight is lost.
        count: ticks that the flight may have.
        check_interval: ticks between two looks at its health.
        start: ticks that the driver has flown already; above 0 for a flight that goes on from its middle.

    Attributes:
        driver: what flies the ticks.
        ticks: flown so far.
        error: of a user's code that ended the flight.
    """

    def __init__(
        self,
        driver: Driver,
        mission: Mission,
        limits: Terminations,
        count: int,
        check_interval: int = CHECK_INTERVAL,
        start: int = 0,
    ) -> None:
        self.driver, self._mission, self._limits = driver, mission, limits
        self._count, self._interval = count, check_interval
        self._last = len(mission.times) - 1
        self._next_check = min(start - start % check_interval + check_interval, count)
        self.ticks = self._at = self._checked = start
        self._flight: Flight | None = None
        self.error: UserCodeError | None = None
        self._fly = driver.tick

    @property
    def time(self) -> float:
        """Time since take-off, s."""
        return self.ticks * self._mission.period

    @property
    def over(self) -> bool:
        """Whether the flight has ended or is lost."""
        return self._flight is not None

    def signal(self, name: str) -> np.ndarray:
        """The values of one signal so far, (ticks,) or (ticks, width)."""
        return self._so_far().signal(name)

    def tick(self) -> bool:
        """Fly one tick; false once the flight is over.

        Raises:
            UserCodeError: of the first tick; later the flight ends with it as its cause.
        """
        if self._flight is not None:
            return False
        try:
            self._at = at = self._fly(self.ticks)
        except UserCodeError as error:
            if not self.ticks:
                raise
            self.error = error
            cause = f"broken off at t = {self.time:.3f} s: {error}"
            self._end(self._lost(self._loss() or (self.ticks - 1, cause)))
            return False
        self.ticks += 1
        if at > self._last or self.ticks == self._next_check:
            self._check()
        return self._flight is None

    def fly(self, progress: Progress | None = None) -> Flight:
        """Fly to the end."""
        while self._flight is None:
            for _ in range(self._next_check - self.ticks):
                if not self.tick():
                    break
            if progress is not None:
                progress(min(self._at, self._last + 1), self._last + 1)
        return self._flight

    def stop(self) -> Flight:
        """The flight, ended here if it was not; one that is stopped before its end has that as its cause."""
        return self._flight or self._end(self.stopped())

    def stopped(self) -> Flight:
        """The flight as it would be if it were stopped here; it can go on afterwards."""
        if self._flight is not None:
            return self._flight
        lost = self._loss()
        return self._lost(lost) if lost else self._so_far(stopped_cause(self.ticks, self._mission))

    def _so_far(self, cause: str = "") -> Flight:
        return Flight(self.driver.log, self.driver.layout, self.ticks, cause)

    def _loss(self) -> tuple[int, str] | None:
        lost = find_loss(self._so_far(), self._mission, self._limits, self._checked)
        fault = "" if lost else self.driver.fault()
        return (self.ticks - 1, fault_cause(fault, self.ticks, self._mission)) if fault else lost

    def _lost(self, lost: tuple[int, str]) -> Flight:
        return Flight(self.driver.log, self.driver.layout, lost[0] + 1, lost[1])

    def _end(self, flight: Flight) -> Flight:
        self._flight = replace(flight, notes=self.driver.notes())
        return self._flight

    def _check(self) -> None:
        lost = self._loss()
        if lost is not None:
            self._end(self._lost(lost))
        elif self._at > self._last:
            self._end(self._so_far())
        elif self.ticks == self._count:
            self._end(unfinished(self._mission, self._so_far()))
        self._checked = self.ticks
        self._next_check = min(self.ticks + self._interval, self._count)


def fault_cause(fault: str, ticks: int, mission: Mission) -> str:
    """The cause of a flight whose vehicle reports a fault after `ticks` ticks."""
    return f"diverged: {fault} before t = {(ticks - 1) * mission.period:.3f} s"
