"""Writes what a run or a comparison leaves: records, scores, figures, videos and the report."""

from __future__ import annotations

import csv
import io
import json
import logging
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from skylimb.analysis.figures import write_figures
from skylimb.analysis.metrics import NUMERIC_KEYS, metrics
from skylimb.analysis.report import render_report
from skylimb.analysis.video import write_video
from skylimb.errors import OutputError
from skylimb.recording import LOG_FILE, Run, new_folder

CONFIG_FILE = "config.toml"
METRICS_FILE = "metrics.json"
TABLE_FILE = "metrics.csv"
VIDEO_FILE = "video.mp4"
REPORT_FILE = "report.html"
FIGURES_FOLDER = "figures"

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Written:
    """What was written.

    Attributes:
        folder: where.
        warnings: what could not be made, one line each; each was logged as well.
    """

    folder: Path
    warnings: tuple[str, ...]


def write_run(run: Run, folder: str | Path, video: bool = True, report: bool = False) -> Written:
    """Write log.nc, metrics.json, config.toml, figures/ and video.mp4 into a new folder.

    The folder appears under its name when it is complete. A video that cannot be drawn is a warning, not an
    error. With `report` there is a report.html too.

    Raises:
        OutputError: if the folder exists or cannot be written; nothing is left behind then.
    """
    with new_folder(folder) as aside:
        warnings = _fill(run, aside, video)
        if report:
            _text(aside / REPORT_FILE, render_report({run.name: run}, aside))
    return Written(Path(folder), tuple(warnings))


def write_comparison(runs: Mapping[str, Run], folder: str | Path, video: bool = True) -> Written:
    """Write each run into a subfolder of its name, and metrics.csv, figures/ and report.html beside them.

    Args:
        runs: by name, which becomes a folder's name.
        folder: must not exist; it appears under its name when it is complete.
        video: whether to draw videos; one that cannot be drawn is a warning, not an error.

    Raises:
        OutputError: if the folder exists or cannot be written, or a name cannot be a folder's name; nothing
            is left behind then.
    """
    if not runs:
        raise OutputError("a comparison needs at least one run, got none")
    for name in runs:
        _require_folder_name(name)
    warnings: list[str] = []
    with new_folder(folder) as aside:
        for name, run in runs.items():
            (aside / name).mkdir()
            warnings += _fill(run, aside / name, video)
        _text(aside / TABLE_FILE, metrics_table(runs))
        write_figures(runs, aside / FIGURES_FOLDER)
        _text(aside / REPORT_FILE, render_report(runs, aside))
    return Written(Path(folder), tuple(dict.fromkeys(warnings)))


def write_report(runs: Mapping[str, Run], folder: str | Path) -> Path:
    """Score and draw again what lies in `folder`, and write its report.

    Records and videos are left as they are.

    Args:
        runs: as `skylimb.recording.load_runs` gives them for this folder.
        folder: of a run or of a comparison; each file is replaced in one step.

    Returns:
        The report's path.

    Raises:
        OutputError: if the folder doesn't exist or cannot be written.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise OutputError(f"run folder '{folder}' does not exist")
    fresh = {name: Run(name, run.controller, run.log, metrics(run.log)) for name, run in runs.items()}
    try:
        with tempfile.TemporaryDirectory(prefix=".report.", dir=folder) as temporary:
            aside = Path(temporary)
            places = {name: folder / name for name in fresh} if not (folder / LOG_FILE).is_file() else {}
            for name, run in fresh.items():
                home = aside / name if name in places else aside
                write_figures({name: run}, home / FIGURES_FOLDER)
                _text(home / METRICS_FILE, _metrics_json(run))
            if places:
                _text(aside / TABLE_FILE, metrics_table(fresh))
                write_figures(fresh, aside / FIGURES_FOLDER)
            for made in sorted(path for path in aside.rglob("*") if path.is_file()):
                target = folder / made.relative_to(aside)
                target.parent.mkdir(parents=True, exist_ok=True)
                os.replace(made, target)
            page = aside / REPORT_FILE
            _text(page, render_report(fresh, folder))
            os.replace(page, folder / REPORT_FILE)
    except OSError as error:
        raise OutputError(f"cannot write report in '{folder}': {error.strerror or error}") from error
    return folder / REPORT_FILE


def metrics_table(runs: Mapping[str, Run]) -> str:
    """The scores of several runs as CSV: one line a run, an empty field where there is no number."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["run", "controller", "status", "cause", *NUMERIC_KEYS])
    for name, run in runs.items():
        numbers = [run.metrics.get(key) for key in NUMERIC_KEYS]
        table.writerow(
            [name, run.controller, run.status, run.cause, *("" if n is None else repr(n) for n in numbers)]
        )
    return text.getvalue()


def _fill(run: Run, folder: Path, video: bool) -> list[str]:
    """Write one run's files, and return what could not be made."""
    run.save(folder / LOG_FILE)
    _text(folder / METRICS_FILE, _metrics_json(run))
    _text(folder / CONFIG_FILE, run.config)
    write_figures({run.name: run}, folder / FIGURES_FOLDER)
    if not video:
        return []
    try:
        write_video(run, folder / VIDEO_FILE)
    except OutputError as error:
        _log.warning("%s", error)
        return [str(error)]
    return []


def _metrics_json(run: Run) -> str:
    return json.dumps(dict(run.metrics), indent=2, allow_nan=False) + "\n"


def _require_folder_name(name: str) -> None:
    bad = name in {"", FIGURES_FOLDER} or name.startswith(".") or any(mark in name for mark in '/\\:*?"<>|\n')
    if bad:
        raise OutputError(f"run name '{name}' cannot be the name of a folder; rename the run")


def _text(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
