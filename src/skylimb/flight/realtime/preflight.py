"""What is looked at before the motors turn: each thing by its name, what was found, and what is allowed.

A pure function of what is known, the same for a robot on ROS and one behind a link. A flight is refused for
whatever fails here; with `--check` one looks for some seconds, says all of it, and commands nothing.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.base.errors import ConfigError
from skylimb.control.calibration_date import age_of
from skylimb.flight.realtime.beginning import Beginning
from skylimb.flight.realtime.resting_imu import ImuOff
from skylimb.robots.model import Robot

LOOK = 3.0
"""Seconds for which one listens before a flight, or that only looks."""


@dataclass(frozen=True)
class StartLimits:
    """With what a flight begins; numbers are ours where no comment says that they are the lab's.

    Attributes:
        start_tilt: greatest tilt, rad.
        start_speed: greatest speed, m/s.
        start_force: of an IMU's specific force from gravity's, m/s^2: rotors that idle may be felt by 2, a
            wrong sign, unit or axis by 8.8 and more.
        start_turning: of its rates from the robot's, rad/s.
        start_age: of a sensor's newest message, s.
        start_offset: of a sensor's clock from ours, s.
        start_rate: of the motion capture, Hz: at 12 a robot took off and was lost, at 25 it flies as at 100.
        low_battery: least charge, per cent; the lab's. Below it for some seconds (`charge`) it also lands.
        fence: x, y and z between which the centre of gravity has to stay, W, m.
        disk: free space, bytes.
        calibrated: age of the calibration, days.
        start_place: way to where a mission begins that nobody leads to, m.
        start_heading: turn there, rad.
        start_joints: of a shape joint there, rad.
        mass: by how much a robot may weigh more or less than its file's, part of it.
    """

    start_tilt: float = 0.2
    start_speed: float = 0.5
    start_force: float = 3.0
    start_turning: float = 0.1
    start_age: float = 0.2
    start_offset: float = 0.1
    start_rate: float = 18.0
    low_battery: float = 10.0
    fence: tuple[tuple[float, float], ...] = ((-20.0, 20.0), (-20.0, 20.0), (-2.0, 10.0))
    disk: float = 1e9
    calibrated: float = 30.0
    start_place: float = 0.1
    start_heading: float = 0.3
    start_joints: float = 0.1
    mass: float = 0.02

    @property
    def fence_words(self) -> str:
        """The fence for people."""
        return ", ".join(
            f"{low:g} < {axis} < {high:g} m" for axis, (low, high) in zip("xyz", self.fence, strict=True)
        )

    def outside(self, position: np.ndarray) -> str:
        """How a place, W, m, (3,), lies outside of the fence; empty where it does not."""
        for axis, value, (low, high) in zip("xyz", position, self.fence, strict=True):
            if not low <= value <= high:
                return f"{axis} = {value:.2f} m is outside of {low:g} .. {high:g} m"
        return ""


def fence_of(bounds: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """The fence of six numbers: least and greatest x, y and z.

    Raises:
        ConfigError: where they are not six, or do not rise.
    """
    pairs = tuple(zip(bounds[::2], bounds[1::2], strict=False))
    if len(bounds) != 6 or not all(low < high for low, high in pairs):
        told = " ".join(["--fence", *(f"{bound:g}" for bound in bounds)])
        raise ConfigError(f"{told}: wanted are least and greatest x, y and z, rising")
    return pairs


class Check(NamedTuple):
    """One thing that was looked at: its name, what was found, what is allowed, and whether that holds."""

    name: str
    found: str
    allowed: str
    fine: bool

    def __str__(self) -> str:
        return f"{self.name}: {self.found} ({self.allowed})"

    @property
    def line(self) -> str:
        """The same, and whether it holds, for people."""
        return f"{'ok' if self.fine else 'NO'}  {self}"


@dataclass(frozen=True)
class PreflightFacts:
    """What is known before anything is measured, and does not change on the ground.

    Attributes:
        masses: of the robot as it is described elsewhere, and of its file, kg; None where it is not.
        calibrated: age of the calibration, days; None without one, NaN where its file does not say.
        free: bytes that the disk has left.
        unprotected: rotors whose loss is not protected, in words; empty where nobody asked.
    """

    masses: tuple[float, float] | None = None
    calibrated: float | None = None
    free: float = np.inf
    unprotected: str = ""


def preflight_facts(
    robot: Robot, mass: float | None, calibration: str | None, unprotected: str
) -> PreflightFacts:
    """What can be looked at before anything is measured.

    Args:
        robot: of the file.
        mass: as whoever has the robot describes it, kg.
        calibration: its file.
        unprotected: rotors whose loss is not protected, in words.
    """
    age = None if calibration is None else age_of(calibration)
    masses = None if mass is None else (mass, float(robot.mass))
    return PreflightFacts(masses, age, float(shutil.disk_usage(Path.cwd()).free), unprotected)


@dataclass(frozen=True)
class Measured:
    """What is known of robot and sensors.

    Attributes:
        body: as measured; None where nothing fresh is.
        ages: of the newest message of each sensor, s.
        offsets: of the sensors' clocks from ours, s.
        battery: charge, per cent; None where nobody has to say, NaN where who has to did not.
        foreign: who else commands it, "node on topic"; None where that cannot be known.
        imu: how far off it is; None where nobody has one.
        rates: of a sensor's messages, Hz; NaN before the second one.
        unknown: why there is no body, where that is known.
        beginning: how far the mission's is; None where the robot is led there.
    """

    body: Body | None
    ages: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)
    battery: float | None = None
    foreign: tuple[str, ...] | None = ()
    imu: ImuOff | None = None
    beginning: Beginning | None = None
    rates: Mapping[str, float] = field(default_factory=dict)
    unknown: str = ""


def checks(facts: PreflightFacts, measured: Measured, limits: StartLimits) -> Iterator[Check]:
    """All that is looked at, one after another."""
    body = measured.body
    if body is None:
        found = ": ".join(filter(None, ("not known", measured.unknown)))
        yield Check("position", found, "a fresh pose, gyro and joint angles", False)
    else:
        yield _below("attitude", body.tilt, limits.start_tilt, "rad of tilt")
        yield _below("motion", float(np.linalg.norm(body.velocity)), limits.start_speed, "m/s")
        outside = limits.outside(body.cog)
        yield Check("fence", outside or "inside", limits.fence_words, not outside)
    if measured.beginning is not None:
        yield from _at_its_beginning(measured.beginning, limits)
    if measured.imu is not None:
        yield _below("IMU's force", measured.imu.force, limits.start_force, "m/s^2 beside gravity")
        yield _below("IMU's turning", measured.imu.turning, limits.start_turning, "rad/s beside the robot's")
    for name, age in measured.ages.items():
        yield _below(f"age of {name}", age, limits.start_age, "s")
    for name, offset in measured.offsets.items():
        yield _below(f"clock of {name}", abs(offset), limits.start_offset, "s beside ours")
    for name, rate in measured.rates.items():
        found, least = "not known" if np.isnan(rate) else f"{rate:.3g} Hz", limits.start_rate
        yield Check(f"rate of {name}", found, f"at least {least:g}", rate >= least)
    if measured.battery is not None:
        enough = measured.battery >= limits.low_battery
        charge = "not known" if np.isnan(measured.battery) else f"{measured.battery:.0f} %"
        yield Check("battery", charge, f"at least {limits.low_battery:g} %", enough)
    if measured.foreign is not None:
        foreign = ", ".join(measured.foreign)
        yield Check("publishers of commands", foreign or "only this node", "nobody else", not foreign)
    yield Check(
        "disk",
        f"{facts.free / 1e9:.1f} GB free",
        f"at least {limits.disk / 1e9:g} GB",
        facts.free >= limits.disk,
    )
    if facts.calibrated is not None:
        days, most = facts.calibrated, limits.calibrated
        found = "not known: its file does not say when it was made" if np.isnan(days) else f"{days:.3g} days"
        yield Check("age of the calibration", found, f"0 to {most:g}", 0.0 <= days <= most)
    if facts.unprotected:
        # It is said and not refused: what a robot cannot outlive is its pilot's to know.
        yield Check("rotors whose loss is not protected", facts.unprotected, "to be known", True)
    if facts.masses is not None:
        told, own = facts.masses
        found = f"{told:.3f} kg as described, {own:.3f} kg in its file"
        yield Check("robot", found, f"within {100.0 * limits.mass:g} %", abs(told / own - 1.0) <= limits.mass)


def _at_its_beginning(begins: Beginning, limits: StartLimits) -> Iterator[Check]:
    """Whether the robot is where its mission begins, and what to do where it is not."""
    for name, way, most, unit, there in (
        ("place", begins.place, limits.start_place, "m", _numbers(begins.at)),
        ("heading", begins.heading, limits.start_heading, "rad", f"yaw {begins.yaw:.2f}"),
        ("joints", begins.joints, limits.start_joints, "rad", _numbers(begins.angles)),
    ):
        found, allowed = f"{way:.3g} {unit} from the mission's beginning", f"at most {most:g}"
        fine = way <= most
        yield Check(name, found, allowed if fine else f"{allowed}; lead it to {there} {unit} first", fine)


def _numbers(values: np.ndarray) -> str:
    return f"({', '.join(f'{value:.2f}' for value in values)})"


def _below(name: str, value: float, most: float, unit: str) -> Check:
    """A number that must not be above another one; NaN is."""
    return Check(name, f"{value:.3g} {unit}", f"at most {most:g}", value <= most)
