"""Our controller in place of the lab's: sensors in, thrusts and angles out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from skylimb.apps.ros1 import topics
from skylimb.apps.ros1.desk import Arrived, Desk
from skylimb.apps.ros1.lab_config import LabConfig
from skylimb.apps.ros1.limits import FlightLimits
from skylimb.apps.ros1.live import Kept, LiveRecord, measured_row
from skylimb.apps.ros1.messages import Desire, Gains, Joints, PMatrix
from skylimb.apps.ros1.outputs import Names, Outgoing, Rates, commanded, lab_cog, seen_by_anybody
from skylimb.apps.ros1.pilot import Pilot
from skylimb.apps.ros1.senses import Senses
from skylimb.apps.ros1.states import FlightState
from skylimb.apps.ros1.tick import Inputs, Tick
from skylimb.base.rotations import rpy_from_rotation
from skylimb.control.loop.vehicle import measured_layout
from skylimb.control.missions.mission import Mission
from skylimb.flight.plan import FlightPlan
from skylimb.flight.realtime.pacer import Pacer


class Controlled:
    """One tick of our controller for a robot that speaks the lab's topics.

    Args:
        plan: robot, controller and the first mission.
        controller: the same, compiled where it can be.
        missions: by name.
        link: whose pose is on the lab's topics.
        pacer: of the ticks.
        cells: of the battery.
        limits: of the flight states.
        config: what the robot's own files say of its motors and servos.
        namespace: of the lab's frames.
    """

    def __init__(
        self,
        plan: FlightPlan,
        controller: Any,
        missions: Mapping[str, Mission],
        link: str,
        pacer: Pacer,
        cells: int = 6,
        limits: FlightLimits | None = None,
        config: LabConfig | None = None,
        namespace: str = topics.NAMESPACE,
    ) -> None:
        robot, period = plan.robot, plan.period
        self.pilot = Pilot(robot, controller, missions, link, pacer, period, limits)
        self._config = config or LabConfig()
        self._senses = Senses(robot, link, self._config.servos)
        self._desk, self._pacer = Desk(cells, self._senses.take), pacer
        self._names, self._rates = Names(robot, namespace), Rates(period)
        sample = self.pilot.rehearsed()
        layout = measured_layout(robot)
        self._live = LiveRecord(plan, layout, sample)
        first = next(iter(missions.values())).first
        self._vectoring = np.asarray(first.vectoring_angles, dtype=float)
        self._k, self._robot, self._starting = 0, robot, False
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
            *seen_by_anybody(k, stamp, tick, self._names, self._rates),
            *self._in_counts(commanded(k, stamp, tick, self._names, self._rates), k, tick),
            *self._moved(k, stamp, tick),
            *self._told(k, tick),
        ]
        if measured is not None:
            if self._config.servos is not None and self._rates.due(topics.JOINT_STATES, k):
                out.append(Outgoing(topics.JOINT_STATES, self._names.joint_states(stamp, measured)))
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

    def _in_counts(self, messages: Iterable[Outgoing], k: int, tick: Tick) -> Iterator[Outgoing]:
        """Commands, those of angles to the servos where we speak with them."""
        servos, command = self._config.servos, tick.command
        for one in messages:
            if servos is None or one.topic != topics.GIMBALS_CTRL:
                yield one
        if servos is not None and self._rates.due(topics.SERVO_TARGETS, k):
            names = (*self._names.joints, *self._names.gimbals)
            angles = np.concatenate([command.joint_angles, command.vectoring_angles])
            wanted = Joints(0.0, names, tuple(np.asarray(angles, dtype=float).tolist()))
            yield Outgoing(topics.SERVO_TARGETS, servos.counts(wanted))

    def _moved(self, k: int, stamp: float, tick: Tick) -> Iterator[Outgoing]:
        """Joints, and zero gains: the flight controller adds nothing to the thrusts."""
        rotors = self._robot.n_rotors
        if self._config.servos is None and self._rates.due(topics.JOINTS_CTRL, k):
            angles = tuple(np.asarray(tick.command.joint_angles, dtype=float).tolist())
            yield Outgoing(topics.JOINTS_CTRL, Joints(stamp, self._names.joints, angles))
        if self._rates.due(topics.GAINS, k):
            yield Outgoing(topics.GAINS, Gains(((0,) * 7,) * rotors))
        if self._rates.due(topics.P_MATRIX, k):
            yield Outgoing(topics.P_MATRIX, PMatrix(((0, 0, 0),) * rotors, (0,) * 6))

    def _told(self, k: int, tick: Tick) -> Iterator[Outgoing]:
        """What the flight controller has to know: its axes, by whose tilt it breaks off, and its motors."""
        if tick.body is not None and self._rates.due(topics.DESIRE, k):
            board = lab_cog(tick.body).T @ tick.body.R_W_link
            roll, pitch, yaw = np.asarray(rpy_from_rotation(board), dtype=float).tolist()
            yield Outgoing(topics.DESIRE, Desire(roll, pitch, yaw))
        motors = self._config.motors
        starts, self._starting = not self._starting, tick.flying.state == FlightState.START
        if not self._starting or not (starts or self._rates.due(topics.MOTOR_INFO, k)):
            return
        yield Outgoing(topics.UAV_INFO, self._config.uav(self._robot))
        if motors is not None:
            yield Outgoing(topics.MOTOR_INFO, motors)
