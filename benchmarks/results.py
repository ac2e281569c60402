"""Measure what docs/reports/results.md and docs/reports/contact.md say, and write them around pages/.

    python benchmarks/results.py          (about ten minutes; writes docs/reports/*.md and docs/images/)

Every number of those pages comes from here, so that they can be made again after a change. The reproduction's
ensemble is flown by reproduction.py, that of `following` and the hybrid by following.py; their sections are
filled from the results that were committed.
"""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from following import beside_table, kept_numbers
from reproduction import section

import skylimb
from skylimb.analysis import write_comparison
from skylimb.analysis.paper.numbers import published
from skylimb.analysis.scores.axis_names import PAPER
from skylimb.analysis.scores.declared import shown_scores
from skylimb.studies.verification import Row, verify_contact

HERE = Path(__file__).parent
DOCS = HERE.parent / "docs"
CONTROLLERS = ("pid", "impedance", "admittance", "hybrid")
SEEDS, REAL_SEEDS = 20, 6

IDEAL = {"plant.rotors": "thrust"}
"""The rotors that the paper assumes: their thrust lags, and they have no inertia."""

REAL = (
    ("error_u_median", "y error, m", 3),
    ("displacement_median", "x displacement, m", 3),
    ("estimated_force_median", "estimated force, N", 3),
    ("contact_force_normal_mean", "normal force, N", 3),
    ("contact_force_normal_std", "its standard deviation, N", 3),
    ("contact_fraction", "time in touch", 3),
    ("contact_losses", "touch lost", 1),
)

OPEN_VALUES: dict[str, list[tuple[str, dict[str, Any]]]] = {
    "as it is": [("", {})],
    "friction": [("0.2", {"surface.friction": 0.2}), ("0.6", {"surface.friction": 0.6})],
    "depth of the press": [("0.12 m", {"approach.depth": 0.12}), ("0.20 m", {"approach.depth": 0.20})],
    "slope": [("14 degrees", {"surface.slope": math.radians(14.0)})],
    "direction of the lap": [("-1", {"trajectory.direction": -1})],
    "what the reference sends": [("velocity and acceleration too", {"trajectory.feedforward": "full"})],
    "latency": [("30 ms", {"sensors.latency": 0.030}), ("50 ms", {"sensors.latency": 0.050})],
    "rate of control": [("40 Hz", {"controller_rate": 40.0})],
    "low pass of the contact force": [
        ("0.5 Hz", {"controller.estimation.force_filter.cutoff": 0.5}),
        ("10 Hz", {"controller.estimation.force_filter.cutoff": 10.0}),
    ],
    "rotor lag": [("20 ms", {"plant.rotor_lag": 0.02}), ("100 ms", {"plant.rotor_lag": 0.1})],
    "thrust": [("2 % less", {"plant.thrust_scale": 0.98})],
    "stiffness of pen and board": [("1000 N/m", {"surface.stiffness": 1000.0})],
    "attitude misaligned about y": [
        ("+1 degree", {"sensors.attitude_misalignment": [0.0, math.radians(1.0), 0.0]}),
        ("-1 degree", {"sensors.attitude_misalignment": [0.0, -math.radians(1.0), 0.0]}),
    ],
    "leak": [("compensated", {"controller.allocation.leak.compensate": True})],
}
"""Values that the paper does not print, each with what else it could be."""


Flown = list[Mapping[str, skylimb.Run]]
"""Runs by their controller, one mapping a seed."""


def flown(rotors: Mapping[str, Any], seeds: int = SEEDS) -> Flown:
    """The paper's experiment with every seed."""
    return [skylimb.compare("paper", seed=seed, set=rotors) for seed in range(seeds)]


def real_rotors_table(ideal: Flown, real: Flown) -> list[str]:
    """Medians over the seeds with the paper's rotors, then with those of the robot's file."""
    lines = [
        "| controller | " + " | ".join(title for _, title, _ in REAL) + " |",
        "|---" * (len(REAL) + 1) + "|",
    ]
    for name in CONTROLLERS:
        both = [[run[name].metrics for run in runs if not run[name].failed] for runs in (ideal, real)]
        cells = [
            " -> ".join(f"{np.median([one[key] for one in kept]):.{digits}f}" for kept in both)
            for key, _, digits in REAL
        ]
        lost = " -> ".join(str(len(ideal) - len(kept)) for kept in both)
        lines.append(f"| {name} (lost: {lost}) | {' | '.join(cells)} |")
    return lines


def seeds_table(runs: Flown) -> list[str]:
    """All metrics of the four controllers: median and range over the seeds, the paper's numbers below."""
    lost = sum(run.failed for one in runs for run in one.values())
    flights = SEEDS * len(CONTROLLERS)
    lines = [
        f"Median over {SEEDS} seeds of the sensors' noise, smallest and largest in brackets; the paper's",
        f"number, where it prints one, in *italics*. {flights - lost} of {flights} flights finished.",
        "",
        "| | " + " | ".join(CONTROLLERS) + " |",
        "|---|" + "---|" * len(CONTROLLERS),
    ]
    known = shown_scores(run for one in runs for run in one.values())
    for score in (score for part in known.values() for score in part):
        key, label = score.name, ", ".join(filter(None, (score.text(PAPER), score.unit)))
        cells = []
        for name in CONTROLLERS:
            values = [one[name].metrics[key] for one in runs if not one[name].failed]
            if not values or None in values:
                cells.append("–")
                continue
            text = f"{np.median(values):.3f} ({min(values):.3f} .. {max(values):.3f})"
            printed = published(name, key)
            cells.append(text if printed is None else f"{text} *{printed:.3f}*")
        label = label.replace("|", "\\|")
        lines.append(f"| {label} | " + " | ".join(cells) + " |")
    return lines


