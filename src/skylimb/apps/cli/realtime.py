"""The verb that flies on the wall clock: `fly`."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import (
    Assignments,
    Calibration,
    Experiment,
    Out,
    Seed,
    new_folder,
    settings_of,
    stem,
    whole_number,
)
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.flight.guarded import ClockedFlight
    from skylimb.flight.realtime.timing import Timing
    from skylimb.flight.realtime.watchdog import Limits

TIMING_FILE = "timing.json"


@dataclass(frozen=True)
class Fly:
    """Fly on the wall clock, under the guard that flies a robot, and say how it kept to the clock.

    With --realtime the simulated plant stands in for the robot; with --udp a robot behind a socket flies,
    which --serve makes of the simulated plant. Ticks have absolute deadlines. A tick that begins when the
    next one is due holds its command; too many of them in a row, or measurements that are too old, and the
    robot retreats from the surface and descends. Leaves log.nc, config.toml and timing.json, and with
    --realtime what `run` leaves besides. The exit code is 1 for a flight that was lost or broken off.
    """

    examples: ClassVar[str] = """
        skylimb fly paper --controller hybrid --realtime
        skylimb fly free_flight --realtime --set controller_rate=400 --out out/fast
        skylimb fly paper --serve 127.0.0.1:9870            in one window
        skylimb fly paper --udp 127.0.0.1:9870              in another one
    """

    experiment: Experiment = "paper"
    controller: Annotated[
        str, arg(metavar="NAME", help="A controller's name, its TOML file, or a Python file.")
    ] = ""
    realtime: Annotated[bool, arg(help="Whether the simulated plant flies on the wall clock.")] = False
    udp: Annotated[
        str, arg(metavar="HOST:PORT", help="Where a robot listens that hovers and sends its state to us.")
    ] = ""
    listen: Annotated[
        str, arg(metavar="HOST:PORT", help="Where we listen for its state; any free port of this machine.")
    ] = "127.0.0.1:0"
    serve: Annotated[
        str, arg(metavar="HOST:PORT", help="Be the robot instead: the simulated plant listens here.")
    ] = ""
    anywhere: Annotated[bool, arg(help="Whether an address may be another machine's.")] = False
    overruns: Annotated[
        str, arg(metavar="N", help="Ticks in a row without a new command before the robot retreats; 100.")
    ] = ""
    calibration: Calibration = ""
    seed: Seed = ""
    set: Assignments = ()
    out: Out = ""

    def __call__(self) -> int:
        """Fly, measure the machine, record."""
        chosen = [name for name in ("realtime", "udp", "serve") if getattr(self, name)]
        if len(chosen) != 1:
            raise ConfigError("fly needs one of --realtime, --udp HOST:PORT and --serve HOST:PORT")
        settings, seed = settings_of(self.set), whole_number("--seed", self.seed)
        if seed is not None:
            settings["seed"] = seed
        if self.serve:
            return self._serve(settings)
        most = whole_number("--overruns", self.overruns)
        named = (stem(self.experiment), stem(self.controller), *chosen)
        folder = new_folder(self.out, "-".join(filter(None, named)))
        from skylimb.flight.realtime.timing import bare_timing
        from skylimb.flight.realtime.watchdog import Limits

        limits = Limits() if most is None else Limits(overruns=most)
        with output.flights() as progress:
            flown = self._flown(settings, limits, lambda done, total: progress("on the clock", done, total))
        bare = bare_timing(flown.timing.period, 400)
        with output.working("writing the results"):
            _write(flown, bare, folder, self.realtime)
        if self.realtime:
            output.scores({flown.run.name: flown.run})
        _show(flown.timing, bare)
        for name, count in flown.faults.items():
            print(f"note: {name}: {count} times")
        if flown.run.failed:
            print(f"{flown.run.name} FAILED: {flown.run.cause}")
        output.places(folder)
        return 1 if flown.run.failed else 0

    def _flown(
        self, settings: dict[str, Any], limits: Limits, report: Callable[[int, int], None]
    ) -> ClockedFlight:
        controller, known = self.controller or None, self.calibration or None
        if self.realtime:
            from skylimb.flight.on_clock import fly_on_clock

            return fly_on_clock(
                self.experiment, controller, set=settings, limits=limits, progress=report, calibration=known
            )
        from skylimb.flight.linked import fly_linked
        from skylimb.flight.realtime.udp import UdpLink, address_of

        peer = address_of(self.udp, self.anywhere)
        link = UdpLink(address_of(self.listen, self.anywhere), peer)
        try:
            return fly_linked(
                link, self.experiment, controller, settings, limits, progress=report, calibration=known
            )
        finally:
            link.close()

    def _serve(self, settings: dict[str, Any]) -> int:
        from skylimb.flight.realtime.udp import UdpLink, address_of
        from skylimb.flight.simulated_robot import serve_plant

        link = UdpLink(address_of(self.serve, self.anywhere))
        print(f"the plant of {self.experiment} listens on {self.serve}; Ctrl-C ends it", flush=True)
        try:
            ticks = serve_plant(link, self.experiment, settings)
        finally:
            link.close()
        print(f"flown for {ticks} ticks; then the commands stopped")
        return 0


def _write(flown: ClockedFlight, bare: Timing, folder: Path, whole: bool) -> None:
    """What `run` leaves, or of a robot its log, configuration and sources; and how it kept to the clock."""
    timing = flown.timing
    if whole:
        from skylimb.analysis import write_run

        write_run(flown.run, folder)
    else:
        from skylimb.analysis.recording import LOG_FILE, write_sources
        from skylimb.base.files import new_folder

        with new_folder(folder) as aside:
            write_sources(flown.run.sources, aside)
            flown.run.save(aside / LOG_FILE)
            (aside / "config.toml").write_text(flown.run.config, encoding="utf-8")
    told = {
        "verdict": timing.verdict(),
        "seconds": timing.quantiles(),
        "bare_timer_seconds": bare.quantiles(),
        "histogram": [
            {"bin": words, "jitter": late, "latency": latency} for words, late, latency in timing.histogram()
        ],
        "faults": dict(flown.faults),
    }
    (folder / TIMING_FILE).write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")


def _show(timing: Timing, bare: Timing) -> None:
    """Quantiles beside those of a timer with nothing to do, and the histogram."""
    from skylimb.flight.realtime.timing import QUANTILES

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
