"""Our controller in place of the lab's: sensors in, thrusts and angles out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from skylimb.flights.takeoff import Takeoff
from skylimb.missions.mission import Mission
from skylimb.realtime.pacer import Pacer
from skylimb.ros1 import topics
from skylimb.ros1.desk import Arrived, Desk
from skylimb.ros1.limits import FlightLimits
from skylimb.ros1.live import Kept, LiveRecord, measured_layout, measured_row
from skylimb.ros1.messages import Gains, Joints, PMatrix
from skylimb.ros1.outputs import Names, Outgoing, Rates, commanded, seen_by_anybody
from skylimb.ros1.pilot import Pilot
from skylimb.ros1.senses import Senses
from skylimb.ros1.tick import Inputs, Tick


class Controlled:
    """One tick of our controller for a robot that speaks the lab's topics.

    Args:
        takeoff: robot, controller and the first mission; its plant is not used.
        controller: the same, compiled where it can be.
        missions: by name.
        link: whose pose is on the lab's topics.
        pacer: of the ticks.
        cells: of the battery.
        limits: of the flight states.
    """

    def __init__(
        self,
        takeoff: Takeoff,
        controller: Any,
        missions: Mapping[str, Mission],
        link: str,
        pacer: Pacer,
        cells: int = 6,
        limits: FlightLimits | None = None,
    ) -> None:
        robot, period = takeoff.robot, takeoff.period
        self.pilot = Pilot(robot, controller, missions, link, pacer, period, limits)
        self._senses = Senses(robot, link)
        self._desk, self._pacer = Desk(cells, self._senses.take), pacer
        self._names, self._rates = Names(robot), Rates(period)
        sample = self.pilot.rehearsed()
        layout = measured_layout(robot)
        self._live = LiveRecord(robot, takeoff.experiment, takeoff.controller, layout, period, sample)
        first = next(iter(missions.values())).first
        self._vectoring = np.asarray(first.vectoring_angles, dtype=float)
        self._k, self._rotors = 0, robot.n_rotors
        self._battery: float | None = None
        self.last: Tick | None = None
        self.kept: list[Kept] = []

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met."""
        return self.pilot.faults + self._desk.counts + self._senses.counts

    @property
    def over(self) -> str:
        """Never by itself."""
        return ""

    def tick(self, arrived: Iterable[Arrived], stamp: float) -> list[Outgoing]:
        """One tick; `stamp` is the middleware's time, s."""
        came, now, k = self._desk.sort(arrived), self._pacer.time(), self._k
        measured, taken = self._senses.measurement(now, self._vectoring)
        tick = self.pilot.tick(
            Inputs(
                now,
                measured,
                taken,
                came.orders,
                tuple((wish, now - stamp) for wish in came.wishes),
                came.mission,
                came.acknowledged,
                came.battery,
            )
        )
        self._vectoring = np.asarray(tick.command.vectoring_angles, dtype=float)
        out = [
            *seen_by_anybody(k, stamp, tick, self._rates),
            *commanded(k, stamp, tick, self._names, self._rates),
            *self._moved(k, stamp, tick),
        ]
        if measured is not None:
            out += self._live.add(tick, measured_row(measured, tick))
        if not tick.flying.in_air:
            self.close()
        self._k, self.last = k + 1, tick
        return out

    def close(self) -> None:
        """Keep the flight that is under way."""
        flight = self._live.finish()
        if flight is not None:
            self.kept.append(flight)

    def _moved(self, k: int, stamp: float, tick: Tick) -> list[Outgoing]:
        """Joints, and zero gains: the flight controller adds nothing to the thrusts."""
        out = []
        if self._rates.due(topics.JOINTS_CTRL, k):
            angles = tuple(np.asarray(tick.command.joint_angles, dtype=float).tolist())
            out.append(Outgoing(topics.JOINTS_CTRL, Joints(stamp, self._names.joints, angles)))
        if self._rates.due(topics.GAINS, k):
            out.append(Outgoing(topics.GAINS, Gains(((0,) * 7,) * self._rotors)))
        if self._rates.due(topics.P_MATRIX, k):
            out.append(Outgoing(topics.P_MATRIX, PMatrix(((0, 0, 0),) * self._rotors, (0,) * 6)))
        return out
