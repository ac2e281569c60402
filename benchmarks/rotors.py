"""What the inertia of the rotors does to every preset: force, touching, losses, line, jumps, motor torque.

    python benchmarks/rotors.py [--draws 100] [--tables]    (an hour on two cores)
    python benchmarks/rotors.py --preset following --set 'controller.attitude.damping_ratio=[1,1,1]' \
        --draws 8 --seed 1000

The paper's board twice: robots that know themselves, where a draw is noise and inertia; and robots that do
not, with the draws of benchmarks/following.py. The rotors have the stated inertia, drawn within 30 % of it,
and the controllers know the robot's file alone. Flights that take-off would refuse for their reaction are
flown too (approach.doubtful). docs/rotors.json keeps every number; the tables in docs/reports/rotors.md and
the spectra in docs/images are written anew. `--preset` flies one preset with changes, prints its rows and
writes nothing: gains are searched on other seeds than the tables'.
"""

from __future__ import annotations

import argparse
import itertools
import json
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from following import NONE, Changes, compact, draws  # beside this file
from kept import fill
from results import claims

from skylimb.analysis.recording.run import Run
from skylimb.apps.cli.options import settings_of
from skylimb.base.errors import UnreachableError
from skylimb.control.controller import load_controller, require_compiled
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.loading import parted
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import prepare
from skylimb.robots.loader import load_robot
from skylimb.robots.reaction import reaction_zeros, slowest_unstable_zero
from skylimb.studies.verification import verify_rotors
from skylimb.studies.verification.stability import linearise, operating_point

DOCS = Path(__file__).parents[1] / "docs"
PAGE, NUMBERS = DOCS / "reports" / "rotors.md", DOCS / "rotors.json"
PRESETS = ("pid", "impedance", "admittance", "hybrid", "following", "drawing")
INERTIAS = (None, 0.0, 1e-4, 2e-4, 3.24e-4, 6.5e-4)
"""kg m^2; None for the paper's rotors, whose thrust lags."""
KNOWN, DRAWN = "known", "drawn"
CASES = (
    *itertools.product((KNOWN,), PRESETS, INERTIAS),
    *itertools.product((DRAWN,), PRESETS, INERTIAS),
)
"""Whether the robot knows itself or not, preset, inertia."""
UNFILTERED: Changes = {"estimation.smoothing.on": False, "allocation.rotor_lag.bandwidth": 1e6}
SEED, CHUNK, PERIOD = 11, 10, 0.005
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


def drawn_flights(kind: str, count: int, seed: int) -> Iterator[dict[str, Any]]:
    """Changes to the paper's board, without the rotors'."""
    if kind == KNOWN:
        return ({"seed": seed + index} for index in range(count))
    # Another seed's draws are later ones.
    first = seed - SEED
    return itertools.islice(draws("paper", first + count), first, None)


def ensemble(
    kind: str, preset: str, inertia: float | None, count: int, seed: int = SEED, changes: Changes = NONE
) -> list[dict[str, Any]]:
    """Scores of every draw."""
    warnings.simplefilter("ignore")
    robot, rng = load_robot("hydrus_xi_quad"), np.random.default_rng(seed)
    settings, gains = parted(changes)
    controller, ready, scores = load_controller(preset, robot, gains), [], []
    for index, drawn in enumerate(drawn_flights(kind, count, seed)):
        share = rng.uniform(0.7, 1.3)
        rotors: dict[str, Any] = {"plant.rotors": "thrust"}
        if inertia is not None:
            rotors = {"plant.rotors": "speed", "plant.rotor_inertia": share * inertia}
        flown = {**drawn, **rotors, "approach.doubtful": "fly", **settings}
        ready.append(prepare(load_experiment("paper", flown), robot, controller))
        if len(ready) == CHUNK or index == count - 1:
            scores += [scored(scored_run(*one)) for one in zip(ready, fly_native(ready), strict=True)]
            ready.clear()
    return scores


def name_of(kind: str, preset: str, inertia: float | None) -> str:
    """A row's name."""
    return f"{kind}, {preset}, {'lag of the thrust' if inertia is None else f'{inertia:g}'}"


def row(preset: str, inertia: float | None, scores: list[dict[str, Any]]) -> str:
    """Medians and worst deciles of the flights that came home, in Markdown."""
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
    return f"| {' | '.join(cells)} |"


def heading() -> list[str]:
    """The first two lines of a table."""
    titles = ["preset", "inertia kg m²", "lost", *(title for title, *_ in SHOWN)]
    return [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]


def table(numbers: dict[str, Any], kind: str) -> str:
    """The table of one kind of draws, in Markdown."""
    cases = [case for case in CASES if case[0] == kind and name_of(*case) in numbers]
    return "\n".join([*heading(), *(row(*case[1:], numbers[name_of(*case)]) for case in cases)])


