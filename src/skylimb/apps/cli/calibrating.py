"""The verb that finds what a robot does not know of itself: `calibrate`."""

from __future__ import annotations

from typing import Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Out, Seed, Settings, new_folder, stem


def calibrate(
    what: Annotated[
        str, arg("An experiment to fly, or a run's folder, or a .nc, .bag or .mcap file.", "EXPERIMENT|LOG")
    ] = "calibration",
    *,
    seed: Seed = None,
    set: Settings = None,
    out: Out = "",
) -> None:
    """Find from a flight how the robot and its sensors differ from their description.

    Flies an experiment, or takes the log of a flight that was flown, and estimates the motion capture's
    misalignment, the centre of gravity, the thrust of each rotor, lag and latency, each with a 95 % interval.
    Leaves calibration.toml, which --calibration of other verbs takes, report.html, and the log of its flight.

    Examples:
        skylimb calibrate --out out/calibration
        skylimb calibrate --set 'plant.cog_offset=[0.01, 0, 0.005]' --seed 3
        skylimb calibrate out/paper-following/log.nc
    """
    folder = new_folder(out, f"{stem(what.rstrip('/').split('/')[-1])}-calibrated")
    from skylimb.studies.calibration.public import calibration_from, flight_of, is_log, robot_of
    from skylimb.studies.calibration.report import rows_of, write_calibration

    with output.flights() as progress:
        flown = flight_of(what, seed, set, progress)
    with output.working("estimating"):
        made = calibration_from(flown, robot_of(flown))
    with output.working("writing the report"):
        write_calibration(made, folder, None if is_log(what) else flown)
    known = made.truth is not None
    columns = ("", "Value", "95 % interval", "Believed before", "Shown", "Truth", "Error / std")
    rows = [
        (row.label, row.value, row.interval, row.prior, "yes" if row.shown else "no", row.truth, row.error)
        for row in rows_of(made)
    ]
    last = 7 if known else 5
    output.show_table([row[:last] for row in rows], *columns[:last])
    print(made.verdict)
    output.notes(flown.notes)
    output.places(folder)
