"""Draws the videos of a folder that holds runs, several at a time, and puts them into its report.

A video takes longer than flight, figures and report together. So it comes last: the report can be read
before, and shows the videos when they are there.
"""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from skylimb.analysis.recording import LOG_FILE, Run
from skylimb.analysis.report.attempts import mark_more_failed
from skylimb.analysis.report.output import REPORT_FILE
from skylimb.analysis.report.places import VIDEO_FILE, home
from skylimb.analysis.report.report import render_report
from skylimb.analysis.report.video import film_record
from skylimb.base.errors import OutputError
from skylimb.base.files import replace_text, writing

Progress = Callable[[str, int, int], None]
"""Called with (name of the run, pictures done, pictures in all)."""

_log = logging.getLogger(__name__)


def write_videos(
    runs: Mapping[str, Run], folder: str | Path, progress: Progress | None = None
) -> tuple[str, ...]:
    """Draw video.mp4 beside the log of each run, as many at a time as there are cores, and renew the report.

    Args:
        runs: by name, as they were written into the folder.
        folder: of a run or of a comparison, with its report.
        progress: called with how far each video is.

    Returns:
        What could not be drawn, one line each; each was logged as well.

    Raises:
        OutputError: if the folder doesn't exist or cannot be written.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise OutputError(f"run folder '{folder}' does not exist")
    cores = os.cpu_count() or 1
    at_a_time = max(1, min(len(runs), cores))
    stopped = threading.Event()

    def draw(run: Run, place: Path) -> str:
        def report(done: int, total: int) -> None:
            if stopped.is_set():
                raise OutputError(f"no video of '{run.name}': interrupted")
            if progress is not None:
                progress(run.name, done, total)

        try:
            film_record(
                run, place / LOG_FILE, place / VIDEO_FILE, progress=report, threads=max(1, cores // at_a_time)
            )
        except OutputError as error:
            return str(error)
        return ""

    try:
        with ThreadPoolExecutor(at_a_time) as pool:
            try:
                waiting = [pool.submit(draw, run, home(folder, name)) for name, run in runs.items()]
                problems = tuple(problem for each in waiting if (problem := each.result()))
            except BaseException:
                stopped.set()
                pool.shutdown(cancel_futures=True)
                raise
    finally:
        with writing(folder):
            replace_text(folder / REPORT_FILE, render_report(runs, folder))
    with writing(folder):
        mark_more_failed(folder, problems)
    for problem in problems:
        _log.warning("%s", problem)
    return problems