def margins() -> str:
    """Zeros on both sides of the arm, and of the modes in contact above 1 Hz the one that dies slowest."""
    titles = ("preset", "inertia kg m²", "zero, as the paper", "zero, as flown", "mode", "damping ratio")
    robot = load_robot("hydrus_xi_quad")
    q, psi = nominal_posture(robot, "contact")
    lines = [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
    for preset, inertia in itertools.product(("following", "drawing"), INERTIAS[1:]):
        flown = {
            "plant.rotors": "speed", "plant.rotor_inertia": inertia, "approach.doubtful": "fly",
            "phases.hover": 1.0, "phases.tare": 1.0, "sensors.latency": 0.02,
        }  # fmt: skip
        controller = require_compiled(load_controller(preset, robot), "linearised")
        ends = ("lost", "")
        with suppress(UnreachableError):
            modes = linearise(operating_point(load_experiment("paper", flown), controller)).modes(60)
            mode = min((mode for mode in modes if mode.frequency > 1.0), key=lambda mode: mode.damping_ratio)
            ends = (f"{mode.frequency:.1f} Hz", f"{mode.damping_ratio:.2f}")
        zeros = [slowest_unstable_zero(reaction_zeros(robot, s * q, s * psi, inertia)) for s in (-1.0, 1.0)]
        shown = ["none" if np.isinf(zero) else f"+{zero:.3g} rad/s" for zero in zeros]
        lines.append(f"| {' | '.join((f'`{preset}`', f'{inertia:g}', *shown, *ends))} |")
    return "\n".join(lines)


def spectra() -> None:
    """The amplitude spectra of thrust commands with rotors of 2e-4 kg m^2, filtered and not."""
    import matplotlib.pyplot as plt

    robot, window = load_robot("hydrus_xi_quad"), np.hanning(1024)
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), sharey=True, layout="constrained")
    for axis, preset in zip(axes, ("following", "drawing"), strict=True):
        for gains, label in ((UNFILTERED, "neither smoothed nor filtered"), (NONE, "as it ships")):
            takeoff = prepare(load_experiment("paper"), robot, load_controller(preset, robot, gains))
            log = scored_run(takeoff, fly_native([takeoff])[0]).log
            command = log.thrusts_command.values[log.time.values > 10.0]
            windows = np.lib.stride_tricks.sliding_window_view(command, 1024, axis=0)[::512]
            shaped = (windows - windows.mean(axis=-1, keepdims=True)) * window
            power = np.mean(np.abs(np.fft.rfft(shaped, axis=-1)) ** 2, axis=(0, 1)) * PERIOD
            axis.loglog(
                np.fft.rfftfreq(1024, PERIOD)[1:], np.sqrt(2.0 * power[1:] / np.sum(window**2)), label=label
            )
        axis.set(title=preset, xlabel="frequency (Hz)")
        axis.legend()
    axes[0].set_ylabel("thrust command (N/√Hz)")
    figure.savefig(DOCS / "images" / "thrust_spectra.png", dpi=120, metadata={"Software": None})


def main() -> None:
    """Fly everything, keep the numbers, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument(
        "--only", default="", help="fly the cases with this in their name, and keep the others"
    )
    parser.add_argument("--tables", action="store_true", help="fly nothing: the tables of docs/rotors.json")
    parser.add_argument("--preset", help="fly this one alone, and print its rows")
    parser.add_argument("--set", nargs="*", default=[], metavar="KEY=VALUE")
    parser.add_argument("--seed", type=int, default=SEED, help="of the first draw")
    parser.add_argument("--inertias", nargs="*", type=float, default=[0.0, 2e-4, 3.24e-4])
    parser.add_argument("--kind", choices=(KNOWN, DRAWN), default=KNOWN)
    options = parser.parse_args()
    if options.preset:
        changes = settings_of(tuple(options.set))
        print("\n".join(heading()))
        for inertia in options.inertias:
            flown = ensemble(options.kind, options.preset, inertia, options.draws, options.seed, changes)
            print(row(options.preset, inertia, flown), flush=True)
        return
    numbers: dict[str, Any] = {}
    if options.tables or options.only:
        kept = json.loads(NUMBERS.read_text(encoding="utf-8"))
        numbers = {
            key: [dict(zip(value, row, strict=True)) for row in zip(*value.values(), strict=True)]
            for key, value in kept.items()
            if isinstance(value, dict)
        }
    if not options.tables:
        cases = [case for case in CASES if options.only in name_of(*case)]
        with ProcessPoolExecutor(options.workers) as pool:
            jobs = [pool.submit(ensemble, *case, options.draws) for case in cases]
            for done, (case, job) in enumerate(zip(cases, jobs, strict=True), start=1):
                numbers[name_of(*case)] = job.result()
                NUMBERS.write_text(compact(numbers), encoding="utf-8")
                print(f"{done} of {len(cases)}", flush=True)
        spectra()
    made = {KNOWN: table(numbers, KNOWN), DRAWN: table(numbers, DRAWN), "margins": margins()}
    for name, part in {**made, "claims": "\n".join(claims(verify_rotors()))}.items():
        fill(PAGE, name, part)


if __name__ == "__main__":
    main()
