"""`skylimb.replay`: a log in, the same flight as the estimator and the controller see it out."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from skylimb.analysis.exchange.convert import read_log
from skylimb.analysis.notebook_run import Run
from skylimb.analysis.recording.log import log_variable
from skylimb.analysis.recording.origin import TABLE
from skylimb.analysis.recording.run import OK
from skylimb.analysis.recording.run import Run as Record
from skylimb.analysis.report.controller_replay import REPLAYED
from skylimb.base.errors import ConfigError, SkylimbError
from skylimb.base.packing import Layout
from skylimb.base.signals import Signal
from skylimb.control.controller import (
    Controller,
    controller_signals,
    is_traceable,
)
from skylimb.control.corrections import Calibrated
from skylimb.control.loop.flight import MISSION_TIME
from skylimb.control.missions.clock import Clock
from skylimb.control.missions.mission import Mission
from skylimb.control.needs import needs_of
from skylimb.control.planning.posture import standing
from skylimb.control.supervisor.suited_gains import RETURNED, suited_gains
from skylimb.control.supervisor.supervised import BITS, LATENESS, SLOWNESS, bit_of
from skylimb.flight.events import GainChange
from skylimb.flight.events.gain import gain_rows
from skylimb.flight.experiments.experiment import Experiment, load_experiment
from skylimb.flight.flight_run import FLAGS, documented
from skylimb.flight.loading import chosen_controller, parted, plan_of
from skylimb.flight.plan import FlightPlan, mission_of
from skylimb.flight.replay.doubts import doubts
from skylimb.flight.replay.mission_of_log import mission_of_log
from skylimb.flight.replay.open_loop import Progress, open_loop
from skylimb.flight.replay.recorded import Recorded, recorded, sampled
from skylimb.flight.replay.whole_reference import recorded_ahead, whole_mission
from skylimb.robots.model import Robot

UNKNOWN = "free_flight"
"""The experiment whose robot and rates a log is replayed with that does not say what flew."""

_KEPT = ("truth", "measurement", "reference")
"""Kinds of signals that a replay takes over from the log."""

_SAME_PATH = 1e-6
"""Metres by which a mission that is planned anew may be off the recorded one."""


def replay(
    log: str | Path | Record,
    controller: str | Controller | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    calibration: Calibrated | None = None,
) -> Run:
    """Run estimator and controller open loop on what a log holds of a flight, simulated or real.

    With the configuration that flew, the recorded estimates and commands come out again to the bit. With
    another one the run has what would have been estimated and commanded; truth and measurements stay those of
    the flight. The estimator works with the thrusts that were flown, whatever the controller would have
    commanded. Nothing is simulated.

    Args:
        log: a run, its folder, or a file: .nc, .bag or .mcap.
        controller: another one than flew: a name, a file, or a controller at hand.
        set: dotted keys and new values, of the experiment, or of the controller after "controller.".
        progress: called with (ticks done, ticks in all).
        calibration: what the controller knows of robot and sensors besides their description; by default
            what the one that flew knew.

    Returns:
        A run without scores; `analysis.replayed.differences` holds it against the recorded one. What the log
        lacks and what stands in its place is among its `notes`.

    Raises:
        SkylimbError: when the log cannot be read, or holds no pose of the robot.
    """
    settings, gains = parted(set or {})
    run, read = (log, ()) if isinstance(log, Record) else read_log(log, str(settings.get("robot", "")))
    with tempfile.TemporaryDirectory(prefix="skylimb-") as folder, naming_its_files(Path(folder)):
        try:
            experiment, said = experiment_of(run, Path(folder), settings)
            plan = plan_of(experiment, controller, gains, calibration)
        except ConfigError as error:
            raise _lacking(run) or error from None
        return _replayed(run, experiment, plan.robot, plan.controller, (*read, *said), progress)


def _replayed(
    run: Record,
    experiment: Experiment,
    robot: Robot,
    controller: Controller,
    said: tuple[str, ...],
    progress: Progress | None,
) -> Run:
    period, purpose = experiment.control_period, _flown_vectoring(run, experiment, robot, controller)
    log, resampled = sampled(run.log, period)
    held = recorded(log, robot, period, purpose)
    mission, planned, ahead = whole_mission(log, period), (), None
    if mission is None:
        mission, planned = _mission(run, log, held, experiment, robot, purpose)
    else:  # a row a tick, whatever clock its mission had
        ticks = np.arange(float(len(held)))
        clock = Clock(ticks, np.ones(len(held)))
        missing = tuple(line for line in held.missing if MISSION_TIME not in line)
        held = replace(held, clock=clock, missing=missing)
        wanted = len(needs_of(controller).preview)
        ahead = recorded_ahead(log, wanted)
        if wanted and ahead is None:
            planned = ("no references ahead as this controller wants them: those of later ticks",)
    changing, dropped = _gains(experiment, controller, log)
    values = open_loop(controller, held, mission, period, changing, progress, ahead)
    notes = (*said, *resampled, *held.missing, *doubts(held, robot), *planned, *dropped, *_broken_off(log))
    known = controller_signals(controller)
    said_of_it = {"controller": controller.name, "status": OK, "cause": "", REPLAYED: run.name}
    made = Run(
        name=f"{controller.name}, replayed",
        controller=controller.name,
        log=_log(log, values, known).assign_attrs(said_of_it),
    )
    return documented(made, FlightPlan(experiment, robot, controller), notes)


def experiment_of(
    run: Record, folder: Path, settings: Mapping[str, Any]
) -> tuple[Experiment, tuple[str, ...]]:
    """The experiment that a run was flown with, read from copies of its files below `folder`."""
    if not run.tables:
        experiment = load_experiment(UNKNOWN, dict(settings))
        said = f"no configuration: robot {experiment.robot}, {experiment.controller_rate:g} Hz (see --set)"
        return experiment, (said,)
    # A comparison's runs name their copies "../sources/...": those stay below the folder as well.
    home = folder / "comparison" / "run"
    home.mkdir(parents=True)
    for name, content in run.sources.items():
        path = home / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    (home / "config.toml").write_text(run.config, encoding="utf-8")
    experiment = load_experiment(str(home / "config.toml"), dict(settings))
    return experiment, tuple(experiment.recorded.get("changes", ()))


@contextmanager
def naming_its_files(folder: Path) -> Iterator[None]:
    """Errors inside name copies below `folder`, which is gone soon, as the run's configuration names them."""
    try:
        yield
    except SkylimbError as error:
        copies = rf"[^\s'`(]*{re.escape(folder.name)}/comparison/(run/)?"
        error.args = (re.sub(copies, lambda found: "" if found[1] else "../", str(error)),)
        raise


