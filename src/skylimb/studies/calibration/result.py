"""A calibration as data: `calibration.toml`, with a table for every parameter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
import tomli_w

from skylimb.analysis.recording.run import Run
from skylimb.analysis.recording.versions import versions
from skylimb.base.config import from_mapping
from skylimb.control.corrections import FORMAT, GAINS, Corrections
from skylimb.robots.description import GRAVITY
from skylimb.robots.model import Robot
from skylimb.studies.calibration.estimate import Estimate
from skylimb.studies.calibration.excited import motion_of
from skylimb.studies.calibration.parameters import centers, slices
from skylimb.studies.calibration.record import Record

SIGMAS = 1.959964
"""Half of a 95 % interval, in standard deviations."""

MASS_SPREAD = 0.02
"""What is believed of the mass, as a part of it: a flight does not show it."""

_TIGHT, _LOOSE = 0.9, 1.25
"""Residuals, over what the noise explains, between which the model is good."""


@dataclass(frozen=True)
class Calibration:
    """What a flight says of robot and sensors.

    Attributes:
        robot: the robot's name.
        digest: of its description.
        estimate: values, covariance, residuals.
        flight: what was flown: experiment, controller, seed, seconds, frames.
        moved: what moved in it, and how far, in words.
        truth: where the flight was simulated, the true value of every entry, (p,); else None.
        versions: what computed it.
    """

    robot: str
    digest: str
    estimate: Estimate
    flight: Mapping[str, Any]
    moved: str
    truth: np.ndarray | None = None
    versions: Mapping[str, str] = field(default_factory=versions)

    @property
    def interval(self) -> tuple[np.ndarray, np.ndarray]:
        """Ends of the 95 % interval of every entry, (p,) each."""
        half = SIGMAS * self.estimate.deviation
        return self.estimate.value - half, self.estimate.value + half

    @property
    def used(self) -> np.ndarray:
        """What a controller may use, (p,): what the flight does not show as it was believed before.

        The rest is the estimate that goes with that belief. So nothing is corrected by what was not shown,
        nor by what only goes with it.
        """
        estimate, shown = self.estimate, self.estimate.shown
        value = np.where(shown, estimate.value, centers(estimate.parameters))
        away = (value - estimate.value)[~shown]
        together = estimate.covariance[np.ix_(shown, ~shown)]
        value[shown] += together @ np.linalg.solve(estimate.covariance[np.ix_(~shown, ~shown)], away)
        return value

    @property
    def tables(self) -> dict[str, Any]:
        """Everything as plain tables, as the file has it."""
        found: dict[str, Any] = {
            "format": FORMAT,
            "robot": self.robot,
            "robot_digest": self.digest,
            "verdict": self.verdict,
            "flight": dict(self.flight),
        }
        low, high = self.interval
        used = self.used
        # A law's own belief of a lag is better than none.
        for name in GAINS:
            part = slices(self.estimate.parameters)[name]
            used[part] = np.where(self.estimate.shown[part], used[part], -1.0)
        for one in self.estimate.parameters:
            part = slices(self.estimate.parameters)[one.name]
            at = part.start if one.entries == ("",) else part  # a single number is no list
            found[one.name] = {
                "value": self.estimate.value[at].tolist(),
                "used": used[at].tolist(),
                "low": low[at].tolist(),
                "high": high[at].tolist(),
                "unit": one.unit,
                "shown": self.estimate.shown[at].tolist(),
                "meaning": one.meaning,
            }
        found["mass_scale"] = {
            "value": 1.0,
            "used": 1.0,
            "low": 1.0 - SIGMAS * MASS_SPREAD,
            "high": 1.0 + SIGMAS * MASS_SPREAD,
            "unit": "",
            "shown": False,
            "meaning": "true over described mass; no flight tells it from a common thrust scale",
        }
        found["versions"] = dict(self.versions)
        return found

    @property
    def corrections(self) -> Corrections:
        """What a controller uses of it, for `skylimb.run(..., calibration=)`."""
        tables = self.tables
        found = {one.name: tables[one.name] for one in fields(Corrections)}
        values = {name: one["used"] if isinstance(one, dict) else one for name, one in found.items()}
        return from_mapping(Corrections, values, f"the calibration of '{self.robot}'")

    @property
    def text(self) -> str:
        """The file's content."""
        return tomli_w.dumps(self.tables)

    @property
    def left(self) -> float:
        """Size of the residuals over what the noise explains; 1 for a model that explains everything."""
        return float(np.sqrt(np.mean(np.clip(self.estimate.after, -5.0, 5.0) ** 2)))

    @property
    def verdict(self) -> str:
        """What the flight shows and what it does not, in a sentence or two."""
        estimate = self.estimate
        hidden = [label for label, shown in zip(estimate.labels, estimate.shown, strict=True) if not shown]
        if not hidden:
            first = f"The flight shows all {len(estimate.labels)} numbers."
        else:
            first = (
                f"The flight shows {len(estimate.labels) - len(hidden)} of {len(estimate.labels)} numbers; "
                f"it does not show {', '.join(hidden)}, whose intervals stay near what was believed before."
            )
        if _TIGHT < self.left < _LOOSE and estimate.pushed:
            # Their level is fitted, so that the residuals look like noise whatever pushes.
            return (
                f"{first} What is left is the sensors' noise and pushes that nothing explains "
                f"({estimate.noise.push:.2g} m/s^2 and {estimate.noise.turn:.2g} m^2/s^2 over the root of a "
                "hertz). They are taken to be random: where they go with the motion, as air drag does, "
                "numbers may be off by more than their intervals say."
            )
        if _TIGHT < self.left < _LOOSE:
            return f"{first} What is left is the sensors' noise."
        return (
            f"{first} What is left is {self.left:.2g} times the noise: the model does not explain all of the "
            "flight, and the intervals may be too narrow."
        )

    def __repr__(self) -> str:
        return f"Calibration({self.robot!r}: {self.verdict})"


