"""All that is known of a simulated flight before take-off besides its events: references and sensor noise."""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from skylimb.base.packing import Layout, pack_rows
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.missions.table import Window, reference_table
from skylimb.robots.model import Robot
from skylimb.simulation.sensors import (
    SensorConfig,
    SensorFailure,
    SensorNoise,
    draw_noise,
    frame_ages,
    no_failure,
)


class TickRow(NamedTuple):
    """What is known of a tick before the flight, whatever the mission asks at it.

    Attributes:
        age: of the motion capture's frame, s.
        failure: of the sensors.
        late: 1 where the controller comes too late, and a supervisor commands in its place.
        held: 1 where it comes too late and nobody commands: rotors and servos stay as they are.
        imu_age: of what the IMU says, s.
        noise: errors of the sensors.
        thrust_scales: thrust that acts over what the lag of each rotor gives, (n,).
    """

    age: Any
    failure: SensorFailure
    late: Any
    held: Any
    imu_age: Any
    noise: SensorNoise
    thrust_scales: Any


def row_layout(robot: Robot) -> Layout[TickRow]:
    """Layout of a `TickRow` for this robot."""
    z3, nq, nv = np.zeros(3), robot.n_joints, robot.n_vectoring
    noise = SensorNoise(z3, z3, z3, z3, np.zeros(nq), np.zeros(nv))
    return Layout(TickRow(0.0, no_failure(nq + nv), 0.0, 0.0, 0.0, noise, np.ones(robot.n_rotors)))


@functools.lru_cache(maxsize=16)
def reference_layout(robot: Robot) -> Layout[Reference]:
    """Layout of one row of the mission's references for this robot."""
    return Layout(zero_reference(robot.n_joints, robot.n_vectoring))


@dataclass(frozen=True)
class FlightRows:
    """What is known of a flight before it begins.

    Attributes:
        ticks: one packed `TickRow` for every tick that the flight may have.
        references: packed `Reference` rows of the mission, and copies of the last one.
        last: the mission's last tick.
    """

    ticks: np.ndarray
    references: np.ndarray
    last: int

    def __len__(self) -> int:
        return len(self.ticks)

    def with_added(self, added: np.ndarray) -> FlightRows:
        """The rows of a flight with something added to what is known of its ticks."""
        return dataclasses.replace(self, ticks=self.ticks + added)

    def until(self, count: int) -> FlightRows:
        """The rows of a flight that has `count` ticks at most; its references are the whole mission's."""
        return self if count >= len(self) else dataclasses.replace(self, ticks=self.ticks[:count])


def flight_rows(
    robot: Robot,
    mission: Mission,
    sensors: SensorConfig,
    seed: int,
    window: Window,
    thrust_scales: np.ndarray,
) -> FlightRows:
    """Ages of the frames, noise drawn from `seed`, scales of thrusts, and references.

    Args:
        robot: what is flown.
        mission: the references of the flight.
        sensors: rate, latency and noise.
        seed: of the noise.
        window: rows of the mission that a tick reads.
        thrust_scales: of every rotor at every tick, (k, n), or (1, n) where they stay.
    """
    times = mission.flight_times(window.paced)
    rng = np.random.default_rng(seed)
    noise = draw_noise(sensors, times, robot.n_joints, robot.n_vectoring, rng)
    none, works = np.zeros(len(times)), no_failure(robot.n_joints + robot.n_vectoring)
    failure = SensorFailure(*(np.zeros((len(times), *np.shape(each))) for each in works))
    imu_ages = np.full(len(times), sensors.imu.latency)
    scales = np.broadcast_to(thrust_scales, (len(times), robot.n_rotors))
    known = TickRow(frame_ages(sensors, times), failure, none, none, imu_ages, noise, scales)
    ticks = pack_rows(row_layout(robot), known, len(times))
    return FlightRows(
        ticks, reference_table(mission, reference_layout(robot), window), len(mission.times) - 1
    )
