"""The verb that holds the paper against an ensemble."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.campaigns import INTERRUPTED, Resume, campaign_progress, whole_workers
from skylimb.apps.cli.options import whole_number
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.studies.reproduction import Result

MOST_DRAWS = 100_000


@dataclass(frozen=True)
class Reproduce:
    """Hold the paper's numbers and claims against an ensemble of what it leaves open.

    Draws friction, press, calibration and whatever else the paper doesn't print from a declared prior, flies
    the four controllers through every draw, and leaves reproduction.json, flights.parquet, figures/ and
    report.html. Ctrl-C finishes what flies and keeps it; --resume goes on. A lost flight is part of the
    result, not an error.
    """

    examples: ClassVar[str] = """
        skylimb reproduce --out out/reproduction
        skylimb reproduce --draws 20 --workers 2 --out out/short
        skylimb reproduce --out out/reproduction --resume
    """

    draws: Annotated[str, arg(metavar="N", help="Draws, each flown by all four; by default 200.")] = ""
    out: Annotated[
        str,
        arg(metavar="DIR", help="Folder for the results; by default out/reproduction."),
    ] = "out/reproduction"
    workers: Annotated[
        str,
        arg(metavar="N", help="Processes (0: only this one); by default one a core."),
    ] = ""
    resume: Resume = False

    def __call__(self) -> int:
        """Fly, judge, write."""
        workers = whole_workers(self.workers)
        draws = whole_number("--draws", self.draws)
        if draws is not None and not 2 <= draws <= MOST_DRAWS:
            raise ConfigError(f"--draws = {draws} must be 2 .. {MOST_DRAWS}")
        from skylimb.studies.reproduction.reproduce import DRAWS, reproduce

        with campaign_progress() as report:
            outcome = reproduce(
                self.out, draws or DRAWS, workers=workers, resume=self.resume, progress=report
            )
        if outcome.result is None:
            total = outcome.campaign.flight(outcome.campaign.spec.draws, 0)
            print(f"interrupted: {len(outcome.rows)} of {total} flights are kept in {self.out}; to go on:")
            print(f"  skylimb reproduce --draws {draws or DRAWS} --out {self.out} --resume")
            return INTERRUPTED
        _show(outcome.result)
        output.places(Path(self.out))
        return 0


def _show(result: Result) -> None:
    """The twelve numbers, the claims and the losses."""
    from skylimb.studies.reproduction.report import digits, rate_text, spread_text
    from skylimb.studies.reproduction.result import BESIDE, NUMBERS, label

    rows = []
    for key in (*NUMBERS, *BESIDE):
        for number in (n for n in result.numbers if n.key == key):
            printed = number.paper == number.paper
            rows.append(
                (
                    label(key),
                    number.controller,
                    f"{number.paper:.3f}" if printed else "-",
                    spread_text(number.ours, digits(key)),
                    f"{number.percentile:.0f} %{'' if number.inside else ' outside'}" if printed else "",
                )
            )
    lost = {name: sum(causes.values()) for name, causes in result.failures.items()}
    claims = [(j.claim.name, rate_text(j.rate), rate_text(j.finished)) for j in result.claims]
    output.reproduction(rows, claims)
    print(f"{result.inside} of 12 published numbers lie within the ensemble's 5 to 95 %")
    print("lost flights: " + ", ".join(f"{name} {count}" for name, count in lost.items()))
    if result.refused:
        print(f"{len(result.refused)} draws that nobody can fly count against every claim")


VERBS: dict[str, Any] = {"reproduce": Reproduce}
