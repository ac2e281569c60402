"""Choose the manoeuvre of the experiment `calibration` by what it shows, and write it into its file.

    python benchmarks/calibration_manoeuvre.py [--tries 60] [--write]

Every try flies the described robot and takes the smallest eigenvalue of the flight's Fisher information, in
units of the wanted accuracy. Without --write the best is only printed.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from skylimb.control.missions.excitation import ExcitationConfig
from skylimb.flight.experiments.experiment import EXPERIMENTS, load_experiment
from skylimb.studies.calibration.design import AXES, designs

FILE = EXPERIMENTS / "calibration.toml"


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
