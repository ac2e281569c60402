"""Plant and controller behind the lab's user-level topics: a robot for a laptop."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from skylimb.apps.ros1.body import Bodies
from skylimb.apps.ros1.desk import Arrived, Desk
from skylimb.apps.ros1.grounded import GroundedPlant
from skylimb.apps.ros1.limits import FlightLimits
from skylimb.apps.ros1.live import Kept, LiveRecord
from skylimb.apps.ros1.outputs import (
    Accelerometer,
    Names,
    Outgoing,
    Rates,
    commanded,
    seen_by_anybody,
    seen_by_sensors,
)
from skylimb.apps.ros1.pilot import Pilot
from skylimb.apps.ros1.tick import Inputs, Tick
from skylimb.apps.ros1.topics import NAMESPACE
from skylimb.control.loop.flight import unfinished
from skylimb.control.missions.mission import Mission
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.record import recorded
from skylimb.flight.takeoff import Takeoff


class Both:
    """One tick of plant and controller.

    Args:
        takeoff: plant, robot, controller and the first mission.
        controller: the same, compiled where it can be.
        missions: by name.
        link: whose pose is on the lab's topics.
        pacer: of the ticks.
        cells: of the battery.
        limits: of the flight states.
        namespace: of the lab's frames.
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
        namespace: str = NAMESPACE,
    ) -> None:
        robot, period = takeoff.robot, takeoff.period
        self.pilot = Pilot(robot, controller, missions, link, pacer, period, limits)
        self.plant = GroundedPlant(takeoff)
        self._takeoff, self._pacer, self._missions = takeoff, pacer, missions
        self._desk, self._names, self._rates = Desk(cells), Names(robot, namespace), Rates(period)
        self._felt = Accelerometer(period, robot.description.gravity)
        self._bodies = Bodies(robot, link)
        sample = self.pilot.rehearsed()
        self._live = LiveRecord(takeoff.plan, self.plant.layout, sample)
        self._k = 0
        self.last: Tick | None = None
        self.kept: list[Kept] = []

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met."""
        return self.pilot.faults + self._desk.counts

    @property
    def over(self) -> str:
        """Why it cannot go on; empty while it can."""
        return self.plant.fault() or (
            "the time is over for which noise is laid out" if self.plant.over else ""
        )

    def tick(self, arrived: Iterable[Arrived], stamp: float) -> list[Outgoing]:
        """One tick; `stamp` is the middleware's time, s."""
        came, now, k = self._desk.sort(arrived), self._pacer.time(), self._k
        measured = self.plant.measure()
        arming = self.pilot.flying.arming
        tick = self.pilot.tick(
            Inputs(
                now,
                measured,
                now,
                came.orders,
                tuple((wish, now - stamp) for wish in came.wishes),
                came.mission,
                None if arming is None else int(arming),  # a simulated flight controller obeys at once
                came.battery,
            )
        )
        row = self.plant.record(measured, tick.command)
        body = tick.body or self._bodies.of(measured)
        felt = self._felt.of(self._bodies.of(self.plant.truth()))
        out = [
            *seen_by_sensors(k, stamp, measured, body, felt, self._names, self._rates),
            *seen_by_anybody(k, stamp, tick, self._names, self._rates),
            *commanded(k, stamp, tick, self._names, self._rates),
            *self._live.add(tick, row),
        ]
        self.plant.apply(tick.command)
        self._keep_what_is_over(tick)
        self._k, self.last = k + 1, tick
        return out

    def close(self) -> None:
        """Keep the flight that is under way."""
        flight = self._live.finish()
        if flight is not None:
            self.kept.append(flight)

    def _keep_what_is_over(self, tick: Tick) -> None:
        flown = self._live.mission_flown(tick)
        if flown is not None:
            name, flight = flown
            mission = self._missions[name]
            run = lambda: recorded(self._takeoff, unfinished(mission, flight()), mission)  # noqa: E731
            self.kept.append(Kept(name, run))
        if not tick.flying.in_air:
            self.close()
