"""Writes what a run or a comparison leaves: records, scores, figures and the report; see `videos` for videos.

A run's folder holds log.nc, metrics.json, config.toml, figures/ and report.html. A comparison's folder holds
a subfolder with the first three for each run, and metrics.csv, figures/ and report.html for all of them.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from skylimb.analysis.recording import LOG_FILE, Run, write_sources
from skylimb.analysis.scores.declared import scores_of
from skylimb.analysis.scores.registry import NUMERIC_KEYS, SCORES
from skylimb.analysis.scores.user_scores import UserFigure, scored_again
from skylimb.base.errors import OutputError, of_an_extra
from skylimb.base.files import csv_text, new_folder, replace_text, writing

CONFIG_FILE = "config.toml"
METRICS_FILE = "metrics.json"
TABLE_FILE = "metrics.csv"
REPORT_FILE = "report.html"
FIGURES_FOLDER = "figures"
_NO_NAME = '/\\:*?"<>|\n'
"""Letters that the name of a folder cannot have."""


def write_run(
    run: Run, folder: str | Path, videos_follow: bool = False, figures: Sequence[UserFigure] = ()
) -> Path:
    """Write a run into a new folder, which appears under its name when it is complete.

    Args:
        run: what flew.
        folder: must not exist.
        videos_follow: whether the report leaves room for a video that is drawn next.
        figures: of the user's own, besides those that ship.

    Raises:
        OutputError: if the folder exists or cannot be written; nothing is left behind then.
    """
    with new_folder(folder) as aside:
        _records({run.name: run}, aside, apart=False)
        _draw({run.name: run}, aside, videos_follow, figures)
    return Path(folder)


def write_comparison(
    runs: Mapping[str, Run],
    folder: str | Path,
    videos_follow: bool = False,
    figures: Sequence[UserFigure] = (),
) -> Path:
    """Write a comparison into a new folder, which appears under its name when it is complete.

    Args:
        runs: by name, which becomes a folder's name.
        folder: must not exist.
        videos_follow: whether the report leaves room for videos that are drawn next.
        figures: of the user's own, drawn of every run, besides those that ship.

    Raises:
        OutputError: if the folder exists or cannot be written, or a name cannot be a folder's name; nothing
            is left behind then.
    """
    if not runs:
        raise OutputError("a comparison needs at least one run, got none")
    with new_folder(folder) as aside:
        _records(runs, aside, apart=True)
        _draw(runs, aside, videos_follow, figures)
    return Path(folder)


def write_records(
    runs: Mapping[str, Run], folder: str | Path, beside: Mapping[str, Mapping[str, str]] | None = None
) -> Path:
    """Write one run or several into a new folder without figures and report, which `write_report` adds.

    Args:
        runs: by name; with several, each gets a subfolder of its name.
        folder: must not exist.
        beside: of a run, texts that lie beside its record, by the file's name.

    Raises:
        OutputError: if the folder exists or cannot be written, or a name cannot be a folder's name; nothing
            is left behind then.
    """
    with new_folder(folder) as aside:
        _records(runs, aside, apart=len(runs) > 1)
        for name, texts in (beside or {}).items():
            for file, text in texts.items():
                replace_text(home(aside, name) / file, text)
    return Path(folder)


def write_report(runs: Mapping[str, Run], folder: str | Path) -> Path:
    """Score and draw again what lies in `folder`, and write its report.

    Records and videos are left as they are.

    Args:
        runs: as `skylimb.analysis.recording.load_runs` gives them for this folder.
        folder: of a run or of a comparison; each file is replaced in one step.

    Returns:
        The report's path.

    Raises:
        OutputError: if the folder doesn't exist or cannot be written.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise OutputError(f"run folder '{folder}' does not exist")
    fresh = {name: replace(scored_again(run), name=name) for name, run in runs.items()}
    with writing(folder):
        for name, run in fresh.items():
            replace_text(home(folder, name) / METRICS_FILE, _metrics_json(run))
        if not (folder / LOG_FILE).is_file():
            replace_text(folder / TABLE_FILE, metrics_table(fresh))
        _draw(fresh, folder, False, ())
    return folder / REPORT_FILE


def home(folder: Path, name: str) -> Path:
    """Where a run's own files are: the folder itself, or its subfolder in that of a comparison."""
    return folder if (folder / LOG_FILE).is_file() else folder / name


def metrics_table(runs: Mapping[str, Run]) -> str:
    """The scores of several runs as CSV, one line a run.

    A field is empty where there is no number; a verdict is 1 or 0.
    """
    keys = [*NUMERIC_KEYS, *(key for key in scores_of(runs.values()) if key not in SCORES)]
    rows = [
        [name, run.controller, run.status, run.cause, *(_field(run.metrics.get(key)) for key in keys)]
        for name, run in runs.items()
    ]
    return csv_text([["run", "controller", "status", "cause", *keys], *rows])


def _field(value: float | None) -> str:
    """A number with all its digits; a verdict as 1 or 0."""
    return "" if value is None else repr(int(value) if isinstance(value, bool) else value)


def _records(runs: Mapping[str, Run], folder: Path, apart: bool) -> None:
    """Write record, scores and configuration of each run.

    Args:
        runs: by name.
        folder: of one run, or of a comparison.
        apart: whether each has a subfolder of its name, and the folder a table of all their scores.
    """
    for name, run in runs.items():
        bad = name in {"", FIGURES_FOLDER} or name.startswith(".") or any(mark in name for mark in _NO_NAME)
        if apart and bad:
            raise OutputError(f"run name '{name}' cannot be the name of a folder; rename the run")
        place, kept = (folder / name, run.with_sources_at("../")) if apart else (folder, run)
        place.mkdir(exist_ok=True)
        write_sources(run.sources, folder)
        kept.save(place / LOG_FILE)
        (place / METRICS_FILE).write_text(_metrics_json(kept), encoding="utf-8")
        (place / CONFIG_FILE).write_text(kept.config, encoding="utf-8")
    if apart:
        replace_text(folder / TABLE_FILE, metrics_table(runs))


def _draw(runs: Mapping[str, Run], folder: Path, videos_follow: bool, figures: Sequence[UserFigure]) -> None:
    """Draw the figures of all runs together, and put the report around them.

    Where the extra is not installed that draws, a warning says so: the flight and its scores are kept.
    """
    try:
        from skylimb.analysis.figures import report_figures
        from skylimb.analysis.report import report
    except ImportError as error:
        extra = of_an_extra(error)
        if extra is None:
            raise
        warnings.warn(f"no figures and no report: {extra}", UserWarning, stacklevel=2)
        return
    own = report_figures.user_figures(runs, figures)
    report_figures.write_figures(runs, folder / FIGURES_FOLDER, own)
    replace_text(folder / REPORT_FILE, report.render_report(runs, folder, videos_follow, own))


def _metrics_json(run: Run) -> str:
    return json.dumps(dict(run.metrics), indent=2, allow_nan=False) + "\n"