def _lacking(run: Record) -> ConfigError | None:
    """The error for a log without the copies of the user's files that it names; None where all are there."""
    files = run.tables.get(TABLE, {}).get("files", {})
    missing = sorted(files.keys() - run.sources.keys())
    if not missing:
        return None
    return ConfigError(
        f"the log comes without files that it was flown with: {', '.join(missing)}; replay the run's folder, "
        "or name another controller"
    )


def _flown_vectoring(run: Record, experiment: Experiment, robot: Robot, controller: Controller) -> str:
    """The purpose of the vectoring angles that the robot took off with, on which its mission depends."""
    if run.tables:
        # A controller that was handed over as an object cannot be made again.
        with suppress(SkylimbError):
            return needs_of(chosen_controller(None, experiment, robot, {})).vectoring
    return needs_of(controller).vectoring


def _broken_off(log: xr.Dataset) -> tuple[str, ...]:
    """That a flight left its mission, and when."""
    left = np.asarray(log["retreating"].values) > 0.0 if "retreating" in log.variables else np.zeros(1, bool)
    if not left.any():
        return ()
    time = float(log.time.values[int(np.argmax(left))])
    return (f"landing or broken off from t = {time:.3f} s on: its references there are not the mission's",)


def _mission(
    run: Record, log: xr.Dataset, held: Recorded, experiment: Experiment, robot: Robot, purpose: str
) -> tuple[Mission, tuple[str, ...]]:
    """The references of the flight: planned anew where its configuration is known, else from the log."""
    if not run.tables:
        return mission_of_log(log, held, standing(robot, purpose), experiment.control_period)
    mission = mission_of(experiment, robot, purpose)
    name = "cog_position_reference"
    if name not in log.variables:
        return mission, ()
    here = np.minimum(held.clock.ticks.astype(int), len(mission.times) - 1)
    step = np.linalg.norm(np.diff(mission.reference.position, axis=0), axis=1).max(initial=0.0)
    away = float(np.abs(mission.reference.position[here] - log[name].values).max())
    if away <= _SAME_PATH + step:  # between two ticks of its clock it may be anywhere
        return mission, ()
    return mission, (
        f"the mission is another than was flown: up to {away:.3g} m from the recorded reference",
    )


