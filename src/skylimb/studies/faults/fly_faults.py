"""Fly the catalogue: a campaign a fault, without the supervisor and with it, and the table of all."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from math import ceil, inf, isfinite
from pathlib import Path

from skylimb.analysis.scores.faults import OUTLIVED
from skylimb.base.errors import OutputError
from skylimb.base.files import replace_text
from skylimb.studies.campaign.flight_queue import Report
from skylimb.studies.campaign.fly_campaign import Outcome as CampaignOutcome
from skylimb.studies.campaign.fly_campaign import run_campaign
from skylimb.studies.campaign.folder import load_campaign, log_name, logged
from skylimb.studies.campaign.logs import worst
from skylimb.studies.campaign.rows import OK, REFUSED
from skylimb.studies.campaign.store import load_rows
from skylimb.studies.faults.catalogue import Catalogue, Fault, load_catalogue
from skylimb.studies.faults.page import Row, faults_page

DRAWS = 200
RESULT_FILE, PAGE_FILE = "faults.json", "faults.md"
SIDES = ("unprotected", "supervised")
"""Folders of the flights without the supervisor, and with it."""


@dataclass(frozen=True)
class Outcome:
    """What the catalogue came to.

    Attributes:
        folder: a campaign's folder for each fault in `unprotected/` and `supervised/`, the table as data and
            as a page.
        catalogue: what was flown, and what stood in the folder before.
        rows: of all that, in its order.
        flown: flights that are kept, of those asked for.
        total: flights that were asked for.
        complete: whether all of it was.
    """

    folder: Path
    catalogue: Catalogue
    rows: tuple[Row, ...]
    flown: int
    total: int
    complete: bool


def fly_faults(
    out: str | Path,
    draws: int = DRAWS,
    *,
    controllers: Sequence[str] = (),
    only: Collection[str] = (),
    catalogue: Catalogue | None = None,
    workers: int | None = None,
    resume: bool = False,
    progress: Report | None = None,
) -> Outcome:
    """Fly every fault of the catalogue, with every controller, unprotected and supervised.

    Args:
        out: a new folder, or with `resume` one that was begun.
        draws: that each controller flies of each fault.
        controllers: in place of the catalogue's.
        only: names of the faults to fly; all of them where it is empty. What the folder holds of the others
            stays in the table.
        catalogue: another than the one that ships.
        workers: processes; all cores by default, 0 flies in this one. The result does not depend on it.
        resume: go on with a folder; what it holds is not flown again.
        progress: called with how far the fault at hand is.

    Raises:
        ConfigError: when a fault cannot be flown.
        OutputError: when the folder is there without `resume`, or cannot be written.
    """
    folder, whole = Path(out), (catalogue or load_catalogue()).only((), controllers)
    chosen = whole.only(only, ())
    if folder.exists() and not resume:
        raise OutputError(
            f"output folder '{folder}' exists already; --resume goes on with one that was begun"
        )
    rows, count = list[Row](), 0
    total = len(chosen.faults) * len(SIDES) * draws * len(chosen.controllers)
    for fault, supervised in product(whole.faults, (False, True)):
        place = Path(SIDES[supervised]) / fault.name.replace(" ", "-")
        if fault not in chosen.faults:
            before = _flown_before(whole, fault, supervised, folder / place)
            rows += _rows(fault, supervised, before, place) if before else ()
            continue
        spec = chosen.campaign(fault, draws, supervised)
        flown = run_campaign(
            spec, folder / place, workers=workers, resume=(folder / place).exists(), progress=progress
        )
        count += len(flown.rows)
        if flown.summary is None:
            return Outcome(folder, whole, tuple(rows), count, total, complete=False)
        rows += _rows(fault, supervised, flown, place)
    replace_text(folder / RESULT_FILE, json.dumps([asdict(row) for row in rows], indent=1) + "\n")
    replace_text(folder / PAGE_FILE, faults_page(whole, rows))
    return Outcome(folder, whole, tuple(rows), count, total, complete=True)


def _flown_before(
    catalogue: Catalogue, fault: Fault, supervised: bool, folder: Path
) -> CampaignOutcome | None:
    """What a folder holds of a fault; None where it is not through, or was flown as another fault than it is.

    Raises:
        OutputError: when something else is there.
    """
    if not folder.exists():
        return None
    campaign = load_campaign(folder)
    rows, damaged = load_rows(folder, campaign)
    spec = campaign.spec
    same = catalogue.only((), spec.controllers).campaign(fault, spec.draws, supervised)
    through = len(rows) == campaign.flight(spec.draws, 0)
    return (
        CampaignOutcome(folder, campaign, rows, None, damaged)
        if through and spec.to_mapping() == same.to_mapping()
        else None
    )


def _rows(fault: Fault, supervised: bool, flown: CampaignOutcome, place: Path) -> Iterator[Row]:
    """What a fault did to the flights of each controller."""
    for name in flown.campaign.names:
        own = [row for row in flown.rows.values() if row["controller"] == name and row["status"] != REFUSED]
        held = fault.held(supervised)
        # Being noticed late is no harm, but where nothing else can be done.
        judged = fault.held(False) or held
        found = {key: [row[f"fault_{key}"] for row in own] for key in held}
        values = {key: [inf if one is None else one for one in numbers] for key, numbers in found.items()}
        kept = [all(values[key][k] <= most for key, (_, most) in judged.items()) for k in range(len(own))]
        lived = [
            row["status"] == OK or (row["fault_lasted"] or 0.0) >= OUTLIVED or row["fault_landed"] == 1.0
            for row in own
        ]
        outlived = fault.survived or not judged
        kept_logs = logged(flown.folder, own)
        bad = worst(flown.campaign, [row for row in own if row["flight"] in kept_logs], 1)
        yield Row(
            fault.name,
            name,
            supervised,
            len(own),
            sum(lived),
            sum(b and (a or not outlived) for a, b in zip(lived, kept, strict=True)),
            {key: _spread(numbers) for key, numbers in values.items()},
            (place / log_name(bad[0])).as_posix() if bad else "",
            next((row["cause"] for row, alive in zip(own, lived, strict=True) if not alive), ""),
        )


def _spread(values: Sequence[float]) -> tuple[float | None, float | None]:
    """Median, and what 99 % keep; None where that is a lost flight's, or nothing was flown."""
    if not values:
        return None, None
    median, most = (sorted(values)[ceil(share * len(values)) - 1] for share in (0.5, 0.99))
    return median if isfinite(median) else None, most if isfinite(most) else None
