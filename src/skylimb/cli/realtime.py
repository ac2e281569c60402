"""The verb that flies on the wall clock: `fly`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from skylimb.cli import output
from skylimb.cli.arguments import arg
from skylimb.cli.options import (
    Assignments,
    Experiment,
    Out,
    Seed,
    new_folder,
    settings_of,
    stem,
    whole_number,
)
from skylimb.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.realtime.timing import Timing

TIMING_FILE = "timing.json"


@dataclass(frozen=True)
class Fly:
    """Fly on the wall clock, under the guard that flies a robot, and say how it kept to the clock.

    With --realtime the simulated plant stands in for the robot. Ticks have absolute deadlines. A tick that
    begins when the next one is due holds its command; too many of them in a row, or measurements that are too
    old, and the robot retreats from the surface and descends. Leaves what `run` leaves, and timing.json. The
    exit code is 1 for a lost flight.
    """

    examples: ClassVar[str] = """
        skylimb fly paper --controller hybrid --realtime
        skylimb fly free_flight --realtime --set controller_rate=400 --out out/fast
    """

    experiment: Experiment = "paper"
    controller: Annotated[
        str, arg(metavar="NAME", help="A controller's name, its TOML file, or a Python file.")
    ] = ""
    realtime: Annotated[bool, arg(help="Whether the simulated plant flies on the wall clock.")] = False
    overruns: Annotated[
        str, arg(metavar="N", help="Ticks in a row without a new command before the robot retreats; 100.")
    ] = ""
    seed: Seed = ""
    set: Assignments = ()
    out: Out = ""

    def __call__(self) -> int:
        """Measure the machine, fly, record."""
        if not self.realtime:
            raise ConfigError("fly needs --realtime: on the wall clock only the simulated plant flies so far")
        settings, seed = settings_of(self.set), whole_number("--seed", self.seed)
        most = whole_number("--overruns", self.overruns)
        named = (stem(self.experiment), stem(self.controller), "realtime")
        folder = new_folder(self.out, "-".join(filter(None, named)))
        from skylimb.flights.on_clock import fly_on_clock
        from skylimb.realtime.timing import bare_timing
        from skylimb.realtime.watchdog import Limits

        limits = Limits() if most is None else Limits(overruns=most)
        with output.flights() as progress:
            flown = fly_on_clock(
                self.experiment,
                self.controller or None,
                seed,
                settings,
                limits,
                progress=lambda done, total: progress("on the clock", done, total),
            )
        bare = bare_timing(flown.timing.period, 400)
        with output.working("writing log, figures and report"):
            from skylimb.analysis import write_run

            write_run(flown.run, folder)
            _write(flown.timing, bare, flown.faults, folder)
        output.scores({flown.run.name: flown.run})
        _show(flown.timing, bare)
        for name, count in flown.faults.items():
            print(f"note: {name}: {count} times")
        output.places(folder)
        return 1 if flown.run.failed else 0


def _write(timing: Timing, bare: Timing, faults: object, folder: Path) -> None:
    told = {
        "verdict": timing.verdict(),
        "seconds": timing.quantiles(),
        "bare_timer_seconds": bare.quantiles(),
        "histogram": [
            {"bin": words, "jitter": late, "latency": latency} for words, late, latency in timing.histogram()
        ],
        "faults": faults,
    }
    (folder / TIMING_FILE).write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")


def _show(timing: Timing, bare: Timing) -> None:
    """Quantiles beside those of a timer with nothing to do, and the histogram."""
    from skylimb.realtime.timing import QUANTILES

    console = output.console_for()
    table = output.plain_table("On the wall clock (ms)", "", *(label for label, _ in QUANTILES))
    for words, known in (
        ("jitter: how late a tick began", timing.quantiles().get("jitter", {})),
        ("jitter of a bare timer", bare.quantiles()["jitter"]),
        ("latency: from due to command", timing.quantiles().get("latency", {})),
    ):
        table.add_row(words, *(f"{1e3 * value:.3f}" for value in known.values()))
    console.print(table)
    table = output.plain_table("", "Ticks", "began so late", "had their command after")
    for words, late, latency in timing.histogram():
        if late or latency:
            table.add_row(words, str(late), str(latency))
    console.print(table)
    console.print(timing.verdict())
