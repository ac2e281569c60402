"""The verb that finds what a robot does not know of itself: `calibrate`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import Positional, arg
from skylimb.apps.cli.options import Assignments, Out, Seed, new_folder, settings_of, stem, whole_number


@dataclass(frozen=True)
class Calibrate:
    """Find what robot and sensors differ in from their description, from a flight.

    Flies an experiment, or takes the log of a flight that was flown, and estimates the motion capture's
    misalignment, the centre of gravity, the thrust of each rotor, lag and latency, each with a 95 % interval.
    Leaves calibration.toml, which --calibration of other verbs takes, report.html, and the log of its flight.
    """

    examples: ClassVar[str] = """
        skylimb calibrate --out out/calibration
        skylimb calibrate --set 'plant.cog_offset=[0.01, 0, 0.005]' --seed 3
        skylimb calibrate out/paper-following/log.nc
    """

    what: Annotated[
        Positional[str],
        arg(metavar="EXPERIMENT|LOG", help="An experiment to fly, or a log.nc or the folder that holds one."),
    ] = "calibration"
    seed: Seed = ""
    set: Assignments = ()
    out: Out = ""

    def __call__(self) -> int:
        """Fly or read, estimate, write."""
        settings, seed = settings_of(self.set), whole_number("--seed", self.seed)
        folder = new_folder(self.out, f"{stem(self.what.rstrip('/').split('/')[-1])}-calibrated")
        from skylimb.studies.calibration.excited import motion_of
        from skylimb.studies.calibration.public import calibration_from, flight_of, is_log, robot_of
        from skylimb.studies.calibration.record import record_of
        from skylimb.studies.calibration.report import write_calibration

        with output.flights() as progress:
            flown = flight_of(self.what, seed, settings, progress)
        robot = robot_of(flown)
        with output.working("estimating"):
            made = calibration_from(flown, robot)
        with output.working("writing the report"):
            kept = None if is_log(self.what) else flown
            write_calibration(made, folder, motion_of(record_of(flown, robot)), kept)
        output.calibration(made)
        output.places(folder)
        return 0
