"""What the verbs print: progress while there is somebody to watch, then tables and where to look."""

from __future__ import annotations

import functools
import logging
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress as Bars
    from rich.progress import ProgressColumn

    from skylimb.analysis.recording.run import Run
    from skylimb.analysis.scores.axis_names import AxisNames
    from skylimb.analysis.scores.score import Score
    from skylimb.analysis.scores.user_scores import UserFigure

_PIPE_WIDTH = 140
"""Columns when the output is not a terminal, so that no table is cut."""

Progress = Callable[[str, int, int], None]


def console_for(stderr: bool = False) -> Console:
    """Where to print; a pipe gets a width at which no table is cut."""
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    return Console(file=stream, width=None if stream.isatty() else _PIPE_WIDTH, highlight=False)


def show_table(
    rows: Iterable[Sequence[str] | None], *columns: str, title: str = "", justify: str = "", heading: str = ""
) -> None:
    """Print a table in the one look of the command line.

    Args:
        rows: cells, in rich's markup; None draws a line.
        columns: their headings; without them the table has none.
        title: above it, wrapped at the table's width.
        justify: a letter for each of the first columns, "l" or "r"; the last letter holds for all after it.
        heading: above it, not wrapped.
    """
    from rich.box import SIMPLE_HEAD
    from rich.markup import escape
    from rich.table import Table

    rows = list(rows)
    table = Table(title=escape(title) or None, title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    table.show_header = bool(columns)
    sides = justify or "l"
    for k in range(max(len(columns), *(len(row or ()) for row in rows))):
        side = sides[min(k, len(sides) - 1)]
        table.add_column(columns[k] if columns else "", justify="right" if side == "r" else "left")
    if not columns:
        table.columns[0].style, table.columns[0].no_wrap = "cyan", True
    for row in rows:
        table.add_section() if row is None else table.add_row(*row)
    console = console_for()
    if heading:
        console.print(heading, style="bold", markup=False)
    console.print(table)


def score_table(
    heading: str,
    columns: Sequence[str],
    first: Sequence[str],
    groups: Mapping[str, Iterable[Score]],
    axes: AxisNames,
    cells: Callable[[Score], Iterable[str]],
) -> None:
    """Print scores by group.

    Args:
        heading: above the table.
        columns: what has scores: runs, or controllers.
        first: the row above the scores.
        groups: scores by the title of their group.
        axes: names of the directions.
        cells: the score of each column as a text.
    """
    rows: list[Sequence[str] | None] = [first]
    for title, part in groups.items():
        rows += [None, (f"[bold]{title}[/bold]",)]
        rows += [(f"  {score.line(axes)}", score.unit, *cells(score)) for score in part]
    show_table(rows, "", "", *columns, justify="llr", heading=heading)


def notes(lines: Iterable[str]) -> None:
    """Say what is to be known of a log or a flight, a line each."""
    for line in lines:
        print(f"note: {line}")


def faults(counts: Mapping[str, int]) -> None:
    """Say what was met in a flight on a clock, and how often."""
    notes(f"{name}: {count} times" for name, count in counts.items())


@contextmanager
def bars(*columns: ProgressColumn) -> Iterator[Bars]:
    """Bars on the error stream, while it is a terminal."""
    from rich.progress import Progress as Bars

    console = console_for(stderr=True)
    with Bars(*columns, console=console, disable=not console.is_terminal, transient=True) as shown:
        yield shown


@contextmanager
def flights(at_once: bool = False) -> Iterator[Progress]:
    """A bar per flight; hands out the function that flights report to.

    Args:
        at_once: whether what a flight has to say is said while it flies, as its pilot has to know; else it
            follows at the end.
    """
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn

    said: list[str] = []
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with (
        bars(*columns) as shown,
        _heard("skylimb.flight", functools.partial(_note, shown.console) if at_once else said.append),
        _heard("skylimb.control.planning", functools.partial(_note, shown.console)),
    ):
        tasks: dict[str, Any] = {}

        def report(name: str, done: int, total: int) -> None:
            if name not in tasks:
                tasks[name] = shown.add_task(name, total=total)
            shown.update(tasks[name], completed=done)

        yield report
    for note in said:
        _note(shown.console, note)


def _note(console: Console, text: str) -> None:
    console.print(text, markup=False, soft_wrap=True)


@contextmanager
def _heard(name: str, hear: Callable[[str], object]) -> Iterator[None]:
    """Hand on what the modules of a package have to say."""
    handler = logging.Handler()
    handler.emit = lambda record: hear(record.getMessage())  # type: ignore[method-assign]
    logger = logging.getLogger(name)
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)


