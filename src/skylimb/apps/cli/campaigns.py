"""The verbs for many flights: `campaign`, `campaign report` and `tune`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.campaign_progress import Resume, Workers, campaign_progress, interrupted
from skylimb.apps.cli.options import Calibration

if TYPE_CHECKING:
    from skylimb.studies.campaign import Outcome


Spec = Annotated[str, arg("The campaign's TOML file.", "SPEC")]
Out = Annotated[str, arg("Folder for the results; by default one below out/ named after SPEC.", "DIR")]
Scheduler = Annotated[str, arg("Fly on a Dask scheduler, such as tcp://HOST:8786.", "ADDRESS")]
Slurm = Annotated[str, arg("Fly on a SLURM queue.", "QUEUE")]


def campaign(
    spec: Spec,
    *,
    calibration: Calibration = None,
    out: Out = "",
    workers: Workers = None,
    resume: Resume = False,
    scheduler: Scheduler = "",
    slurm: Slurm = "",
) -> int:
    """Fly many draws of an experiment with several controllers, and say who wins where.

    Leaves spec.toml, flights.parquet, summary.json, report.html and logs/. Ctrl-C finishes what flies and
    keeps it; --resume goes on, also after a crash. The exit code is 130 when it was interrupted.

    Examples:
        skylimb campaign examples/campaign.toml --out out/friction
        skylimb campaign examples/campaign.toml --out out/friction --resume
        skylimb campaign mine.toml --out out/mine --scheduler tcp://HOST:8786
        skylimb campaign report out/friction
    """
    import skylimb

    folder = out or f"out/{Path(spec).stem}"
    with campaign_progress() as report:
        outcome = skylimb.campaign(
            spec, folder, calibration=calibration, workers=workers, resume=resume, scheduler=scheduler,
            slurm=slurm, progress=report,
        )  # fmt: skip
    if outcome.damaged:
        print("note: some of what was kept was damaged; those flights were flown again")
    if outcome.complete:
        return _summary(outcome)
    total = outcome.campaign.flight(outcome.campaign.spec.draws, 0)
    again = {"calibration": calibration, "workers": workers, "scheduler": scheduler, "slurm": slurm}
    return interrupted(len(outcome.rows), total, folder, "campaign", spec, **again)


def campaign_report(folder: Annotated[str, arg("A campaign's folder.", "DIR")]) -> int:
    """Work out a campaign's summary and report anew from its table, also while it flies.

    Examples:
        skylimb campaign report out/friction
    """
    from skylimb.studies.campaign import report_campaign
    from skylimb.studies.campaign.folder import load_campaign

    load_campaign(Path(folder))  # a folder that is none is refused before anything is said
    with output.working("working out the report"):
        outcome = report_campaign(folder)
    if outcome.damaged:
        print("note: damaged flights are left out; `skylimb campaign --resume` flies them again")
    return _summary(outcome)


def tune(
    spec: Spec,
    *,
    out: Out = "",
    workers: Workers = None,
    resume: Resume = False,
) -> int:
    """Search gains over a campaign's draws, and judge them on draws that the search has not seen.

    Leaves a preset for each controller, ready for --controller, with verdict.json and trials.csv. Ctrl-C
    finishes what flies and keeps it; --resume goes on, and finds the same as without the interruption. Needs
    the extra `tune`.

    Examples:
        skylimb tune examples/tune.toml --out out/tuned
        skylimb tune examples/tune.toml --out out/tuned --resume
        skylimb run --controller out/tuned/hybrid.toml
    """
    from skylimb.studies import campaign as campaigns

    folder = out or f"out/{Path(spec).stem}"
    with campaign_progress() as report:
        outcome = campaigns.tune(spec, folder, workers=workers, resume=resume, progress=report)
    if not outcome.complete:
        return interrupted(outcome.flown, outcome.total, folder, "tune", spec, workers=workers)
    for line in outcome.lines():
        print(line)
    output.places(Path(folder))
    return 0


def _summary(outcome: Outcome) -> int:
    """The success rates and ranks, a column a controller, and where the report is."""
    from skylimb.studies.campaign.rows import unscored

    summary = outcome.summary
    if summary is not None:
        _show_medians(outcome)
        for row in summary.lost[:5]:
            print(f"flight {row['flight']} ({row['controller']}) {row['status']}: {row['cause']}")
        if len(summary.lost) > 5:
            print(f"and {len(summary.lost) - 5} more lost flights")
        if failing := unscored(outcome.rows.values()):
            print(failing)
        if summary.scores.refused:
            print(
                f"{len(summary.scores.refused)} draws that not every controller can fly are left out; "
                "the report names them"
            )
    output.places(outcome.folder)
    return 0


def _show_medians(outcome: Outcome) -> None:
    """Success rates and medians of the controllers, each with its rank among them."""
    from skylimb.analysis.scores.score import grouped
    from skylimb.studies.campaign.report import medians_of, missing_flights, rates_of

    summary, spec = outcome.summary, outcome.campaign.spec
    assert summary is not None
    declared, rates = summary.scores.declared, rates_of(summary)
    apart = any(len(frozenset(places)) > 1 for places in summary.ranks.values())
    brackets = " (in brackets: rank; equal ranks are ties)" if apart else ""

    def ranked(text: str, rank: int) -> str:
        return f"{text} ({rank})" if rank else text

    draws = len(summary.scores.draws)
    missing = missing_flights(outcome.campaign, len(outcome.rows))
    shares = [f"{one.value} ({one.interval})" if one.interval else one.value for one in rates]

    output.score_table(
        f"{spec.experiment}: medians over {draws} draw{'s' * (draws != 1)}{missing and f' ({missing})'}, "
        f"{summary.axes}{brackets}",
        list(summary.rates),
        (spec.called, "", *(ranked(share, one.rank) for share, one in zip(shares, rates, strict=True))),
        grouped(declared[key] for key in summary.medians),
        summary.axes,
        lambda score: [ranked(one.value, one.rank) for one in medians_of(score, summary)],
    )
    if len(rates) > 1 and not apart:
        print("These draws tell no two controllers apart; the report says more.")