def open_values_table() -> list[str]:
    """What else the open values could be, and what that does."""
    lines = [
        "| value | y error: PID / impedance / admittance / hybrid (m) | x displacement (m) "
        "| hybrid over impedance | estimated force (N) | time in touch |",
        "|---|---|---|---|---|---|",
    ]
    for title, others in OPEN_VALUES.items():
        for label, settings in others:
            runs = skylimb.compare("paper", set={**IDEAL, **settings})
            columns = [
                _row(runs, key, digits) for key, digits in (("error_u_median", 3), ("displacement_median", 3))
            ]
            lines.append(
                f"| {f'{title} {label}'.strip()} | {columns[0]} | {columns[1]} | {_ratio(runs)} "
                f"| {_row(runs, 'estimated_force_median', 2)} | {_row(runs, 'contact_fraction', 2)} |"
            )
    return lines


def _row(runs: Mapping[str, skylimb.Run], key: str, digits: int) -> str:
    return " / ".join("lost" if run.failed else f"{run.metrics[key]:.{digits}f}" for run in runs.values())


def _ratio(runs: Mapping[str, skylimb.Run]) -> str:
    ours = [runs[name].metrics["displacement_median"] for name in ("hybrid", "impedance")]
    return "-" if None in ours else f"{ours[0] / ours[1]:.2f}"


def surfaces_table() -> list[str]:
    """Who flies which of the ready experiments with contact, and why somebody does not."""
    titles = ["experiment", *CONTROLLERS, "hybrid, leak compensated"]
    lines = ["| " + " | ".join(titles) + " |", "|---" * len(titles) + "|"]
    for name in skylimb.list_experiments():
        if not skylimb.load_experiment(name).approach.contact:
            continue
        runs = [
            *skylimb.compare(name, set=IDEAL).values(),
            skylimb.run(name, "hybrid", set={**IDEAL, "controller.allocation.leak.compensate": True}),
        ]
        cells = [_told(run) for run in runs]
        lines.append(f"| `{name}` | " + " | ".join(cells) + " |")
    return lines


def _told(run: skylimb.Run) -> str:
    if run.failed:
        return f"**{run.status}**: {run.cause}"
    metrics = run.metrics
    errors = f"{1e3 * metrics['error_u_median']:.0f} / {1e3 * metrics['error_v_median']:.0f} mm"
    return (
        f"{errors}, {metrics['contact_force_normal_mean']:.2f} N, {metrics['contact_fraction']:.0%} in touch"
    )


def contact_page() -> tuple[list[str], list[str]]:
    """The claims about the contact as a table, and their figures, copied to docs/images/contact."""
    images = DOCS / "images" / "contact"
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "contact"
        rows = verify_contact(folder)
        images.mkdir(parents=True, exist_ok=True)
        for row in rows:
            if row.figure:
                shutil.copy(folder / row.figure, images / row.figure)
    figures = [f"![{row.claim}](../images/contact/{row.figure})" for row in rows if row.figure]
    return claims(rows), figures


def claims(rows: list[Row]) -> list[str]:
    """Verified claims as a table."""
    table = ["| claim | measured | theory | tolerance | cases | |", "|---|---|---|---|---|---|"]
    return [*table, *(_claim(row) for row in rows)]


def _claim(row: Row) -> str:
    bound = {"below": "at most ", "above": "at least "}.get(row.bound, "")
    verdict = "holds" if row.passed else "**fails**"
    measured = f"{row.measured:.5g} {row.unit}".removesuffix(" -")
    cells = (row.claim, measured, f"{bound}{row.theory:.5g}", f"{row.tolerance:g}", str(row.cases), verdict)
    return f"| {' | '.join(cells)} |"


def images() -> None:
    """The demo's figures, for the documentation."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "demo"
        runs = skylimb.compare("paper", set=IDEAL)
        write_comparison(runs, folder)
        (DOCS / "images").mkdir(exist_ok=True)
        for name in ("pen_traces", "contact_direction", "poses"):
            shutil.copy(folder / "figures" / f"{name}.png", DOCS / "images" / f"{name}.png")


def write_page(name: str, places: Mapping[str, list[str]]) -> None:
    """The page `name`, its words from the file beside this, with every place filled."""
    page = (HERE / "pages" / name).read_text(encoding="utf-8")
    for place, lines in places.items():
        page = page.replace(place, "\n".join(lines))
    (DOCS / "reports" / name).write_text(page, encoding="utf-8")


def main() -> None:
    table, figures = contact_page()
    version, ideal = [skylimb.__version__], flown(IDEAL)
    write_page("contact.md", {"VERSION": version, "CLAIMS": table, "FIGURES": figures})
    tables = {
        "OPEN_VALUES_TABLE": open_values_table(),
        "SEEDS_TABLE": seeds_table(ideal),
        "REAL_ROTORS_TABLE": real_rotors_table(ideal[:REAL_SEEDS], flown({}, REAL_SEEDS)),
        "SURFACES_TABLE": surfaces_table(),
        "BEYOND_TABLE": beside_table(kept_numbers()),
    }
    images()
    write_page("results.md", {"VERSION": version, **tables, "REPRODUCTION_SECTION": [section()]})


if __name__ == "__main__":
    main()
