"""What the inertia of the rotors does to every preset: force, touching, losses, line, jumps, motor torque.

    python benchmarks/rotors.py [--draws 100] [--tables]    (about half an hour on two cores)

The paper's board with the draws of benchmarks/following.py. With a speed (plant.rotors = "speed") the rotors
have the stated inertia, drawn within 30 % of it, and the controllers know nothing of it. Flights that
take-off would refuse for their reaction are flown too (approach.doubtful). docs/rotors.json keeps every
number; the table in docs/reports/rotors.md and the spectra in docs/images are written anew.
"""

from __future__ import annotations

import argparse
import itertools
import json
import re
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from following import compact, draws  # beside this file
from results import claims

from skylimb.analysis.recording.run import Run
from skylimb.control.controller import load_controller
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import prepare
from skylimb.robots.loader import load_robot
from skylimb.studies.verification import verify_rotors

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS = DOCS / "reports" / "rotors.md", DOCS / "rotors.json"
PRESETS = ("pid", "impedance", "admittance", "hybrid", "following", "drawing")
INERTIAS = (None, 0.0, 1e-4, 2e-4, 3.24e-4, 6.5e-4)
"""kg m^2; None for the paper's rotors, whose thrust lags."""
CHUNK, PERIOD = 10, 0.005
SHOWN = (
    ("force std N", "contact_force_normal_std", 1.0, 3),
    ("touching %", "contact_fraction", 100.0, 1),
    ("contact lost", "contact_losses", 1.0, 0),
    ("pen rms mm", "pen_line_rms", 1e3, 1),
    ("jump N", "jump", 1.0, 2),
    ("motor N m", "motor", 1.0, 2),
)


def scored(run: Run) -> dict[str, Any]:
    """Scores of a run: jump is the root mean square change of a thrust command at a tick, N."""
    command = run.log.thrusts_command.values[run.log.time.values > 2.0]
    jump = float(np.sqrt(np.mean(np.diff(command, axis=0) ** 2))) if len(command) > 1 else None
    motor = float(np.abs(run.log.motor_torques.values).max()) if "motor_torques" in run.log else None
    keys = ("contact_force_normal_std", "contact_fraction", "contact_losses", "pen_line_rms")
    return {
        "status": run.status, "cause": run.cause, "time": float(run.log.time.values[-1]), "jump": jump,
        "motor": motor,
        **{key: run.metrics.get(key) for key in keys},
    }  # fmt: skip


def ensemble(preset: str, inertia: float | None, count: int) -> list[dict[str, Any]]:
    """Scores of every draw."""
    warnings.simplefilter("ignore")
    robot, rng = load_robot("hydrus_xi_quad"), np.random.default_rng(11)
    controller, ready, scores = load_controller(preset, robot), [], []
    for index, drawn in enumerate(draws("paper", count)):
        share = rng.uniform(0.7, 1.3)
        if inertia is not None:
            drawn |= {"plant.rotors": "speed", "plant.rotor_inertia": share * inertia}
        drawn |= {"approach.doubtful": "fly"}
        ready.append(prepare(load_experiment("paper", drawn), robot, controller))
        if len(ready) == CHUNK or index == count - 1:
            scores += [scored(scored_run(*one)) for one in zip(ready, fly_native(ready), strict=True)]
            ready.clear()
    return scores


def name_of(preset: str, inertia: float | None) -> str:
    """A row's name."""
    return f"{preset}, {'lag of the thrust' if inertia is None else f'{inertia:g}'}"


def table(numbers: dict[str, Any]) -> str:
    """Medians and worst deciles of the flights that came home, in Markdown."""
    lines = ["| preset | inertia kg m² | lost | " + " | ".join(title for title, *_ in SHOWN) + " |"]
    lines.append("|---" * (3 + len(SHOWN)) + "|")
    for preset, inertia in itertools.product(PRESETS, INERTIAS):
        scores = numbers[name_of(preset, inertia)]
        home = [score for score in scores if score["status"] == "OK"]
        cells = [
            f"`{preset}`",
            "none" if inertia is None else f"{inertia:g}",
            f"{len(scores) - len(home)} of {len(scores)}",
        ]
        for _, key, scale, digits in SHOWN:
            known = [scale * score[key] for score in home if score[key] is not None]
            worst = 10.0 if key == "contact_fraction" else 90.0
            both = [f"{np.percentile(known, at):.{digits}f}" for at in (50.0, worst)] if known else []
            cells.append(" / ".join(both))
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def spectra() -> None:
    """The amplitude spectra of thrust commands, with and without inertia."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), sharey=True, layout="constrained")
    for axis, preset in zip(axes, ("hybrid", "following"), strict=True):
        for inertia, label in ((None, "thrust lags"), (2e-4, "2e-4 kg m²")):
            changes: dict[str, Any] = {"approach.doubtful": "fly"}
            if inertia is not None:
                changes |= {"plant.rotors": "speed", "plant.rotor_inertia": inertia}
            takeoff = prepare(
                load_experiment("paper", changes), load_robot("hydrus_xi_quad"),
                load_controller(preset, load_robot("hydrus_xi_quad")),
            )  # fmt: skip
            log = scored_run(takeoff, fly_native([takeoff])[0]).log
            command = log.thrusts_command.values[log.time.values > 10.0]
            windows = np.lib.stride_tricks.sliding_window_view(command, 1024, axis=0)[::512]
            shaped = (windows - windows.mean(axis=-1, keepdims=True)) * np.hanning(1024)
            power = (
                np.mean(np.abs(np.fft.rfft(shaped, axis=-1)) ** 2, axis=(0, 1))
                * PERIOD
                / np.sum(np.hanning(1024) ** 2)
            )
            axis.loglog(np.fft.rfftfreq(1024, PERIOD)[1:], np.sqrt(2.0 * power[1:]), label=label)
        axis.set(title=preset, xlabel="frequency (Hz)")
        axis.legend()
    axes[0].set_ylabel("thrust command (N/√Hz)")
    figure.savefig(DOCS / "images" / "thrust_spectra.png", dpi=120)


def main() -> None:
    """Fly everything, keep the numbers, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--tables", action="store_true", help="fly nothing: the table of docs/rotors.json")
    options = parser.parse_args()
    cases = list(itertools.product(PRESETS, INERTIAS))
    if options.tables:
        kept = json.loads(NUMBERS.read_text(encoding="utf-8"))
        numbers = {
            key: [dict(zip(value, row, strict=True)) for row in zip(*value.values(), strict=True)]
            for key, value in kept.items()
            if isinstance(value, dict)
        }
    else:
        numbers = {}
        with ProcessPoolExecutor(options.workers) as pool:
            jobs = [pool.submit(ensemble, *case, options.draws) for case in cases]
            for case, job in zip(cases, jobs, strict=True):
                numbers[name_of(*case)] = job.result()
                print(f"{len(numbers)} of {len(cases)}", flush=True)
        NUMBERS.write_text(compact(numbers), encoding="utf-8")
        spectra()
    text = PAGE.read_text(encoding="utf-8")
    for name, made in (("table", table(numbers)), ("claims", "\n".join(claims(verify_rotors())))):
        begin, end = f"<!-- begin: {name} -->", f"<!-- end: {name} -->"
        text = re.sub(f"{begin}.*?{end}", lambda _, made=f"{begin}\n{made}\n{end}": made, text, flags=re.S)
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
