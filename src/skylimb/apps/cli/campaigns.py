"""The verbs for many flights: `campaign`, `campaign report`, `tune`, `reproduce` and `faults`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Calibration, within

if TYPE_CHECKING:
    from skylimb.studies.campaign import CampaignProgress, Outcome
    from skylimb.studies.reproduction import Result

INTERRUPTED = 130

Spec = Annotated[str, arg("The campaign's TOML file.", "SPEC")]
Out = Annotated[str, arg("Folder for the results; by default one below out/ named after SPEC.", "DIR")]
Workers = Annotated[
    int | None,
    arg("Processes on this machine (0: only this one), or jobs on SLURM; by default one a core, or 4.", "N"),
]
Resume = Annotated[bool, arg("Go on with a folder that is there; what it holds is not flown again.")]
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
    with _progress() as report:
        outcome = skylimb.campaign(
            spec, folder, calibration=calibration, workers=workers, resume=resume, scheduler=scheduler,
            slurm=slurm, progress=report,
        )  # fmt: skip
    if outcome.damaged:
        print(f"note: {outcome.damaged} damaged rows were found and flown again")
    if outcome.complete:
        return _summary(outcome)
    total = outcome.campaign.flight(outcome.campaign.spec.draws, 0)
    again = {"calibration": calibration, "workers": workers, "scheduler": scheduler, "slurm": slurm}
    return _interrupted(len(outcome.rows), total, folder, f"campaign {spec}", **again)


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
        print(
            f"note: {outcome.damaged} rows are damaged and left out; "
            "`skylimb campaign --resume` flies them again"
        )
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
    with _progress() as report:
        outcome = campaigns.tune(spec, folder, workers=workers, resume=resume, progress=report)
    if not outcome.complete:
        return _interrupted(outcome.flown, outcome.total, folder, f"tune {spec}", workers=workers)
    for line in outcome.lines():
        print(line)
    output.places(Path(folder))
    return 0


def reproduce(
    *,
    draws: Annotated[int | None, arg("Draws, each flown by all four; by default 200.", "N")] = None,
    out: Annotated[str, arg("Folder for the results.", "DIR")] = "out/reproduction",
    workers: Annotated[int | None, arg("Processes (0: only this one); by default one a core.", "N")] = None,
    resume: Resume = False,
) -> int:
    """Hold the paper's numbers and claims against an ensemble of what it leaves open.

    Draws friction, press, calibration and whatever else the paper doesn't print from a declared prior, flies
    the four controllers through every draw, and leaves reproduction.json, flights.parquet, figures/ and
    report.html. Ctrl-C finishes what flies and keeps it; --resume goes on. A lost flight is part of the
    result, not an error.

    Examples:
        skylimb reproduce --out out/reproduction
        skylimb reproduce --draws 20 --workers 2 --out out/short
        skylimb reproduce --out out/reproduction --resume
    """
    if draws is not None:
        within("--draws", draws, 2, 100_000)
    from skylimb.studies import reproduction
    from skylimb.studies.reproduction.reproduce import DRAWS

    with _progress() as report:
        outcome = reproduction.reproduce(out, draws or DRAWS, workers=workers, resume=resume, progress=report)
    if outcome.result is None:
        total = outcome.campaign.flight(outcome.campaign.spec.draws, 0)
        return _interrupted(len(outcome.rows), total, out, f"reproduce --draws {draws or DRAWS}")
    _show_reproduction(outcome.result)
    output.places(Path(out))
    return 0


def faults(
    *,
    controllers: Annotated[
        tuple[str, ...], arg("Presets, TOML files or Python files; by default the catalogue's.", "NAME ...")
    ] = (),
    only: Annotated[tuple[str, ...], arg("Faults to fly, by name; all by default.", "FAULT ...")] = (),
    catalogue: Annotated[str, arg("Another catalogue than the one that ships.", "FILE")] = "",
    draws: Annotated[int, arg("Draws of each fault that each controller flies.", "N")] = 200,
    out: Annotated[str, arg("Folder for the results.", "DIR")] = "out/faults",
    workers: Workers = None,
    resume: Resume = False,
) -> int:
    """Fly a catalogue of faults, and say what survives within which bounds.

    Each fault is a campaign: rotors that fail, joints, motion capture, pushes, a board that is gone, commands
    that come too late. Leaves faults.json, faults.md, and the campaigns' folders, each with a report in which
    the worst flight can be watched. Ctrl-C finishes what flies and keeps it; --resume goes on.

    Examples:
        skylimb faults --draws 20 --out out/faults
        skylimb faults --only "rotor at half" "push of 4 N" --draws 4
        skylimb faults --controllers hybrid mine.toml
    """
    from skylimb.studies.faults import fly_faults, load_catalogue

    within("--draws", draws, 1, 1_000_000)
    chosen = load_catalogue(catalogue) if catalogue else None
    with _progress() as report:
        outcome = fly_faults(
            out, draws, controllers=controllers, only=only, catalogue=chosen, workers=workers, resume=resume,
            progress=report,
        )  # fmt: skip
    if not outcome.complete:
        print(f"interrupted; what was flown is kept in {out}; the same command with --resume goes on")
        return INTERRUPTED
    known = {fault.name: fault for fault in outcome.catalogue.faults}
    rows = [
        (row.fault, row.flown_by, *row.shares, "yes" if row.reached(known[row.fault]) else "no")
        for row in outcome.rows
    ]
    output.show_table(rows, "Fault", "Flown by", "Survived", "Within its bounds", "All kept")
    output.places(Path(out))
    return 0


def _interrupted(kept: int, total: int, folder: str, command: str, **options: str | int | None) -> int:
    """Say what is kept, and the command that goes on."""
    words = [f"  skylimb {command} --out {folder} --resume"]
    words += [f"--{name} {value}" for name, value in options.items() if value not in (None, "")]
    print(f"interrupted: {kept} of {total} flights are kept in {folder}; to go on:")
    print(" ".join(words))
    return INTERRUPTED


def _summary(outcome: Outcome) -> int:
    """The success rates and ranks, a column a controller, and where the report is."""
    summary = outcome.summary
    if summary is not None:
        _show_medians(outcome)
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


def _show_medians(outcome: Outcome) -> None:
    """Success rates and medians of the controllers, each with its rank among them."""
    from skylimb.analysis.scores.score import grouped
    from skylimb.studies.campaign.report import medians_of, rates_of

    summary, spec = outcome.summary, outcome.campaign.spec
    assert summary is not None
    declared, rates = summary.scores.declared, rates_of(summary)
    apart = any(len(frozenset(places)) > 1 for places in summary.ranks.values())
    brackets = " (in brackets: rank; equal ranks are ties)" if apart else ""

    def ranked(text: str, rank: int) -> str:
        return f"{text} ({rank})" if rank else text

    shares = [f"{one.value} ({one.interval})" if one.interval else one.value for one in rates]

    output.score_table(
        f"{spec.experiment}: medians over all draws, {summary.axes}{brackets}",
        list(summary.rates),
        (spec.called, "", *(ranked(share, one.rank) for share, one in zip(shares, rates, strict=True))),
        grouped(declared[key] for key in summary.medians),
        summary.axes,
        lambda score: [ranked(one.value, one.rank) for one in medians_of(score, summary)],
    )
    if len(rates) > 1 and not apart:
        print("These draws tell no two controllers apart; the report says more.")


def _show_reproduction(result: Result) -> None:
    """The twelve numbers, the claims and the losses."""
    from skylimb.studies.reproduction.report import digits, rate_text, spread_text
    from skylimb.studies.reproduction.result import BESIDE, NUMBERS, label

    columns = ("Number", "Controller", "Paper", "Ensemble: median (5 to 95 %)", "Paper's percentile")
    rows = [
        (
            label(key),
            number.controller,
            f"{number.paper:.3f}" if not math.isnan(number.paper) else "-",
            spread_text(number.ours, digits(key)),
            ""
            if math.isnan(number.paper)
            else f"{number.percentile:.0f} %{'' if number.inside else ' outside'}",
        )
        for key in (*NUMBERS, *BESIDE)
        for number in result.numbers
        if number.key == key
    ]
    output.show_table(rows, *columns)
    claims = [(one.claim.name, rate_text(one.rate), rate_text(one.finished)) for one in result.claims]
    output.show_table(claims, "Claim", "Holds in (95 % interval)", "Without loss")
    lost = {name: sum(causes.values()) for name, causes in result.failures.items()}
    print(f"{result.inside} of 12 published numbers lie within the ensemble's 5 to 95 %")
    print("lost flights: " + ", ".join(f"{name} {count}" for name, count in lost.items()))
    if result.refused:
        print(f"{len(result.refused)} draws that nobody can fly count against every claim")


@contextmanager
def _progress() -> Iterator[Callable[[CampaignProgress], None]]:
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
