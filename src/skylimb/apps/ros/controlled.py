"""Our controller in place of the lab's: sensors in, thrusts and angles out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.lab_messages import floats
from skylimb.analysis.exchange.lab_topics import Topic, is_due
from skylimb.analysis.exchange.messages import Desire, Gains, PMatrix, ServoTargets, ServoTorques
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.lab_config import LabConfig
from skylimb.apps.ros.messages import Arrived, Outgoing, published
from skylimb.apps.ros.piloted import Piloted
from skylimb.apps.ros.sensors import Sensors
from skylimb.apps.ros.states import FlightState
from skylimb.apps.ros.tick import Received, Tick
from skylimb.base.rotations import rot_z, rpy_from_rotation
from skylimb.control.estimation.records import Measurement, Taken
from skylimb.control.loop.vehicle import measured_layout

CARRIES = 0.5
"""Share of its weight below which a robot lies on the ground: a forced landing ends with more, on the lab's
with 0.7."""


class Controlled(Piloted):
    """One tick of our controller for a robot that speaks the lab's topics.

    Args:
        flyer: who flies, and what.
        config: what the robot's own files say of its motors and servos.
    """

    def __init__(self, flyer: Flyer, config: LabConfig | None = None) -> None:
        self._config = config or LabConfig()
        self._sensors = Sensors(flyer.plan.robot, flyer.link, self._config.servos, flyer.names)
        super().__init__(flyer, measured_layout(flyer.plan.robot, self._sensors.has_imu))
        self._topics = flyer.dialect.topics("controller", self._config.servos is not None).published
        first = flyer.first
        self._vectoring = np.asarray(first.vectoring_angles, dtype=float)
        self._starting = False

    @property
    def faults(self) -> Counter[str]:
        """How often each fault was met."""
        return super().faults + self._sensors.counts

    def _sensed(self, arrived: Arrived) -> None:
        super()._sensed(arrived)
        self._sensors.take(arrived)

    def _enable(self, gimbals: bool, on: bool) -> Iterator[Outgoing]:
        servos, names = self._config.servos, self._names.gimbals if gimbals else self._names.joints
        if servos is not None:
            numbers = bytes(servos.counts(dict.fromkeys(names, 0.0)))
            yield Outgoing(topics.SERVO_TORQUE, ServoTorques(numbers, bytes([on] * len(numbers))))

    def _measured(self, now: float) -> tuple[Measurement | None, Taken]:
        return self._sensors.measurement(now, self._vectoring)

    def _lost(self, now: float) -> str:
        return self._sensors.lost(now)

    def _idles(self, received: Received) -> bool:
        pwms, motors, robot = received.pwms, self._config.motors, self._robot
        flies = CARRIES * robot.weight / robot.n_rotors
        return pwms is not None and motors is not None and motors.give_less(pwms.duties, flies)

    def _recorded(self, measured: Measurement, tick: Tick) -> np.ndarray:
        """Measurement and command, in the order of `measured_layout`."""
        return np.hstack([*measured.entries, *tick.command])

    def _messages(self, stamp: float, measured: Measurement | None, tick: Tick) -> Iterator[Outgoing]:
        self._vectoring = np.asarray(tick.command.vectoring_angles, dtype=float)
        yield from published(self._topics, tick.view(stamp, self._names, measured), self._k, self._period)
        starts, self._starting = not self._starting, tick.flying.state == FlightState.START
        at_once = (topics.UAV_INFO, topics.MOTOR_INFO) if starts else ()
        for topic, value in self._for_the_board(tick):
            if value is not None and (topic in at_once or is_due(topic, self._k, self._period)):
                yield Outgoing(topic, value)

    def _for_the_board(self, tick: Tick) -> Iterator[tuple[Topic, Any]]:
        """Targets of servos, and what the flight controller has to know."""
        servos, rotors = self._config.servos, self._robot.n_rotors
        if servos is not None:
            names = (*self._names.joints, *self._names.gimbals)
            counts = servos.counts(dict(zip(names, floats(np.concatenate(tick.command[1:])), strict=True)))
            yield topics.SERVO_TARGETS, ServoTargets(bytes(counts), tuple(counts.values()))
        # With zero gains the flight controller adds nothing to the thrusts.
        yield topics.GAINS, Gains(((0,) * 7,) * rotors)
        yield topics.P_MATRIX, PMatrix(((0, 0, 0),) * rotors, (0,) * 6)
        if tick.body is not None:
            # Its axes, by whose tilt it breaks off.
            board = rot_z(-tick.body.yaw_in_C) @ tick.body.R_WC.T @ tick.body.R_W_link
            yield topics.DESIRE, Desire(*floats(rpy_from_rotation(board)))
        if self._starting:
            yield topics.UAV_INFO, self._config.uav(self._robot)
            yield topics.MOTOR_INFO, self._config.motors
