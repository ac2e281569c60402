"""The verbs for many flights: campaign, campaign report and tune."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from skylimb.apps.cli import campaign_output, output
from skylimb.apps.cli.arguments import Positional, arg
from skylimb.apps.cli.options import Calibration
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.studies.campaign import Outcome, Progress

INTERRUPTED = 130

Spec = Annotated[Positional[str], arg(metavar="SPEC", help="The campaign's TOML file.")]
Out = Annotated[
    str,
    arg(
        metavar="DIR",
        help="The campaign's folder; by default one below out/ named after SPEC.",
    ),
]
Workers = Annotated[
    str,
    arg(
        metavar="N",
        help="Processes on this machine (0: only this one), or jobs on SLURM; by default one a core, or 4.",
    ),
]
Resume = Annotated[bool, arg(help="Go on with a folder that is there; what it holds is not flown again.")]
Scheduler = Annotated[
    str,
    arg(metavar="ADDRESS", help="Fly on a Dask scheduler, such as tcp://HOST:8786."),
]
Slurm = Annotated[str, arg(metavar="QUEUE", help="Fly on a SLURM queue.")]


@dataclass(frozen=True)
class Campaign:
    """Fly many draws of an experiment with several controllers, and say who wins where.

    Leaves spec.toml, flights.parquet, summary.json, report.html and logs/. Ctrl-C finishes what flies and
    keeps it; --resume goes on, also after a crash. The exit code is 130 when it was interrupted.
    """

    examples: ClassVar[str] = """
        skylimb campaign examples/campaign.toml --out out/friction
        skylimb campaign examples/campaign.toml --out out/friction --resume
        skylimb campaign mine.toml --out out/mine --scheduler tcp://HOST:8786
        skylimb campaign report out/friction
    """

    spec: Spec
    calibration: Calibration = ""
    out: Out = ""
    workers: Workers = ""
    resume: Resume = False
    scheduler: Scheduler = ""
    slurm: Slurm = ""

    def __call__(self) -> int:
        """Fly, or go on flying."""
        workers, folder = whole_workers(self.workers), self.out or f"out/{Path(self.spec).stem}"
        from skylimb.studies.campaign import run_campaign
        from skylimb.studies.campaign.reading import load_spec

        spec = load_spec(self.spec)
        if self.calibration:
            spec = dataclasses.replace(spec, calibration=self.calibration)
        with campaign_progress() as report:
            outcome = run_campaign(
                spec,
                folder,
                workers=workers,
                resume=self.resume,
                scheduler=self.scheduler,
                slurm=self.slurm,
                progress=report,
            )
        if outcome.damaged:
            print(f"note: {outcome.damaged} damaged rows were found and flown again")
        if not outcome.complete:
            kept, total = len(outcome.rows), outcome.campaign.flight(outcome.campaign.spec.draws, 0)
            print(f"interrupted: {kept} of {total} flights are kept in {folder}; to go on:")
            options = {
                "calibration": self.calibration,
                "workers": self.workers,
                "scheduler": self.scheduler,
                "slurm": self.slurm,
            }
            print(f"  {_again('campaign', self.spec, folder, **options)}")
            return INTERRUPTED
        return _summary(outcome)


@dataclass(frozen=True)
class CampaignReport:
    """Work out a campaign's summary and report anew from its table, also while it flies."""

    examples: ClassVar[str] = "skylimb campaign report out/friction"

    folder: Annotated[Positional[str], arg(metavar="DIR", help="A campaign's folder.")]

    def __call__(self) -> int:
        """Write both."""
        from skylimb.studies.campaign import report_campaign
        from skylimb.studies.campaign.folder import load_campaign

        load_campaign(Path(self.folder))  # a folder that is none is refused before anything is said
        with output.working("working out the report"):
            outcome = report_campaign(self.folder)
        if outcome.damaged:
            print(
                f"note: {outcome.damaged} rows are damaged and left out; "
                "`skylimb campaign --resume` flies them again"
            )
        return _summary(outcome)


@dataclass(frozen=True)
class Tune:
    """Search gains over a campaign's draws, and judge them on draws that the search has not seen.

    Leaves a preset for each controller, ready for --controller, with verdict.json and trials.csv. Ctrl-C
    finishes what flies and keeps it; --resume goes on, and finds the same as without the interruption. Needs
    the extra `tune`.
    """

    examples: ClassVar[str] = """
        skylimb tune examples/tune.toml --out out/tuned
        skylimb tune examples/tune.toml --out out/tuned --resume
        skylimb run --controller out/tuned/hybrid.toml
    """

    spec: Spec
    out: Annotated[str, arg(metavar="DIR", help="Folder for the results; by default one below out/.")] = ""
    workers: Workers = ""
    resume: Resume = False

    def __call__(self) -> int:
        """Search, then judge."""
        workers, folder = whole_workers(self.workers), self.out or f"out/{Path(self.spec).stem}"
        from skylimb.studies.campaign import tune

        with campaign_progress() as report:
            outcome = tune(self.spec, folder, workers=workers, resume=self.resume, progress=report)
        if not outcome.complete:
            print(f"interrupted: {outcome.flown} of {outcome.total} flights are kept in {folder}; to go on:")
            print(f"  {_again('tune', self.spec, folder, workers=self.workers)}")
            return INTERRUPTED
        for line in outcome.lines():
            print(line)
        output.places(Path(folder))
        return 0


VERBS: dict[str, Any] = {"campaign": Campaign, "campaign report": CampaignReport, "tune": Tune}


def whole_workers(text: str) -> int | None:
    """The number that --workers gives; None where it was not given."""
    if not text:
        return None
    if not text.isdigit():
        raise ConfigError(f"--workers = '{text}' is not a whole number")
    return int(text)


def _again(verb: str, spec: str, folder: str, **options: str) -> str:
    """The command that goes on with what was interrupted."""
    words = ["skylimb", verb, spec, "--out", folder, "--resume"]
    for option, value in options.items():
        words += [f"--{option}", value] if value else []
    return " ".join(words)


def _summary(outcome: Outcome) -> int:
    """The success rates and ranks, a line a controller, and where the report is."""
    summary = outcome.summary
    if summary is not None:
        rates = {
            name: (f"{100 * rate.rate:.1f} % ({100 * rate.low:.1f} .. {100 * rate.high:.1f})", rate.draws)
            for name, rate in summary.rates.items()
        }
        campaign_output.campaign(
            outcome.campaign.spec.experiment,
            rates,
            summary.medians,
            summary.ranks,
            summary.axes,
            outcome.campaign.spec.called,
            summary.scores.declared,
        )
        for row in summary.lost[:5]:
            print(f"flight {row['flight']} ({row['controller']}) {row['status']}: {row['cause']}")
        if len(summary.lost) > 5:
            print(f"and {len(summary.lost) - 5} more lost flights")
        if summary.scores.refused:
            print(
                f"{len(summary.scores.refused)} draws that nobody can fly are left out; the report names them"
            )
    output.places(outcome.folder)
    return 0


@contextmanager
def campaign_progress() -> Iterator[Any]:
    """A bar with rate, time left and failures so far."""
    with campaign_output.campaign_bar() as show:

        def report(progress: Progress) -> None:
            rate = progress.flown / progress.seconds if progress.seconds > 0.0 else 0.0
            show(progress.done, progress.total, rate, progress.failures, progress.stopping)

        yield report
