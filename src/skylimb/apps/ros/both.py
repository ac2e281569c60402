"""Plant and controller behind the lab's user-level topics: a robot for a laptop."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from skylimb.analysis.exchange.body import Bodies
from skylimb.analysis.exchange.frames import felt_by
from skylimb.analysis.exchange.lab_topics import IMU, JOINT_STATES, MOCAP
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.grounded import GroundedPlant
from skylimb.apps.ros.messages import Arrived, Outgoing, published
from skylimb.apps.ros.piloted import Piloted
from skylimb.apps.ros.profile import PendingRun
from skylimb.apps.ros.tick import Received, Tick
from skylimb.control.estimation.records import Measurement, Taken
from skylimb.control.loop.flight import unfinished
from skylimb.flight.realtime.pacer import stepped
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import Takeoff

_SENSED = frozenset(topic.name for topic in (MOCAP, IMU, JOINT_STATES))
"""Topics that show what the plant is like, also where nobody has seen it."""


class Both(Piloted):
    """One tick of plant and controller, in step: time goes on by a period a tick, however long it took.

    So a computer that is busy is slow, and no flight is lost to it. The topic `/clock` tells that time.

    Args:
        takeoff: gives the plant.
        flyer: who flies it; its pacer is not looked at.
    """

    def __init__(self, takeoff: Takeoff, flyer: Flyer) -> None:
        self.plant = GroundedPlant(takeoff)
        flyer = replace(flyer, pacer=stepped(flyer.period), needs_battery=False)
        super().__init__(flyer, self.plant.layout)
        self._pacer.start()
        self.caught_up = 1
        self._begun: float | None = None
        self._torque = np.ones(flyer.robot.n_joints + flyer.robot.n_vectoring)
        self._takeoff, self._missions = takeoff, flyer.missions
        self._bodies = Bodies(takeoff.robot, flyer.link)
        self._link = flyer.link
        offered = flyer.dialect.topics("both", False).published
        self._sensed_topics = [topic for topic in offered if topic.name in _SENSED]
        self._others = [topic for topic in offered if topic.name not in _SENSED]

    @property
    def over(self) -> str:
        """Why it cannot go on; empty while it can."""
        return self.plant.over

    def tick(self, arrived: Iterable[Arrived], stamp: float) -> list[Outgoing]:
        """One tick; only that of the first one counts of the stamps."""
        self._begun = stamp if self._begun is None else self._begun
        self._pacer.wait(self._k)
        heard = [one._replace(at=self._pacer.time()) for one in arrived]
        return super().tick(heard, self._begun + self._pacer.time())

    def _enable(self, gimbals: bool, on: bool) -> Iterator[Outgoing]:
        n = self._robot.n_joints
        self._torque[slice(n, None) if gimbals else slice(n)] = on
        self.plant.enable(self._torque)
        yield from ()

    def _measured(self, now: float) -> tuple[Measurement, Taken]:
        return self.plant.measure(), Taken(now, now)

    def _acknowledged(self, received: Received) -> int | None:
        """What was commanded: a simulated flight controller obeys at once."""
        arming = self.pilot.flying.arming
        return None if arming is None else int(arming)

    def _recorded(self, measured: Measurement, tick: Tick) -> np.ndarray:
        return self.plant.record(measured, tick.command)

    def _messages(self, stamp: float, measured: Measurement | None, tick: Tick) -> Iterator[Outgoing]:
        assert measured is not None
        view = tick.view(stamp, self._names, measured)
        felt = felt_by(self._robot, self._link, measured.imu)
        sensed = replace(view, body=tick.body or self._bodies.of(measured), felt=felt)
        yield from published(self._sensed_topics, sensed, self._k, self._period)
        yield from published(self._others, view, self._k, self._period)

    def _apply(self, tick: Tick) -> None:
        """A tick of physics; a mission that is over is kept, with its scores."""
        self.plant.apply(tick.driven)
        flown = self._live.mission_flown(tick)
        if flown is not None:
            name, flight = flown
            mission = self._missions[name]
            run = lambda: scored_run(self._takeoff, unfinished(mission, flight()), mission)  # noqa: E731
            self.kept.append(PendingRun(name, run))
