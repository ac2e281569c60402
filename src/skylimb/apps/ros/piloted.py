"""A profile with a pilot: a tick from what arrived to what is published, whatever the robot is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from skylimb.analysis.exchange.lab_topics import GIMBALS_TORQUE
from skylimb.apps.ros.answers import ANSWER
from skylimb.apps.ros.asking import Switch
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.heard import Heard
from skylimb.apps.ros.live_record import LiveRecord
from skylimb.apps.ros.messages import Arrived, Outgoing
from skylimb.apps.ros.pilot import Pilot
from skylimb.apps.ros.profile import PendingRun
from skylimb.apps.ros.sorting import MessageSorter
from skylimb.apps.ros.states import FlightState
from skylimb.apps.ros.tick import Inputs, Received, Tick
from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Measurement, Taken


class Piloted(ABC):
    """A profile that flies.

    Args:
        flyer: who flies, and with what.
        layout: of what is recorded of the robot.

    Attributes:
        caught_up: ticks that are caught up when they come late, at most.
        last: the last tick; None before the first one.
        kept: flights and missions so far.
    """

    def __init__(self, flyer: Flyer, layout: Layout[dict[str, Any]]) -> None:
        self.pilot, self._pacer, self._period = Pilot(flyer), flyer.pacer, flyer.period
        self._robot, self._names = flyer.robot, flyer.names
        self._sorter = MessageSorter(flyer.cells, self._sensed, flyer.limits)
        self._live = LiveRecord(flyer.plan, layout, self.pilot.rehearsed())
        self._k, self._heard = 0, Heard()
        self._limp = frozenset[bool]()
        self.caught_up = flyer.guard_limits.overruns
        self.last: Tick | None = None
        self.kept: list[PendingRun] = []

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met."""
        return self.pilot.faults + self._sorter.counts

    @property
    def over(self) -> str:
        """Why it cannot go on; a robot ends never by itself."""
        return ""

    def tick(self, arrived: Iterable[Arrived], stamp: float) -> list[Outgoing]:
        """One tick; `stamp` is the middleware's time, s."""
        arrived = list(arrived)
        received, now = self._sorter.sort(arrived), self._pacer.time()
        measured, taken = self._measured(now)
        acknowledged, carried = self._acknowledged(received), self._carried(received)
        received = replace(received, acknowledged=acknowledged, carried=carried)
        heard = self._heard.ages(now), self._heard.offsets(stamp - now)
        rest = self._heard.rest(now)
        lost, rate = self._lost(now), self._heard.rate
        inputs = Inputs(
            now, measured, taken, received, now - stamp, *heard, rest, lost, rate, self._missing()
        )
        tick = self.pilot.tick(inputs)
        out = [*self._messages(stamp, measured, tick), *self._switched(arrived, tick)]
        if measured is not None:
            out += self._live.add(tick, self._recorded(measured, tick))
        self._apply(tick)
        if not tick.flying.in_air:
            self.close()
        self._k, self.last = self._k + 1, tick
        return out

    def close(self) -> None:
        """Keep the flight that is under way."""
        flight = self._live.finish()
        if flight is not None:
            self.kept.append(flight)

    def _switched(self, arrived: Iterable[Arrived], tick: Tick) -> Iterator[Outgoing]:
        """Servos go limp on the ground alone, and hold again before anything flies."""
        rests = tick.flying.state == FlightState.ARM_OFF
        for one in arrived:
            if isinstance(one.value, Switch):
                obeyed = rests or one.value.on
                if obeyed:
                    gimbals = one.topic == GIMBALS_TORQUE.name
                    self._limp = self._limp - {gimbals} if one.value.on else self._limp | {gimbals}
                    yield from self._enable(gimbals, one.value.on)
                words = tick.flying.state.name
                yield Outgoing(ANSWER, (one.value.token, obeyed, words if obeyed else f"not in {words}"))
        if self._limp and not rests:
            for gimbals in self._limp:
                yield from self._enable(gimbals, True)
            self._limp = frozenset()

    def _enable(self, gimbals: bool, on: bool) -> Iterator[Outgoing]:
        """Switch the torque of the gimbals' servos, or of the joints'."""
        yield from ()

    def _sensed(self, arrived: Arrived) -> None:
        """Take what a sensor says."""
        self._heard = self._heard.take(arrived, self._robot.description.gravity)

    def _lost(self, now: float) -> str:
        """Why the robot has to be led back though it is seen; empty while nothing is."""
        return ""

    def _missing(self) -> tuple[str, ...]:
        """Topics without which there is no measurement, and on which nothing has come that is one."""
        return ()

    def _acknowledged(self, received: Received) -> int | None:
        """The last command that the flight controller acknowledged."""
        return received.acknowledged

    def _carried(self, received: Received) -> float:
        """The share of its weight that the motors give at most."""
        return np.inf

    def _apply(self, tick: Tick) -> None:  # noqa: B027 - a real robot does what is published
        """What follows of a tick."""

    @abstractmethod
    def _measured(self, now: float) -> tuple[Measurement | None, Taken]:
        """The measurement of now and when it was taken, s."""

    @abstractmethod
    def _recorded(self, measured: Measurement, tick: Tick) -> np.ndarray:
        """What is recorded of the robot at a tick."""

    @abstractmethod
    def _messages(self, stamp: float, measured: Measurement | None, tick: Tick) -> Iterator[Outgoing]:
        """What is published of a tick."""
