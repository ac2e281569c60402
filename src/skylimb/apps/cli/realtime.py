"""The verb that flies on the wall clock: `fly`."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import (
    Calibration,
    Controller,
    Experiment,
    Fence,
    Out,
    Seed,
    Settings,
    new_folder,
    stem,
)
from skylimb.base.aside import said_aside
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.analysis.exchange.recorder import FlightRecorder
    from skylimb.flight.realtime.clocked_flight import ClockedFlight
    from skylimb.flight.realtime.timing import Timing


def fly(
    experiment: Experiment = "paper",
    *,
    controller: Controller = None,
    realtime: Annotated[bool, arg("Whether the simulated plant flies on the wall clock.")] = False,
    udp: Annotated[
        str, arg("Where a robot listens that hovers and sends its state to us.", "HOST:PORT")
    ] = "",
    listen: Annotated[
        str, arg("Where we listen for its state; any free port of this machine.", "HOST:PORT")
    ] = "127.0.0.1:0",
    serve: Annotated[str, arg("Be the robot instead: the simulated plant listens here.", "HOST:PORT")] = "",
    anywhere: Annotated[bool, arg("Whether an address may be another machine's.")] = False,
    fence: Fence = None,
    check: Annotated[bool, arg("Look at the robot of --udp, and command nothing.")] = False,
    overruns: Annotated[
        int | None, arg("Ticks in a row without a new command before the robot retreats; 100.", "N")
    ] = None,
    calibration: Calibration = None,
    seed: Seed = None,
    set: Settings = None,
    out: Out = "",
) -> int:
    """Fly on the wall clock, under the guard that flies a robot, and say how it kept to the clock.

    With --realtime the simulated plant stands in for the robot; with --udp a robot behind a socket flies,
    which --serve makes of the simulated plant. Ticks have absolute deadlines. A tick that begins when the
    next one is due holds its command; too many of them in a row, or measurements that are too old, and the
    robot retreats from the surface and descends. Before a robot is flown it is looked at: attitude, motion,
    age and clock of its state, battery, disk, calibration and mass; --check does only that. Leaves log.nc,
    config.toml and timing.json, and with --realtime what `run` leaves besides; a process that is killed
    leaves what it flew for `skylimb runs --clean`. The exit code is 1 for a flight that was lost or broken
    off, and for a check that fails.

    Examples:
        skylimb fly paper --controller hybrid --realtime
        skylimb fly free_flight --realtime --set controller_rate=400 --out out/fast
        skylimb fly paper --serve 127.0.0.1:9870            in one window
        skylimb fly paper --udp 127.0.0.1:9870              in another one
        skylimb fly paper --udp 127.0.0.1:9870 --check      only looks, before it
    """
    ways = {"realtime": realtime, "udp": udp, "serve": serve}
    chosen = [name for name, given in ways.items() if given]
    if len(chosen) != 1:
        raise ConfigError("fly needs one of --realtime, --udp HOST:PORT and --serve HOST:PORT")
    if (check or fence is not None) and not udp:
        raise ConfigError("--check and --fence are for a robot: they need --udp HOST:PORT")
    from skylimb.flight.realtime.preflight import StartLimits, fence_of

    start = StartLimits() if fence is None else StartLimits(fence=fence_of(fence))
    settings = (set or {}) | ({} if seed is None else {"seed": seed})
    from skylimb.flight.realtime.udp import UdpLink, address_of

    if serve:
        from skylimb.flight.realtime.simulated_robot import serve_plant

        with closing(UdpLink(address_of(serve, anywhere))) as link:
            print(f"the plant of {experiment} listens on {serve}; Ctrl-C ends it", flush=True)
            ticks = serve_plant(link, experiment, settings)
        print(f"flown for {ticks} ticks; then the commands stopped")
        return 0
    if check:
        from skylimb.flight.realtime.fly_robot import check_robot

        with closing(UdpLink(address_of(listen, anywhere), address_of(udp, anywhere, peer=True))) as link:
            found = check_robot(link, experiment, settings, calibration=calibration, start=start)
        print(*(one.line for one in found), sep="\n")
        return 0 if all(one.fine for one in found) else 1
    folder = new_folder(out, "-".join(filter(None, (stem(experiment), stem(controller or ""), *chosen))))
    if overruns is not None:
        settings = {**settings, "supervisor.overruns": overruns}
    from skylimb.analysis.exchange.recorder import recording

    def flown(recorder: FlightRecorder | None) -> ClockedFlight:
        with output.flights(at_once=True) as progress:

            def report(done: int, total: int) -> None:
                progress("on the clock", done, total)

            if realtime:
                from skylimb.flight.realtime.fly_on_clock import fly_on_clock

                return fly_on_clock(
                    experiment, controller, set=settings, progress=report,
                    calibration=calibration, recorder=recorder,
                )  # fmt: skip
            from skylimb.flight.realtime.fly_robot import fly_robot

            with closing(UdpLink(address_of(listen, anywhere), address_of(udp, anywhere, peer=True))) as link:
                return fly_robot(
                    link, experiment, controller, settings, progress=report,
                    calibration=calibration, recorder=recorder, start=start,
                )  # fmt: skip

    # Also what is said after it: a terminal that has gone costs no flight that was flown.
    with said_aside(patience=None), recording(folder) as recorder:
        return _hand_over(flown(recorder), folder, realtime)


def _hand_over(flown: ClockedFlight, folder: Path, scored: bool) -> int:
    """Measure the machine's own timer, write the results and show them."""
    from skylimb.flight.realtime.timing import bare_timing

    run, bare = flown.run, bare_timing(flown.timing.period, 400)
    runs = {run.name: run}
    with output.working("writing the log"):
        _write(flown, bare, folder)
    failed = output.written(runs, folder) if scored else ()
    if scored:
        output.scores(runs)
    _show(flown.timing, bare)
    output.faults(flown.faults)
    if run.failed and not scored:
        print(f"{run.name} FAILED: {run.cause}")
    return output.hand_over(runs, folder, failed=failed)


def _write(flown: ClockedFlight, bare: Timing, folder: Path) -> None:
    """Log, configuration and sources; and how the flight kept to the clock."""
    from skylimb.analysis.report.output import write_records
    from skylimb.flight.realtime.timing import TIMING_FILE

    bins = [
        {"bin": words, "jitter": late, "latency": latency}
        for words, late, latency in flown.timing.histogram()
    ]
    told = flown.timing.record(flown.faults, bare_timer_seconds=bare.quantiles(), histogram=bins)
    write_records({flown.run.name: flown.run}, folder, {flown.run.name: {TIMING_FILE: told}})


def _show(timing: Timing, bare: Timing) -> None:
    """Quantiles beside those of a timer with nothing to do, and the histogram."""
    from skylimb.flight.realtime.timing import QUANTILES

    rows = [
        (words, *(f"{1e3 * value:.3f}" for value in known.values()))
        for words, known in (
            ("jitter: how late a tick began", timing.quantiles().get("jitter", {})),
            ("jitter of a bare timer", bare.quantiles()["jitter"]),
            ("latency: from due to command", timing.quantiles().get("latency", {})),
        )
    ]
    output.show_table(rows, "", *(label for label, _ in QUANTILES), title="On the wall clock (ms)")
    ticks = [
        (words, str(late), str(latency)) for words, late, latency in timing.histogram() if late or latency
    ]
    output.show_table(ticks, "Ticks", "began so late", "had their command after")
    print(timing.verdict())
