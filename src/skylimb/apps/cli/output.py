"""What the verbs print: progress while there is somebody to watch, then a table and where to look."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from skylimb.analysis.recording.run import Run
    from skylimb.analysis.scores.score import Score
    from skylimb.robots.model import Robot
    from skylimb.studies.calibration.result import Calibration
    from skylimb.studies.verification import Row

_PIPE_WIDTH = 140
"""Columns when the output is not a terminal, so that no table is cut."""

Progress = Callable[[str, int, int], None]


def console_for(stderr: bool = False) -> Console:
    """Where to print; a pipe gets a width at which no table is cut."""
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    return Console(file=stream, width=None if stream.isatty() else _PIPE_WIDTH, highlight=False)


def plain_table(title: str = "", *columns: str) -> Table:
    """A table in the one look of the command line; without columns it has no heading."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(*columns, title=title or None, title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    table.show_header = bool(columns)
    return table


def names(title: str, descriptions: Mapping[str, str]) -> None:
    """Names with their one line each."""
    from rich.markup import escape

    table = plain_table(escape(title))
    table.add_column(style="cyan", no_wrap=True)
    table.add_column()
    for name, description in descriptions.items():
        table.add_row(name, description)
    console_for().print(table)


def keys(rows: Sequence[Sequence[str]]) -> None:
    """Keys with default, unit, range, meaning and what has them; a pipe gets a line each, parted by tabs."""
    if not sys.stdout.isatty():
        for row in rows:
            print("\t".join(row))
        return
    from rich.padding import Padding
    from rich.text import Text

    console = console_for()
    for key, default, unit, allowed, meaning, of in rows:
        value = " ".join(filter(None, (default, unit)))
        console.print(Text.assemble((key, "cyan"), f" = {value}" if value != "-" else ""))
        details = "; ".join(filter(None, (meaning, allowed, f"of {of}")))
        console.print(Padding(Text(details, "dim"), (0, 0, 0, 4)))


def toml(text: str) -> None:
    """A TOML text; coloured for a terminal, otherwise untouched."""
    if not sys.stdout.isatty():
        print(text, end="")
        return
    from rich.syntax import Syntax

    console_for().print(Syntax(text.rstrip(), "toml", background_color="default", word_wrap=True))


def robot(robot: Robot) -> None:
    """A robot's figures."""
    description = robot.description
    table = plain_table(robot.name)
    table.add_column(style="cyan", no_wrap=True)
    table.add_column()
    table.add_row("mass", f"{robot.mass:.4f} kg in {len(robot.bodies)} moving bodies")
    limits = {joint.name: joint for joint in description.joints}
    for name in description.shape_joints:
        joint = limits[name]
        table.add_row(
            name, f"{joint.lower:.2f} .. {joint.upper:.2f} rad, {joint.speed:g} rad/s, {joint.effort:g} N m"
        )
    for rotor in description.rotors:
        spin = "+z" if rotor.spin > 0 else "-z"
        table.add_row(rotor.name, f"{rotor.thrust_min:g} .. {rotor.thrust_max:g} N, turns about {spin}")
    tip = ", ".join(f"{value:g}" for value in description.tip.position)
    table.add_row("tip", f"({tip}) m on {description.tip.link}, radius {1e3 * description.tip.radius:g} mm")
    console_for().print(table)


def drawing(title: str, rows: Sequence[tuple[str, str]]) -> None:
    """How well a drawing came out."""
    from rich.markup import escape

    table = plain_table(escape(title))
    table.add_column()
    table.add_column(justify="right")
    for row in rows:
        table.add_row(*row)
    console_for().print(table)


def calibration(made: Calibration) -> None:
    """What a calibration found, entry by entry, and its verdict."""
    from skylimb.studies.calibration.report import rows_of

    columns = ["", "Value", "95 % interval", "Believed before", "Shown"]
    table = plain_table("", *columns, *(["Truth", "Error / std"] if made.truth is not None else []))
    for row in rows_of(made):
        cells = [row.label, row.value, row.interval, row.prior, "yes" if row.shown else "no"]
        table.add_row(*cells, *([row.truth, row.error] if made.truth is not None else []))
    console = console_for()
    console.print(table)
    console.print(made.verdict, markup=False, soft_wrap=True)


@contextmanager
def flights() -> Iterator[Progress]:
    """A bar per flight; hands out the function that flights report to."""
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    console = console_for(stderr=True)
    said: list[str] = []
    with (
        _heard("skylimb.flight", said.append),
        _heard("skylimb.control.planning", lambda note: console.print(note, markup=False, soft_wrap=True)),
        Bars(*columns, console=console, disable=not console.is_terminal, transient=True) as bars,
    ):
        tasks: dict[str, Any] = {}

        def report(name: str, done: int, total: int) -> None:
            if name not in tasks:
                tasks[name] = bars.add_task(name, total=total)
            bars.update(tasks[name], completed=done)

        yield report
    for note in said:
        console.print(note, markup=False, soft_wrap=True)


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


