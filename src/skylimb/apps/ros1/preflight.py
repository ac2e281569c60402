"""What is looked at before the motors turn: each thing by its name, what was found, and what is allowed.

A pure function of what is known. `start` is refused for whatever fails here, and `takeoff` again; with
`skylimb ros controller --check` a node looks for some seconds, says all of it, and commands nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from skylimb.analysis.exchange.body import Body
from skylimb.apps.ros1.limits import FlightLimits


class Check(NamedTuple):
    """One thing that was looked at: its name, what was found, what is allowed, and whether that holds."""

    name: str
    found: str
    allowed: str
    fine: bool

    def __str__(self) -> str:
        return f"{self.name}: {self.found} ({self.allowed})"


@dataclass(frozen=True)
class Desk:
    """What is known before anything is measured, and does not change on the ground.

    Attributes:
        masses: of the robot as ROS's parameters describe it, and of its file, kg; None where they do not.
        calibrated: age of the calibration, days; None without one.
        free: bytes that the disk has left.
    """

    masses: tuple[float, float] | None = None
    calibrated: float | None = None
    free: float = np.inf


@dataclass(frozen=True)
class Measured:
    """What is known of robot and sensors.

    Attributes:
        body: as measured; None where nothing fresh is.
        ages: of the newest message of each sensor, s.
        offsets: of the sensors' clocks from ours, s.
        battery: charge, per cent; None where nobody says.
        foreign: who else publishes on a command's topic, "node on topic".
    """

    body: Body | None
    ages: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)
    battery: float | None = None
    foreign: tuple[str, ...] = ()


def checks(desk: Desk, measured: Measured, limits: FlightLimits) -> Iterator[Check]:
    """All that is looked at, one after another."""
    body = measured.body
    if body is None:
        yield Check("position", "not known", "a fresh pose, gyro and joint angles", False)
    else:
        yield _below("attitude", body.tilt, limits.start_tilt, "rad of tilt")
        yield _below("motion", float(np.linalg.norm(body.velocity)), limits.start_speed, "m/s")
        outside = limits.outside(body.cog)
        yield Check("fence", outside or "inside", limits.fence_words, not outside)
    for name, age in measured.ages.items():
        yield _below(f"age of {name}", age, limits.start_age, "s")
    for name, offset in measured.offsets.items():
        yield _below(f"clock of {name}", abs(offset), limits.start_offset, "s beside ours")
    if measured.battery is not None:
        enough = measured.battery >= limits.low_battery
        yield Check("battery", f"{measured.battery:.0f} %", f"at least {limits.low_battery:g} %", enough)
    foreign = ", ".join(measured.foreign)
    yield Check("publishers of commands", foreign or "only this node", "nobody else", not foreign)
    yield Check(
        "disk",
        f"{desk.free / 1e9:.1f} GB free",
        f"at least {limits.disk / 1e9:g} GB",
        desk.free >= limits.disk,
    )
    if desk.calibrated is not None:
        yield _below("age of the calibration", desk.calibrated, limits.calibrated, "days")
    if desk.masses is not None:
        told, own = desk.masses
        found = f"{told:.3f} kg on ROS, {own:.3f} kg in its file"
        yield Check("robot", found, f"within {100.0 * limits.mass:g} %", abs(told / own - 1.0) <= limits.mass)


def _below(name: str, value: float, most: float, unit: str) -> Check:
    """A number that must not be above another one; NaN is."""
    return Check(name, f"{value:.3g} {unit}", f"at most {most:g}", value <= most)
