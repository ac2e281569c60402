"""Fly the ensemble, judge it, and leave everything in a folder."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.base.errors import OutputError
from skylimb.base.files import replace_text
from skylimb.studies.campaign.flight_queue import Report
from skylimb.studies.campaign.fly_campaign import run_campaign
from skylimb.studies.campaign.folder import TABLE_FILE
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import Row
from skylimb.studies.reproduction.errata_figure import errata_figure, fly_errata
from skylimb.studies.reproduction.figures import claims_figure, numbers_figure, sensitivity_figure
from skylimb.studies.reproduction.files import result_json
from skylimb.studies.reproduction.judging import judge
from skylimb.studies.reproduction.prior import Prior, load_prior
from skylimb.studies.reproduction.report import render_report
from skylimb.studies.reproduction.result import Result
from skylimb.studies.reproduction.sensitivity import shown_unknowns

DRAWS = 200
ENSEMBLE = "ensemble"
RESULT_FILE, REPORT_FILE, FIGURES = "reproduction.json", "report.html", "figures"


@dataclass(frozen=True)
class Reproduction:
    """What a reproduction came to.

    Attributes:
        folder: with ensemble/ (a campaign's folder), reproduction.json, flights.parquet, figures/ and
            report.html.
        campaign: the ensemble.
        rows: by flight.
        result: None when it was stopped before its end.
    """

    folder: Path
    campaign: Campaign
    rows: Mapping[int, Row]
    result: Result | None


def reproduce(
    out: str | Path,
    draws: int = DRAWS,
    *,
    workers: int | None = None,
    resume: bool = False,
    prior: Prior | None = None,
    errata: bool = True,
    progress: Report | None = None,
) -> Reproduction:
    """Fly the paper's four controllers through an ensemble of what the paper leaves open.

    Args:
        out: a new folder, or with `resume` one that was begun.
        draws: each is flown by all four with the same seed.
        workers: processes; all cores by default, 0 flies in this one. The result does not depend on it.
        resume: go on with a folder; what it holds is not flown again.
        prior: another prior than the declared one.
        errata: whether to fly and draw what the printed forms do.
        progress: called with how far it is.

    Raises:
        ConfigError: when the prior cannot be flown.
        OutputError: when the folder is there without `resume`, is something else's, or cannot be written.
    """
    folder, prior = Path(out), prior or load_prior()
    if folder.exists() and not resume:
        raise OutputError(
            f"output folder '{folder}' exists already; --resume goes on with one that was begun"
        )
    if folder.exists() and not (folder / ENSEMBLE).is_dir():
        raise OutputError(f"'{folder}' holds no reproduction (no {ENSEMBLE}/); choose another folder")
    outcome = run_campaign(
        prior.campaign(draws), folder / ENSEMBLE, workers=workers, resume=resume, progress=progress
    )
    if not outcome.complete:
        return Reproduction(folder, outcome.campaign, outcome.rows, None)
    result = judge(prior, outcome.campaign, outcome.rows)
    _write(folder, prior, outcome.campaign, outcome.rows, result, errata)
    return Reproduction(folder, outcome.campaign, outcome.rows, result)


def _write(
    folder: Path, prior: Prior, campaign: Campaign, rows: Mapping[int, Row], result: Result, errata: bool
) -> None:
    drawings: dict[str, Callable[[], Figure]] = {
        "numbers": lambda: numbers_figure(campaign, rows, result),
        "claims": lambda: claims_figure(result),
    }
    if unknowns := shown_unknowns(result.sensitivity, result.draws):
        drawings["sensitivity"] = lambda: sensitivity_figure(result, unknowns)
    if errata:
        drawings["errata"] = lambda: errata_figure(fly_errata())
    try:
        figures = folder / FIGURES
        figures.mkdir(exist_ok=True)
        pictures = {name: style.save(draw(), figures / name)[0] for name, draw in drawings.items()}
        shutil.copyfile(folder / ENSEMBLE / TABLE_FILE, folder / TABLE_FILE)
        replace_text(folder / RESULT_FILE, result_json(prior, campaign, result))
        replace_text(folder / REPORT_FILE, render_report(prior, campaign, result, pictures))
    except OSError as error:
        raise OutputError(
            f"cannot write to '{folder}': {error.strerror or error}; the flights are kept, --resume goes on"
        ) from error
