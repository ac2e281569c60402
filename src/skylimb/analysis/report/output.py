"""Writes what a run or a comparison leaves: records, scores, figures and the report; see `videos` for videos.

A run's folder holds log.nc, metrics.json, config.toml, figures/ and report.html. A comparison's folder holds
a subfolder with the first three for each run, and metrics.csv, figures/ and report.html for all of them.
The record is written first. What comes after it may fail part by part: failed.txt names what did.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from skylimb.analysis.recording import LOG_FILE, Run, write_sources
from skylimb.analysis.recording.run import NOTES, lines_of_runs
from skylimb.analysis.report.attempts import Attempts, mark_failed
from skylimb.analysis.report.places import CONFIG_FILE, home
from skylimb.analysis.scores.declared import ATTRIBUTE as DECLARED
from skylimb.analysis.scores.declared import scores_of
from skylimb.analysis.scores.registry import NUMERIC_KEYS, SCORES
from skylimb.analysis.scores.user_scores import UserFigure
from skylimb.base.errors import OutputError, of_an_extra
from skylimb.base.files import csv_text, new_folder, replace_text, replacing

METRICS_FILE = "metrics.json"
TABLE_FILE = "metrics.csv"
REPORT_FILE = "report.html"
FIGURES_FOLDER = "figures"
_NO_NAME = '/\\:*?"<>|\n'
"""Letters that the name of a folder cannot have."""


def write_run(
    run: Run, folder: str | Path, videos_follow: bool = False, figures: Sequence[UserFigure] = ()
) -> Path:
    """Write a run into a new folder: its record first, then scores, figures and report.

    Args:
        run: what flew.
        folder: must not exist. It appears under its name with the record in it.
        videos_follow: whether the report leaves room for a video that is drawn next.
        figures: of the user's own, besides those that ship.

    Raises:
        OutputError: if the folder exists or the record cannot be written; nothing is left behind then. What
            fails after it is a warning, and stands in failed.txt.
    """
    return _write({run.name: run}, folder, False, videos_follow, figures)


def write_comparison(
    runs: Mapping[str, Run],
    folder: str | Path,
    videos_follow: bool = False,
    figures: Sequence[UserFigure] = (),
) -> Path:
    """Write a comparison into a new folder, as `write_run` does.

    Args:
        runs: by name, which becomes a folder's name.
        folder: must not exist.
        videos_follow: whether the report leaves room for videos that are drawn next.
        figures: of the user's own, drawn of every run, besides those that ship.

    Raises:
        OutputError: if the folder exists or a record cannot be written, or a name cannot be a folder's name;
            nothing is left behind then.
    """
    return _write(runs, folder, True, videos_follow, figures)


def _write(
    runs: Mapping[str, Run], folder: str | Path, apart: bool, videos: bool, figures: Sequence[UserFigure]
) -> Path:
    write_records(runs, folder, apart=apart)
    for line in write_report(runs, folder, figures, videos):
        warnings.warn(line, UserWarning, stacklevel=3)
    return Path(folder)


def write_records(
    runs: Mapping[str, Run],
    folder: str | Path,
    beside: Mapping[str, Mapping[str, str]] | None = None,
    apart: bool | None = None,
) -> Path:
    """Write the records of runs into a new folder, to which `write_scores` and `write_report` add the rest.

    Args:
        runs: by name.
        folder: must not exist.
        beside: of a run, texts that lie beside its record, by the file's name.
        apart: whether each has a subfolder of its name; by default where there are several.

    Raises:
        OutputError: if the folder exists or cannot be written, or a name cannot be a folder's name; nothing
            is left behind then.
    """
    if not runs:
        raise OutputError("a comparison needs at least one run, got none")
    with new_folder(folder) as aside:
        for name, run in runs.items():
            record(name, run, aside, len(runs) > 1 if apart is None else apart)
        for name, texts in (beside or {}).items():
            for file, text in texts.items():
                replace_text(home(aside, name) / file, text)
    return Path(folder)


def record(name: str, run: Run, folder: Path, apart: bool) -> None:
    """Write what was flown into a folder that is not complete yet: log, configuration, the user's files.

    Args:
        name: of the run among others.
        run: what flew.
        folder: of one run, or of a comparison.
        apart: whether it has a subfolder of its name.
    """
    if apart and (name in {"", FIGURES_FOLDER} or name.startswith(".") or set(name) & set(_NO_NAME)):
        raise OutputError(f"run name '{name}' cannot be the name of a folder; rename the run")
    place, kept = (folder / name, run.with_sources_at("../")) if apart else (folder, run)
    place.mkdir(exist_ok=True)
    write_sources(run.sources, folder)
    (place / LOG_FILE).write_bytes(kept.content())
    (place / CONFIG_FILE).write_text(kept.config, encoding="utf-8")


def write_scores(runs: Mapping[str, Run], folder: str | Path) -> tuple[str, ...]:
    """Write the scores of runs beside their records, and into them where they are others there.

    Args:
        runs: by name, scored.
        folder: that has their records; each file is replaced in one step.

    Returns:
        What could not be computed or written, one line each; failed.txt in the folder has them too.
    """
    return _after(runs, Path(folder), lambda parts: None)


def write_report(
    runs: Mapping[str, Run],
    folder: str | Path,
    figures: Sequence[UserFigure] = (),
    videos_follow: bool = False,
) -> tuple[str, ...]:
    """Write the scores of runs as `write_scores` does, draw their figures, and write the report.

    Args:
        runs: by name, scored.
        folder: that has their records; each file is replaced in one step.
        figures: of the user's own, besides those that ship.
        videos_follow: whether the report leaves room for videos that are drawn next.

    Returns:
        What could not be computed, drawn or written, one line each; failed.txt in the folder has them too.

    Raises:
        OutputError: if the folder doesn't exist.
    """
    folder = Path(folder)
    return _after(runs, folder, lambda parts: _draw(runs, folder, videos_follow, figures, parts))


def _after(runs: Mapping[str, Run], folder: Path, more: Callable[[Attempts], None]) -> tuple[str, ...]:
    """Write scores and what else follows from records, part by part."""
    if not folder.is_dir():
        raise OutputError(f"run folder '{folder}' does not exist")
    parts = Attempts()
    for name, run in runs.items():
        of = f" of '{name}'" if len(runs) > 1 else ""
        place = home(folder, name)
        with parts.part(f"{METRICS_FILE}{of}"):
            replace_text(place / METRICS_FILE, _metrics_json(run))
        with parts.part(f"scores in {LOG_FILE}{of}"):
            _into_record(run, place / LOG_FILE)
    if not (folder / LOG_FILE).is_file():
        with parts.part(TABLE_FILE):
            replace_text(folder / TABLE_FILE, metrics_table(runs))
    more(parts)
    problems = lines_of_runs({name: run.problems.values() for name, run in runs.items()})
    lines = (*problems, *parts.lines())
    with suppress(OSError):  # on a full disk they are said all the same
        mark_failed(folder, lines)
    return lines


def _into_record(run: Run, file: Path) -> None:
    """Put scores into a record that has others, or none."""
    known = Run.load(file)
    declared = run.log.attrs.get(DECLARED, "")
    if known.metrics == run.metrics and known.log.attrs.get(DECLARED, "") == declared:
        return
    log = known.log.assign_attrs({DECLARED: declared}) if declared else known.log
    with replacing(file) as aside:
        aside.write_bytes(replace(known, log=log, metrics=run.metrics).content())


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


def _draw(
    runs: Mapping[str, Run],
    folder: Path,
    videos_follow: bool,
    figures: Sequence[UserFigure],
    parts: Attempts,
) -> None:
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
    report_figures.write_figures(runs, folder / FIGURES_FOLDER, own, parts.part)
    with parts.part(REPORT_FILE):
        replace_text(folder / REPORT_FILE, report.render_report(runs, folder, videos_follow, own))


def _metrics_json(run: Run) -> str:
    notes = {NOTES: run.notes} if run.notes else {}
    return json.dumps({**run.metrics, **notes}, indent=2, allow_nan=False) + "\n"
