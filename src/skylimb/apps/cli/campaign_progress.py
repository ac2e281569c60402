"""What all verbs that fly a campaign share: options, how far it is, and how to go on with it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg

if TYPE_CHECKING:
    from skylimb.studies.campaign import CampaignProgress

INTERRUPTED = 130

Workers = Annotated[
    int | None,
    arg("Processes on this machine (0: only this one), or jobs on SLURM; by default one a core, or 4.", "N"),
]
Resume = Annotated[bool, arg("Go on with a folder that is there; what it holds is not flown again.")]


@contextmanager
def campaign_progress() -> Iterator[Callable[[CampaignProgress], None]]:
    """A bar with rate, time left and failures so far."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn

    columns = (TextColumn("flights"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
    with output.bars(*columns) as bars:
        task = bars.add_task("")

        def report(now: CampaignProgress) -> None:
            rate = now.flown / now.seconds if now.seconds > 0.0 else 0.0
            words = "starting"
            if now.stopping:
                words = "stopping: finishing what flies (Ctrl-C again drops it)"
            elif rate > 0.0:
                words = f"{60.0 * rate:.0f} a minute, {_duration((now.total - now.done) / rate)} left"
            lost = "" if now.stopping else f", {now.failures} lost"
            bars.update(task, completed=now.done, total=now.total, description=words + lost)

        yield report


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {rest:02} s"


def interrupted(
    kept: int, total: int, folder: str, *command: str, **options: str | int | Sequence[str] | None
) -> int:
    """Say what is kept, and the command that goes on.

    Args:
        kept: flights.
        total: flights that were asked for.
        folder: where they are kept.
        command: the verb, and what it flies.
        options: of the verb by name, as they were given.
    """
    words = ["skylimb", *command, "--out", folder, "--resume"]
    for name, value in options.items():
        if value not in (None, "", ()):
            words += [f"--{name}", *([str(value)] if isinstance(value, str | int) else value or ())]
    print(f"interrupted: {kept} of {total} flights are kept in {folder}; to go on:")
    print(f"  {shlex.join(words)}")
    return INTERRUPTED
