"""Flights in Drake beside MuJoCo's, noise and latency off, steps halved: docs/reports/second_engine.md.

python benchmarks/second_engine.py
python benchmarks/second_engine.py --flights paper:hybrid --steps 1e-3
python benchmarks/second_engine.py --flights paper:hybrid --own-contact
python benchmarks/second_engine.py --flights paper:following paper:drawing --steps 1e-3
python benchmarks/second_engine.py --flights paper:following:dragon --steps 1e-3 2.5e-4
"""

from __future__ import annotations

import argparse
import runpy
from pathlib import Path

import numpy as np

import skylimb
from skylimb.simulation.user_plant import UserPlant

PLANTS = Path(__file__).parents[1] / "examples" / "plants"
_NOISY = ("position", "velocity", "attitude", "angular_velocity", "joint", "vectoring")
QUIET = {"sensors.latency": 0.0, **{f"sensors.{name}_noise": 0.0 for name in _NOISY}}
FLIGHTS = ("free_flight:pid", "paper:pid", "paper:impedance", "paper:admittance", "paper:hybrid")
MEASURES = (("cog_position", 1e3), ("tip_position", 1e3), ("contact_force", 1e3), ("joint_angles", 1e3))
"""Signals, and by what they are multiplied for a table: mm, mm, mN, mrad."""


def drake(own_contact: bool = False) -> UserPlant:
    """The robot in Drake, with skylimb's contact or Drake's."""
    return runpy.run_path(str(PLANTS / "drake_plant.py"))["DrakePlant"](own_contact)


def flown(name: str, step: float, own_contact: bool = False, **changes: object) -> list[skylimb.Run]:
    """The same flight in MuJoCo and in Drake.

    Args:
        name: experiment and controller, and another robot where there is one, with colons between them.
        step: of the physics, s.
        own_contact: whether Drake touches with its own contact.
        changes: of the experiment.
    """
    experiment, controller, *robot = name.split(":")
    asked = {**QUIET, "plant.physics_step": step, **({"robot": robot[0]} if robot else {}), **changes}
    plants = (None, drake(own_contact))
    runs = [skylimb.run(experiment, controller, set=asked, plant=plant) for plant in plants]
    for run in runs:
        assert run.status == "OK", run.cause
    return runs


def away(runs: list[skylimb.Run]) -> list[float]:
    """Rms of what differs between the engines, in the units of `MEASURES`, as long as both flights last."""
    ours, theirs = (run.log for run in runs)
    both = slice(min(ours.sizes["time"], theirs.sizes["time"]))
    apart = [(ours[signal].values[both] - theirs[signal].values[both]) * by for signal, by in MEASURES]
    return [float(np.sqrt(np.mean(np.sum(one**2, axis=1)))) for one in apart]


def differences(name: str, step: float, **changes: object) -> list[float]:
    """Rms over the whole flight of what differs between the engines, in the units of `MEASURES`."""
    return away(flown(name, step, False, **changes))


def scores(runs: list[skylimb.Run]) -> str:
    """How far the pen was off its line, mm, and the deviation of the force, N, in both engines."""
    names = ("pen_line_rms", "contact_force_normal_std")
    shown = [[float(run.metrics.get(name) or np.nan) for name in names] for run in runs]
    return "; ".join(f"{1e3 * line:.2f}, {force:.3f}" for line, force in shown)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flights", nargs="*", default=FLIGHTS)
    parser.add_argument("--steps", nargs="*", type=float, default=(1e-3, 5e-4, 2.5e-4))
    parser.add_argument("--own-contact", action="store_true", help="touch with Drake's own contact")
    given = parser.parse_args()
    print("| flight | step ms | CoG mm | pen mm | force mN | joints mrad | line mm, force std N in both |")
    print("|---" * 7 + "|")
    for name in given.flights:
        for step in given.steps:
            runs = flown(name, step, given.own_contact)
            numbers = " | ".join(f"{value:.2g}" for value in away(runs))
            print(f"| {name.replace(':', ', ')} | {1e3 * step:g} | {numbers} | {scores(runs)} |", flush=True)


if __name__ == "__main__":
    main()
