"""The verbs that fly an ensemble that ships, and hold it to what is claimed: `reproduce` and `faults`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.campaign_progress import Resume, Workers, campaign_progress, interrupted
from skylimb.apps.cli.options import within

if TYPE_CHECKING:
    from skylimb.studies.reproduction import Result


def reproduce(
    *,
    draws: Annotated[int | None, arg("Draws, each flown by all four; by default 200.", "N")] = None,
    out: Annotated[str, arg("Folder for the results.", "DIR")] = "out/reproduction",
    workers: Annotated[int | None, arg("Processes (0: only this one); by default one a core.", "N")] = None,
    resume: Resume = False,
) -> int:
    """Compare the paper's numbers and claims with an ensemble over what it leaves open.

    Draws friction, press, calibration and whatever else the paper doesn't print from a declared prior, flies
    the four controllers through every draw, and leaves reproduction.json, flights.parquet, figures/ and
    report.html. Ctrl-C finishes what flies and keeps it; --resume goes on. A lost flight is part of the
    result, not an error.

    Examples:
        skylimb reproduce --out out/reproduction
        skylimb reproduce --draws 20 --workers 2 --out out/short
        skylimb reproduce --out out/reproduction --resume
    """
    if draws is not None:
        within("--draws", draws, 2, 100_000)
    from skylimb.studies import reproduction
    from skylimb.studies.reproduction.reproduce import DRAWS

    with campaign_progress() as report:
        outcome = reproduction.reproduce(out, draws or DRAWS, workers=workers, resume=resume, progress=report)
    if outcome.result is None:
        total = outcome.campaign.flight(outcome.campaign.spec.draws, 0)
        again = {"draws": draws or DRAWS, "workers": workers}
        return interrupted(len(outcome.rows), total, out, "reproduce", **again)
    _show_reproduction(outcome.result)
    output.places(Path(out))
    return 0


def faults(
    *,
    controllers: Annotated[
        tuple[str, ...], arg("Presets, TOML files or Python files; by default the catalogue's.", "NAME ...")
    ] = (),
    only: Annotated[tuple[str, ...], arg("Faults to fly, by name; all by default.", "FAULT ...")] = (),
    catalogue: Annotated[str, arg("Another catalogue than the one that ships.", "FILE")] = "",
    draws: Annotated[int, arg("Draws of each fault that each controller flies.", "N")] = 200,
    out: Annotated[str, arg("Folder for the results.", "DIR")] = "out/faults",
    workers: Workers = None,
    resume: Resume = False,
) -> int:
    """Fly a catalogue of faults, and say what survives within which bounds.

    Each fault is a campaign: rotors that fail, joints, motion capture, pushes, a board that is gone, commands
    that come too late. Leaves faults.json, faults.md, and the campaigns' folders, each with a report in which
    the worst flight can be watched. Ctrl-C finishes what flies and keeps it; --resume goes on. With --only as
    well, what the folder holds of other faults stays in the table.

    Examples:
        skylimb faults --draws 20 --out out/faults
        skylimb faults --only "rotor at half" "push of 4 N" --draws 4
        skylimb faults --controllers hybrid mine.toml
    """
    from skylimb.studies.faults import fly_faults, load_catalogue

    within("--draws", draws, 1, 1_000_000)
    chosen = load_catalogue(catalogue) if catalogue else None
    with campaign_progress() as report:
        outcome = fly_faults(
            out, draws, controllers=controllers, only=only, catalogue=chosen, workers=workers, resume=resume,
            progress=report,
        )  # fmt: skip
    if not outcome.complete:
        again = {"controllers": controllers, "only": only, "catalogue": catalogue}
        again |= {"draws": draws, "workers": workers}
        return interrupted(outcome.flown, outcome.total, out, "faults", **again)
    known = {fault.name: fault for fault in outcome.catalogue.faults}
    rows = [
        (row.fault, row.flown_by, *row.shares, "yes" if row.reached(known[row.fault]) else "no")
        for row in outcome.rows
    ]
    output.show_table(rows, "Fault", "Flown by", "Survived", "Within its bounds", "All kept")
    output.places(Path(out))
    return 0


def _show_reproduction(result: Result) -> None:
    """The twelve numbers, the claims and the losses."""
    from skylimb.studies.reproduction.report import digits, rate_text, spread_text
    from skylimb.studies.reproduction.result import BESIDE, NUMBERS, label

    columns = ("Number", "Controller", "Paper", "Ensemble: median (5 to 95 %)", "Paper's percentile")
    rows = [
        (
            label(key),
            number.controller,
            f"{number.paper:.3f}" if not math.isnan(number.paper) else "-",
            spread_text(number.ours, digits(key)),
            ""
            if math.isnan(number.paper)
            else f"{number.percentile:.0f} %{'' if number.inside else ' outside'}",
        )
        for key in (*NUMBERS, *BESIDE)
        for number in result.numbers
        if number.key == key
    ]
    output.show_table(rows, *columns)
    claims = [(one.claim.name, rate_text(one.rate), rate_text(one.finished)) for one in result.claims]
    output.show_table(claims, "Claim", "Holds in (95 % interval)", "Without loss")
    lost = {name: sum(causes.values()) for name, causes in result.failures.items()}
    print(f"{result.inside} of 12 published numbers lie within the ensemble's 5 to 95 %")
    print("lost flights: " + ", ".join(f"{name} {count}" for name, count in lost.items()))
    if result.refused:
        print(f"{len(result.refused)} draws that not every controller can fly count against every claim")
