"""Our controller in place of the lab's: sensors in, thrusts and angles out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.lab_messages import floats
from skylimb.analysis.exchange.lab_topics import Topic, is_due
from skylimb.analysis.exchange.messages import Desire, Gains, PMatrix, ServoTargets, ServoTorques
from skylimb.apps.ros.flyer import Flyer
from skylimb.apps.ros.holding import added, gains_of, no_gains
from skylimb.apps.ros.lab_config import LabConfig
from skylimb.apps.ros.messages import Arrived, Outgoing, published
from skylimb.apps.ros.piloted import Piloted
from skylimb.apps.ros.sensors import Sensors
from skylimb.apps.ros.states import FlightState
from skylimb.apps.ros.tick import Received, Tick
from skylimb.base.errors import AllocationError
from skylimb.base.packing import flattened
from skylimb.base.rotations import rot_z, rpy_from_rotation
from skylimb.control.estimation.records import Measurement, Taken
from skylimb.control.loop.vehicle import measured_layout


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
        self._volts: float | None = None
        # What the flight controller was sent of its own attitude loop.
        self._nothing = self._gains = no_gains(flyer.robot.n_rotors)
        self._axes = Desire(0.0, 0.0, 0.0)

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

    def _missing(self) -> tuple[str, ...]:
        return self._sensors.missing

    def _lost(self, now: float) -> str:
        return self._sensors.lost(now)

    def _carried(self, received: Received) -> float:
        self._volts = self._volts if received.volts is None else received.volts
        pwms, motors = received.pwms, self._config.motors
        if pwms is None or motors is None:
            return np.inf
        return motors.most(pwms.duties, self._volts) / self._robot.weight

    def _recorded(self, measured: Measurement, tick: Tick) -> np.ndarray:
        """Measurement and command, in the order of `measured_layout`."""
        return flattened((*measured.entries, *tick.command))

    def _messages(self, stamp: float, measured: Measurement | None, tick: Tick) -> Iterator[Outgoing]:
        self._vectoring = np.asarray(tick.command.vectoring_angles, dtype=float)
        view = tick.view(stamp, self._names, measured)
        yield from map(self._told, published(self._topics, view, self._k, self._period))
        starts, self._starting = not self._starting, tick.flying.state == FlightState.START
        at_once = (topics.UAV_INFO, topics.MOTOR_INFO) if starts else ()
        for topic, value in self._for_the_board(tick):
            # Motors that are stopped are not to be turned by gains.
            urgent = topic in at_once or (topic is topics.GAINS and value == self._nothing != self._gains)
            if value is not None and (urgent or is_due(topic, self._k, self._period)):
                self._gains = value if isinstance(value, Gains) else self._gains
                self._axes = value if isinstance(value, Desire) else self._axes
                yield Outgoing(topic, value)

    def _told(self, one: Outgoing) -> Outgoing:
        """A message; thrusts without what the flight controller adds to them by the gains that it has."""
        imu = self._sensors.imu
        if one.topic is not topics.FOUR_AXES or imu is None or self._gains == self._nothing:
            return one
        thrusts = np.array(one.value.base_thrust) - added(self._gains, self._axes, imu)
        return one._replace(value=replace(one.value, base_thrust=floats(thrusts)))

    def _held(self, tick: Tick) -> Gains:
        """The gains for now: none before a controller flies, and where the board's own IMU is not heard."""
        flies = tick.motors and tick.reference is not None and topics.GAINS in self._topics
        if not (flies and self._sensors.feels(self._pacer.time())):
            return self._nothing
        if tick.body is None or not is_due(topics.GAINS, self._k, self._period):
            return self._gains
        try:
            state = self._robot.at(*tick.command[1:])
        except AllocationError:  # nobody hovers with such angles: those of before stay
            return self._gains
        return gains_of(state, tick.body.yaw_in_C)

    def _for_the_board(self, tick: Tick) -> Iterator[tuple[Topic, Any]]:
        """Targets of servos, and what the flight controller has to know."""
        servos, rotors = self._config.servos, self._robot.n_rotors
        if servos is not None:
            names = (*self._names.joints, *self._names.gimbals)
            counts = servos.counts(dict(zip(names, floats(np.concatenate(tick.command[1:])), strict=True)))
            yield topics.SERVO_TARGETS, ServoTargets(bytes(counts), tuple(counts.values()))
        yield topics.GAINS, self._held(tick)
        yield topics.P_MATRIX, PMatrix(((0, 0, 0),) * rotors, (0,) * 6)
        if tick.body is not None:
            # Its axes, by whose tilt it breaks off.
            board = rot_z(-tick.body.yaw_in_C) @ tick.body.R_WC.T @ tick.body.R_W_link
            yield topics.DESIRE, Desire(*floats(rpy_from_rotation(board)))
        if self._starting:
            yield topics.UAV_INFO, self._config.uav(self._robot)
            yield topics.MOTOR_INFO, self._config.motors