@contextmanager
def working(what: str) -> Iterator[None]:
    """A sign of life during work of unknown length."""
    console = console_for(stderr=True)
    if not console.is_terminal:
        print(f"{what} ...", file=sys.stderr)
        yield
        return
    with console.status(what):
        yield


def scores(runs: Mapping[str, Run]) -> None:
    """The metrics of every run side by side, the paper's numbers in brackets where it prints them."""
    from skylimb.analysis.paper.configuration import is_the_papers, not_the_papers
    from skylimb.analysis.paper.numbers import published_beside
    from skylimb.analysis.scores.axis_names import common_names
    from skylimb.analysis.scores.declared import shown_scores

    def cells(score: Score) -> Iterator[str]:
        for run in runs.values():
            known = score.printed(published_beside(run, score.name))
            shown = score.printed(run.metrics.get(score.name)) or "-"
            yield f"{shown} ({known})" if known else shown

    experiment = next(iter(runs.values())).log.attrs.get("experiment", "")
    brackets = ", in brackets the paper's numbers" if any(map(is_the_papers, runs.values())) else ""
    axes = common_names(run.log for run in runs.values())
    heading = f"{experiment}: sliding period, {axes}{brackets}"
    first = ("Status", "", *map(status, runs.values()))
    score_table(heading, list(runs), first, shown_scores(runs.values()), axes, cells)
    verdicts(runs)
    otherwise = not_the_papers(runs)
    if otherwise:
        print("The paper's numbers stand only beside flights of its configuration. Flown otherwise:")
        for line in otherwise:
            print(f"  {line}")


def status(run: Run) -> str:
    """What became of a run, red where it failed."""
    return f"[red]{run.status}[/red]" if run.failed else run.status


def verdicts(runs: Mapping[str, Run]) -> None:
    """Why runs failed, or what was not done as commanded."""
    for name, run in runs.items():
        if run.failed:
            print(f"{name} {run.verdict}")
        elif run.stopped:
            print(f"{name} {run.cause}; scored as far as it flew")
        elif run.missed:
            print(f"{name} was not done as commanded:", *run.missed, sep="\n  - ")


def written(
    runs: Mapping[str, Run], folder: Path, figures: Sequence[UserFigure] = (), video: bool = False
) -> tuple[str, ...]:
    """Write scores, figures and report beside the records of runs; what could not be made, a line each."""
    from skylimb.analysis import write_report

    try:
        with working("writing scores, figures and report"):
            return write_report(runs, folder, figures, videos_follow=video)
    except KeyboardInterrupt as stop:
        stop.add_note(f"what was flown is kept in '{folder}'; `{_score(folder)}` makes the rest")
        raise


def _score(folder: Path) -> str:
    """What makes the scores of a folder, to be pasted into a shell."""
    return shlex.join(("skylimb", "score", str(folder)))


def hand_over(runs: Mapping[str, Run], folder: Path, video: bool = False, failed: Sequence[str] = ()) -> int:
    """Say what to know of the runs and where they lie, then draw their videos.

    Args:
        runs: by name.
        folder: that has them.
        video: whether to draw their videos.
        failed: what could not be made so far, a line each.

    Returns:
        The exit code: 1 when a flight was lost, or something could not be made.
    """
    from skylimb.analysis.recording.run import lines_of_runs

    notes(lines_of_runs({name: run.notes for name, run in runs.items()}))
    for line in failed:
        print(line)
    if failed:
        print(f"the rest is there; `{_score(folder)}` makes what failed anew, with metrics of --use FILE")
    places(folder)
    problems = _draw_videos(runs, folder) if video else ()
    return int(bool(failed) or bool(problems) or any(run.failed for run in runs.values()))


def places(folder: Path, *patterns: str) -> None:
    """Where the results lie, the page to read first in front."""
    for pattern in patterns or ("report.html", "contact.html", "video.mp4", "*/video.mp4", "figures"):
        if any(folder.glob(pattern)):
            print(f"  {folder / pattern}", flush=True)


def _draw_videos(runs: Mapping[str, Run], folder: Path) -> tuple[str, ...]:
    """Draw the videos of a folder with a bar each; say where they lie, and what could not be drawn."""
    from skylimb.analysis import write_videos

    count = f"{len(runs)} videos" if len(runs) > 1 else "the video"
    print(f"drawing {count}; the report is ready, and shows them when they are there", flush=True)
    with flights() as progress:
        problems = write_videos(runs, folder, progress)
    for problem in problems:
        print(f"failed: {problem}")
    places(folder, "video.mp4", "*/video.mp4")
    return problems