def reproduction(numbers: Sequence[Sequence[str]], claims: Sequence[Sequence[str]]) -> None:
    """The paper's numbers beside an ensemble's, and in how many draws each claim holds."""
    console = console_for()
    table = plain_table(
        "", "Number", "Controller", "Paper", "Ensemble: median (5 to 95 %)", "Paper's percentile"
    )
    for row in numbers:
        table.add_row(*row)
    console.print(table)
    table = plain_table("", "Claim", "Holds in (95 % interval)", "Without loss")
    for row in claims:
        table.add_row(*row)
    console.print(table)


@contextmanager
def claims() -> Iterator[Callable[[int, int, str], None]]:
    """One bar for the claims of the contact's verification; hands out the function that they report to."""
    with flights() as report:
        yield lambda done, total, name: report("verifying", done, total)


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
    from skylimb.analysis.paper.paper_configuration import is_the_papers, not_the_papers
    from skylimb.analysis.scores.axis_names import common_names
    from skylimb.analysis.scores.declared import shown_scores

    experiment = next(iter(runs.values())).log.attrs.get("experiment", "")
    brackets = ", in brackets the paper's numbers" if any(map(is_the_papers, runs.values())) else ""
    axes = common_names(run.log for run in runs.values())
    heading = f"{experiment}: sliding period, {axes}{brackets}"
    table = plain_table("", "", "")
    for name in runs:
        table.add_column(name, justify="right")
    table.add_row("Status", "", *(_status(run) for run in runs.values()))
    for title, part in shown_scores(runs.values()).items():
        table.add_section()
        table.add_row(f"[bold]{title}[/bold]")
        for score in part:
            table.add_row(f"  {score.line(axes)}", score.unit, *(_cell(run, score) for run in runs.values()))
    console = console_for()
    console.print(heading, style="bold", markup=False)  # a table would break it at its own width
    console.print(table)
    for name, run in runs.items():
        if run.failed:
            console.print(f"{name} FAILED: {run.cause}")
        elif run.missed:
            console.print(f"{name} was not done as commanded: {'; '.join(run.missed)}")
    otherwise = not_the_papers(runs)
    if otherwise:
        console.print("The paper's numbers stand only beside flights of its configuration. Flown otherwise:")
        for line in otherwise:
            console.print(f"  {line}", markup=False)


def _status(run: Run) -> str:
    return f"[red]{run.status}[/red]" if run.failed else run.status


def _cell(run: Run, score: Score) -> str:
    from skylimb.analysis.paper.paper_numbers import published_beside

    known = score.printed(published_beside(run, score.name))
    shown = score.printed(run.metrics.get(score.name)) or "-"
    return f"{shown} ({known})" if known else shown


def notes(runs: Mapping[str, Run]) -> None:
    """What has changed since the run that is repeated, and what cannot be repeated."""
    for line in dict.fromkeys(line for run in runs.values() for line in run.notes):
        print(f"note: {line}")


def places(folder: Path) -> None:
    """Where the results lie, the page to read first in front."""
    for pattern in ("report.html", "contact.html", "video.mp4", "*/video.mp4", "figures"):
        if any(folder.glob(pattern)):
            print(f"  {folder / pattern}", flush=True)


def videos(runs: Mapping[str, Run], folder: Path) -> None:
    """Draw the videos of a folder with a bar each; say where they lie, and what could not be drawn."""
    from skylimb.analysis import write_videos

    count = f"{len(runs)} videos" if len(runs) > 1 else "the video"
    print(f"drawing {count}; the report is ready, and shows them when they are there", flush=True)
    with flights() as progress:
        problems = write_videos(runs, folder, progress)
    for problem in problems:
        print(f"note: {problem}")
    for pattern in ("video.mp4", "*/video.mp4"):
        if any(folder.glob(pattern)):
            print(f"  {folder / pattern}")


def verification(rows: Sequence[Row]) -> int:
    """The table of the contact's verification; 1 when a claim fails."""
    table = plain_table("", "Claim", "Measured", "Theory", "Tolerance", "Cases", "")
    for row in rows:
        bound = {"below": "at most ", "above": "at least "}.get(row.bound, "")
        verdict = "holds" if row.passed else "[red]FAILS[/red]"
        table.add_row(
            row.claim,
            f"{row.measured:.5g} {row.unit}",
            f"{bound}{row.theory:.5g}",
            f"{row.tolerance:g}",
            str(row.cases),
            verdict,
        )
    console = console_for()
    console.print(table)
    console.print(f"{sum(row.passed for row in rows)} of {len(rows)} claims hold")
    return 0 if all(row.passed for row in rows) else 1
