"""The call that users make: from a manoeuvre or a log to what the robot does not know of itself."""

from __future__ import annotations

import dataclasses
import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.containers import ENDINGS
from skylimb.analysis.exchange.convert import read_log
from skylimb.analysis.recording.origin import TABLE
from skylimb.analysis.recording.run import LOG_FILE, NOTES, Run
from skylimb.base.errors import ConfigError, OutputError
from skylimb.base.plugins import added_names
from skylimb.flight.experiments.experiment import Experiment, experiment_names
from skylimb.flight.public import Progress, run
from skylimb.flight.replay.replay import experiment_of
from skylimb.robots.description import GRAVITY
from skylimb.robots.loader import load_robot
from skylimb.robots.model import Robot
from skylimb.studies.calibration.estimate import estimate
from skylimb.studies.calibration.excited import require_excited
from skylimb.studies.calibration.record import record_of
from skylimb.studies.calibration.result import Calibration, calibration_of

USUAL = "calibration"
"""The experiment that ships for it."""


def calibrate(
    what: str | Path | Experiment | Run = USUAL,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> Calibration:
    """Find out what a robot and its sensors differ in from their description.

    Args:
        what: an experiment (a name, a TOML file, or one at hand), which is flown with the controller that it
            brings along; or a flight that was flown: a `Run`, a .nc, .bag or .mcap file, or the folder that
            holds its log.nc.
        seed: of the sensors' noise; the experiment's own when None.
        set: dotted keys of the experiment and new values.
        progress: called with how far the flight is.

    Returns:
        Values with their 95 % intervals, residuals, and the truth beside them where it is known.

    Raises:
        SkylimbError: when the flight cannot be flown, was lost, touched something, or says nothing; nothing
            is written.
    """
    flown = flight_of(what, seed, set, progress)
    return calibration_from(flown, robot_of(flown))


def flight_of(
    what: str | Path | Experiment | Run,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> Run:
    """The flight that a calibration is made of; arguments are those of `calibrate`."""
    if isinstance(what, Run) or is_log(what):
        if seed is not None or set:
            raise ConfigError("a flight that was flown has its seed and its settings already")
        return what if isinstance(what, Run) else _loaded(Path(str(what)))
    return run(what if isinstance(what, Experiment) else str(what), seed=seed, set=set, progress=progress)


def _loaded(path: Path) -> Run:
    if path.is_dir() and not (path / LOG_FILE).is_file():
        raise OutputError(f"folder '{path}' holds no {LOG_FILE}; name a log, or the folder of one flight")
    read = read_log(path)
    said = json.dumps([*read.run.notes, *read.notes])
    return dataclasses.replace(read.run, log=read.run.log.assign_attrs({NOTES: said}))


def is_log(what: Any) -> bool:
    """Whether this names a log, a folder, which is to have one, or a place that is no experiment's file."""
    if isinstance(what, Experiment):
        return False
    path = Path(what)
    if path.suffix in ENDINGS or (path / LOG_FILE).is_file():
        return True
    # A folder may be called like an experiment.
    known = (*experiment_names(), *added_names("experiments"))
    return (path.exists() or path.name != str(what)) and path.suffix != ".toml" and str(what) not in known


def robot_of(flown: Run) -> Robot:
    """The robot of a flight, as it is described.

    Raises:
        SkylimbError: when the log does not say, or there is no such robot.
    """
    config = flown.tables
    name = str(config.get("robot") or flown.log.attrs.get("robot", ""))
    if not name:
        raise ConfigError(f"the log of '{flown.name}' does not say of which robot it is")
    # Flights of before gravity was a key were planned with the standard one.
    gravity = float(config.get("gravity", GRAVITY))
    if name not in flown.sources:
        if name in config.get(TABLE, {}).get("files", {}):
            raise ConfigError(
                f"the log of '{flown.name}' comes without its robot's files, {Path(name).parent}; name the "
                "folder of the flight, which has them beside its log"
            )
        return load_robot(name, gravity)
    # A robot of the user's own, as its files were when it flew.
    with tempfile.TemporaryDirectory() as folder:
        experiment, _ = experiment_of(flown, Path(folder), {})
        return load_robot(experiment.robot, gravity)


def calibration_from(flown: Run, robot: Robot) -> Calibration:
    """The calibration of one flight; `calibrate` says more."""
    record = record_of(flown, robot)
    require_excited(record)
    return calibration_of(flown, record, estimate(record))
