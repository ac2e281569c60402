"""What a campaign prints: a bar while it flies, then its rates and medians."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from skylimb.apps.cli.output import console_for, plain_table

if TYPE_CHECKING:
    from skylimb.analysis.scores.axis_names import AxisNames
    from skylimb.analysis.scores.score import Score


@contextmanager
def campaign_bar() -> Iterator[Callable[[int, int, float, int, bool], None]]:
    """A bar for many flights; hands out what to call with (done, total, rate in 1/s, failures, stopping)."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
    from rich.progress import Progress as Bars

    columns = (TextColumn("flights"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
    console = console_for(stderr=True)
    with Bars(*columns, console=console, disable=not console.is_terminal, transient=True) as bars:
        task = bars.add_task("")

        def show(done: int, total: int, rate: float, failures: int, stopping: bool) -> None:
            words = [f"{60.0 * rate:.0f} a minute"] if rate > 0.0 else ["starting"]
            if rate > 0.0:
                words.append(f"{_duration((total - done) / rate)} left")
            words.append(f"{failures} lost")
            if stopping:
                words = ["stopping: finishing what flies (Ctrl-C again drops it)"]
            bars.update(task, completed=done, total=total, description=", ".join(words))

        yield show


def campaign(
    experiment: str,
    rates: Mapping[str, tuple[str, int]],
    medians: Mapping[str, Sequence[tuple[float, float, float]]],
    ranks: Mapping[str, Sequence[int]],
    axes: AxisNames,
    rate_called: str,
    declared: Mapping[str, Score],
) -> None:
    """Success rates and medians of a campaign's controllers, each with its rank among them."""
    from skylimb.analysis.scores.score import grouped

    apart = any(len(set(places)) > 1 for places in ranks.values())
    brackets = " (in brackets: rank; equal ranks are ties)" if apart else ""
    heading = f"{experiment}: medians over all draws, {axes}{brackets}"
    table = plain_table("", "", "")
    for name in rates:
        table.add_column(name, justify="right")

    def ranked(text: str, key: str, index: int) -> str:
        return f"{text} ({ranks[key][index]})" if len(set(ranks.get(key, ()))) > 1 else text

    shown = (ranked(text, "success", i) for i, (text, _) in enumerate(rates.values()))
    table.add_row(rate_called, "", *shown)
    for title, part in grouped(declared[key] for key in medians).items():
        table.add_section()
        table.add_row(f"[bold]{title}[/bold]")
        for score in part:
            cells = (_median(score, value) for value, _, _ in medians[score.name])
            shown = (ranked(text, score.name, i) for i, text in enumerate(cells))
            table.add_row(f"  {score.line(axes)}", score.unit, *shown)
    console = console_for()
    console.print(heading, style="bold", markup=False)  # a table would break it at its own width
    console.print(table)
    if len(rates) > 1 and not apart:
        console.print("These draws tell no two controllers apart; the report says more.")


def _median(score: Score, value: float) -> str:
    """The number; a dash for one that the controller does not have."""
    if math.isnan(value):
        return "-"
    return score.printed(value) if math.isfinite(value) else "lost"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {rest:02} s"
