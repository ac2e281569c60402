"""A robot behind a link is looked at: before it is flown, and in flight whether it leaves its fence."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skylimb.analysis.exchange.body import Bodies
from skylimb.base.errors import OutputError
from skylimb.control.corrections import Calibrated
from skylimb.control.estimation.records import Imu, Measurement
from skylimb.control.loop.vehicle import MEASURED, nothing_measured
from skylimb.control.missions.reference import Reference
from skylimb.flight.drivers.free import FreeDriver
from skylimb.flight.realtime.beginning import beginning_of
from skylimb.flight.realtime.charge import Charge
from skylimb.flight.realtime.link import RemoteVehicle
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.preflight import Check, StartLimits, checks, preflight_facts
from skylimb.flight.realtime.resting_imu import RestingImu
from skylimb.robots.model import Robot

NOTHING = "nothing was heard: it is not there, or another controller flies it"
"""Why no measurement came, where nothing at all did."""


class Look:
    """What is looked at.

    Args:
        robot: of the file.
        vehicle: the robot itself.
        clock: of the flight.
        first: row of the mission.
        limits: of a start, and the fence.
        calibration: that it flies with.
        patience: how long the first measurement is waited for, s.
        unprotected: rotors whose loss is not protected, in words.
    """

    def __init__(
        self,
        robot: Robot,
        vehicle: RemoteVehicle,
        clock: Pacer,
        first: Reference,
        limits: StartLimits,
        calibration: Calibrated | None,
        patience: float,
        unprotected: str,
    ) -> None:
        self._robot, self._vehicle, self._clock, self._limits = robot, vehicle, clock, limits
        self._first, self._charge = first, Charge()
        self._calibration = calibration if isinstance(calibration, str) else None
        self._unprotected = unprotected
        self._patience, self._bodies = patience, Bodies(robot, robot.description.imu.link)
        self._imu, self._mount = RestingImu(robot.description.gravity), robot.description.imu.R

    def found(self, seconds: float) -> list[Check]:
        """What is found once measurements have come for some seconds.

        Raises:
            OutputError: when none comes.
        """
        vehicle, begun = self._vehicle, time.monotonic()
        heard_at, measured = begun, nothing_measured(self._robot)
        self._clock.start()
        while vehicle.heard is None or time.monotonic() < heard_at + seconds:
            if vehicle.heard is None:
                heard_at = time.monotonic()
            vehicle.greet()
            measured = vehicle.measure()
            self._feel(measured)
            if vehicle.heard is None and heard_at > begun + self._patience:
                heard = ", ".join(f"{what} {count} times" for what, count in vehicle.counts.items())
                raise OutputError(f"no measurement came within {self._patience:g} s ({heard or NOTHING})")
            time.sleep(self._clock.period)
        facts = preflight_facts(self._robot, vehicle.heard.mass, self._calibration, self._unprotected)
        known = vehicle.known(self._bodies.of, self._imu.off)
        if known.body is not None:
            known = replace(known, beginning=beginning_of(self._robot, self._first, known.body, measured))
        return [*checks(facts, known, self._limits)]

    def _feel(self, measured: Measurement) -> None:
        """Hold what an IMU says against the pose beside which it came."""
        state = self._vehicle.heard
        if state is None or state.imu_angular_velocity is None or state.imu_specific_force is None:
            return
        if np.isfinite(np.hstack(measured[:6])).all():
            body, mount = self._bodies.of(measured), self._mount
            felt = Imu(np.array(state.imu_angular_velocity), np.array(state.imu_specific_force))
            self._imu.take(body.R_W_link @ mount, mount.T @ body.rates_link, felt)

    def left(self, seen: Sequence[np.ndarray]) -> str:
        """Why a flight has to be broken off, of fence and battery; empty while it has not."""
        state = self._vehicle.heard
        if state is not None and state.battery is not None:
            least, now = self._limits.low_battery, self._clock.clock()
            self._charge = self._charge.after(state.battery, least, now)
            if self._charge.low:
                return f"low battery: {state.battery:.0f} per cent"
        return self.outside(seen)

    def outside(self, seen: Sequence[np.ndarray]) -> str:
        """How it was beyond the fence, measured so (see `place`); empty where it was not, or nobody knows."""
        place = self.place(seen)
        outside = "" if place is None else self._limits.outside(place)
        return outside and f"beyond the fence: {outside}"

    def place(self, seen: Sequence[np.ndarray]) -> np.ndarray | None:
        """Its centre of gravity, W, m, (3,); None where it was not measured.

        Args:
            seen: the first six entries of a measurement.
        """
        return self._bodies.of(seen).cog if np.isfinite(np.hstack(seen)).all() else None


def measured_at(driver: FreeDriver, k: int) -> list[np.ndarray]:
    """The first six entries of what was measured at tick `k`."""
    row, places = driver.log[k], driver.layout.slices
    return [row[places[name]] for name in MEASURED[:6]]