def calibration_of(run: Run, record: Record, estimate: Estimate) -> Calibration:
    """The calibration that a run's estimate makes; the truth beside it where the run was simulated."""
    attrs, robot = run.log.attrs, record.robot
    flight = {
        "experiment": str(attrs.get("experiment", "")),
        "controller": run.controller,
        "seed": int(attrs.get("seed", 0)),
        "seconds": round(record.duration, 3),
        "seconds_unfollowed": round(record.unfollowed, 3),
        "frames": len(estimate.times),
        "frames_left_out": estimate.left_out,
    }
    truth = true_values(run, robot)
    return Calibration(robot.name, robot.description.digest, estimate, flight, motion_of(record), truth)


def true_values(run: Run, robot: Robot) -> np.ndarray | None:
    """What a simulated flight was flown with, in the order of the flat vector; None for a real one."""
    config = run.tables
    plant, sensors = config.get("plant"), config.get("sensors")
    if plant is None or sensors is None:
        return None
    # Runs of before gravity was a key were flown with the engine's own.
    gravity = float(config.get("gravity", GRAVITY))
    lag = float(plant.get("rotor_lag", -1.0))
    described = float(np.mean([rotor.lag for rotor in robot.description.rotors]))
    scale = np.asarray(plant.get("rotor_scale") or np.ones(robot.n_rotors), dtype=float)
    scale = scale * float(plant.get("thrust_scale", 1.0)) / float(plant.get("mass_scale", 1.0))
    return np.concatenate(
        [
            np.asarray(sensors.get("attitude_misalignment", np.zeros(3)), dtype=float),
            np.asarray(plant.get("cog_offset", np.zeros(3)), dtype=float),
            scale,
            [described if lag < 0.0 else lag, float(sensors.get("latency", 0.0)), 0.0, 0.0, gravity],
        ]
    )