def _gains(
    experiment: Experiment, controller: Controller, log: xr.Dataset
) -> tuple[tuple[np.ndarray, np.ndarray] | None, tuple[str, ...]]:
    """The gains that changed in flight, by order or by its supervisor, and those that a controller lacks."""
    changes = [event for event in experiment.events if isinstance(event, GainChange)]
    layout = Layout(controller.gains()) if is_traceable(controller) else None
    known = [change for change in changes if layout and change.key in layout.slices]
    missing = {change.key for change in changes} - {change.key for change in known}
    said = tuple(f"{controller.name} has no gain '{key}' to be changed in flight" for key in sorted(missing))
    late, slow = (
        np.nan_to_num(log[name].values) if name in log else np.zeros(log.sizes["time"])
        for name in (LATENESS, SLOWNESS)
    )
    back = _back(log, experiment.control_period)
    suited = np.flatnonzero((late > 0.0) | (slow > 0.0) | (back < RETURNED))
    if layout is None or not (known or len(suited)):
        return None, said
    count = len(late)
    last = int(max((change.time for change in known), default=0.0) / experiment.control_period) + 2
    rows = np.tile(layout.pack(controller.gains()), (max(count, last), 1))
    if known:
        changed = gain_rows(known, controller, np.arange(len(rows)) * experiment.control_period)
        rows[:, changed.columns] = changed.values
    for k in suited:
        rows[k] = suited_gains(layout, rows[k], late[k], slow[k], back[k])
    return (np.arange(layout.size), rows), said


def _back(log: xr.Dataset, dt: float) -> np.ndarray:
    """Since the pose was the model's, s, at each tick: counted as the supervisor counts it, from its bits."""
    word = np.nan_to_num(log[BITS].values) if BITS in log else np.zeros(log.sizes["time"])
    back, started = np.full(len(word), np.inf), False
    for k, unseen in enumerate(bit_of(word, "stale")):
        back[k] = 0.0 if unseen and started else (back[k - 1] if k else np.inf) + dt
        started = started or not unseen
    return back


def _log(log: xr.Dataset, values: Mapping[str, np.ndarray], own: Mapping[str, Signal]) -> xr.Dataset:
    """The log with the controller's signals in the place of those that were recorded."""
    kept = {name: variable for name, variable in log.data_vars.items() if variable.attrs.get("kind") in _KEPT}
    made = {}
    for name, array in values.items():
        was = log.variables.get(name)
        if was is not None and was.shape == array.shape:
            # Flags are stored as small whole numbers; of a tick without number they are -1.
            whole = was.dtype.kind == "i"
            rows = np.where(np.isfinite(array), array, -1.0).astype(was.dtype) if whole else array
            made[name] = xr.Variable(was.dims, rows, was.attrs)
        else:
            made[name] = log_variable(name, array, own.get(name, Signal()), FLAGS.get(name, ()))
    fresh = xr.Dataset({**kept, **made}, coords=log.coords, attrs=log.attrs)
    for name in ("contact_gaps", "contact_transitions"):
        fresh.attrs.pop(name, None)
    return fresh
