"""Choose the manoeuvre of the experiment `calibration` by what it shows, and write it into its file.

    python benchmarks/calibration_manoeuvre.py [--tries 60] [--write]

A manoeuvre's worth is the smallest eigenvalue of its Fisher information, in units of the wanted accuracy. The
information comes from the exact derivatives of the prediction along a simulated flight of the described
robot, so joints, servos, controller and noise are all in it. A search of mutations keeps what is worth more
and stays within the limits: room, tilt, thrust. Without --write the best is only printed.
"""

from __future__ import annotations

import argparse
import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import skylimb
from skylimb.analysis.recording.run import Run
from skylimb.control.missions.excitation import ExcitationConfig, Sine
from skylimb.flight.experiments.experiment import EXPERIMENTS, Experiment, experiment_with, load_experiment
from skylimb.robots.loader import load_robot
from skylimb.studies.calibration.fit import Fit
from skylimb.studies.calibration.levels import USUAL_NOISE
from skylimb.studies.calibration.parameters import Parameter, centers, scaled
from skylimb.studies.calibration.record import record_of
from skylimb.studies.calibration.result import true_values

FILE = EXPERIMENTS / "calibration.toml"

ROOM = 0.3
"""How far the centre of gravity may go from where it hovers, along each axis, m."""

MOST_TILT = 0.25
"""Greatest tilt, rad."""

THRUST_SHARE = (0.05, 0.8)
"""Part of its greatest thrust that every rotor keeps to."""


class Axis(NamedTuple):
    """What the sines of an axis may be.

    Attributes:
        amplitude: the largest, m or rad.
        frequency: lowest and highest, Hz.
        acceleration: the largest, m/s^2 or rad/s^2.
    """

    amplitude: float
    frequency: tuple[float, float]
    acceleration: float


AXES = {
    "x": Axis(0.15, (0.1, 1.2), 0.8),
    "y": Axis(0.15, (0.1, 1.2), 0.8),
    "z": Axis(0.15, (0.1, 2.5), 2.0),
    "heading": Axis(0.8, (0.03, 0.3), 0.3),
}


class Design(NamedTuple):
    """A manoeuvre and what it is worth; worth 0 is one that leaves its limits."""

    excitation: ExcitationConfig
    worth: float


def designs(experiment: Experiment, count: int, seed: int = 0) -> Iterator[Design]:
    """The best manoeuvre so far, after each of `count` tries.

    Args:
        experiment: with the manoeuvre to begin with, and the controller that flies it.
        count: of tries.
        seed: of the mutations.
    """
    rng = np.random.default_rng(seed)
    best = Design(experiment.excitation, worth_of(experiment, experiment.excitation))
    for number in range(count):
        tried = mutated(best.excitation, rng, 0.5 if number % 2 else 0.2)
        found = Design(tried, worth_of(experiment, tried))
        best = max(best, found, key=lambda one: one.worth)
        yield best


def worth_of(experiment: Experiment, excitation: ExcitationConfig) -> float:
    """What a flight with this excitation shows, or 0 where it leaves its limits."""
    tables = {f"excitation.{key}": [list(s) for s in sines] for key, sines in vars(excitation).items()}
    run = skylimb.run(experiment_with(experiment, tables))
    if run.failed or not within_limits(run):
        return 0.0
    return float(np.linalg.eigvalsh(scaled(*information_of(run)))[0])


def information_of(run: Run) -> tuple[np.ndarray, tuple[Parameter, ...]]:
    """Fisher information of a simulated flight at the truth, (p, p), and of what."""
    robot = load_robot(str(run.log.attrs["robot"]))
    fit = Fit(record_of(run, robot))
    truth = true_values(run, robot)
    theta = centers(fit.parameters) if truth is None else truth
    noise = USUAL_NOISE._replace(push=0.1 * USUAL_NOISE.push, turn=0.1 * USUAL_NOISE.turn)
    predicted = fit.predicted(theta, fit.filtered(theta, noise))
    slopes = np.concatenate([one.by_parameters.reshape(-1, len(theta)) for one in predicted])
    return slopes.T @ slopes, fit.parameters


def within_limits(run: Run) -> bool:
    """Whether a flight kept to its room, to small tilts, and off the limits of its thrusts."""
    moved = np.abs(run.log.cog_position.values - run.log.cog_position.values[0]).max()
    most = max(rotor.thrust_max for rotor in load_robot(str(run.log.attrs["robot"])).description.rotors)
    thrusts = run.log.thrusts.values / most
    low, high = THRUST_SHARE
    return bool(
        moved < ROOM
        and float(run.log.tilt.max()) < MOST_TILT
        and thrusts.min() > low
        and thrusts.max() < high
    )


def mutated(excitation: ExcitationConfig, rng: np.random.Generator, size: float) -> ExcitationConfig:
    """Another one nearby: sines a little stronger or faster, within what their axes allow."""
    changes: dict[str, Any] = {}
    for key, axis in AXES.items():
        sines: tuple[Sine, ...] = getattr(excitation, key)
        changes[key] = tuple(_mutated(sine, axis, rng, size) for sine in sines)
    return dataclasses.replace(excitation, **changes)


def _mutated(sine: Sine, axis: Axis, rng: np.random.Generator, size: float) -> Sine:
    amplitude, frequency, phase = sine
    frequency = float(np.clip(frequency * np.exp(size * rng.standard_normal()), *axis.frequency))
    most = min(axis.amplitude, axis.acceleration / (2.0 * np.pi * frequency) ** 2)
    amplitude = float(np.clip(amplitude * np.exp(size * rng.standard_normal()), 0.05 * most, most))
    return round(amplitude, 4), round(frequency, 3), round(phase + size * float(rng.standard_normal()), 2)


def table(excitation: ExcitationConfig) -> str:
    """The table as the experiment's file has it."""
    lines = [f"{key} = {[list(sine) for sine in getattr(excitation, key)]}" for key in AXES]
    return "\n".join(["[excitation]", *lines, ""])


def main() -> None:
    """Search, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--tries", type=int, default=60)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    worth, best = 0.0, None
    for number, best in enumerate(designs(load_experiment("calibration"), options.tries)):
        if best.worth > worth:
            worth = best.worth
            print(f"{number}: {worth:.1f}\n{table(best.excitation)}", flush=True)
    if best is not None and options.write:
        path = Path(FILE)
        old = path.read_text(encoding="utf-8")
        path.write_text(
            re.sub(r"\[excitation\]\n(?:\w+ = .*\n)*", table(best.excitation), old), encoding="utf-8"
        )


if __name__ == "__main__":
    main()
