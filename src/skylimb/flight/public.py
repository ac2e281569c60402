"""The calls that users make: fly one controller, compare several, or step a flight by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from skylimb.analysis.notebook_run import Run, Runs
from skylimb.analysis.scores.user_scores import scored
from skylimb.base.errors import ConfigError
from skylimb.control.controller import Controller
from skylimb.control.corrections import Calibrated
from skylimb.control.loop.flight import Flight, Interrupted
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.flying import fly
from skylimb.flight.loading import Use
from skylimb.flight.simulated_run import simulated_run, with_origin
from skylimb.flight.stepped import SteppedFlight
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.simulation.user_plant import UserPlant

Progress = Callable[[str, int, int], None]
"""Called now and then with (controller, ticks flown, ticks in all)."""

Keep = Callable[[Run], None]
"""Called with the record of a flight as soon as it has ended, before it is scored."""

PAPER_CONTROLLERS = ("pid", "impedance", "admittance", "hybrid")


def run(
    experiment: str | Path | Experiment = "paper",
    controller: str | Path | Controller | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    use: Sequence[Use] = (),
    calibration: Calibrated | None = None,
    keep: Keep | None = None,
    plant: UserPlant | None = None,
) -> Run:
    """Fly one controller through one experiment.

    Args:
        experiment: a name, a TOML file, or an experiment at hand.
        controller: a preset's name, a preset's TOML file, a Python file, or a controller at hand; when
            None, the one that the experiment's file brings along (as a run's config.toml does), else
            "hybrid".
        seed: of the sensors' noise; the experiment's own when None.
        set: dotted keys of the experiment and new values; keys that begin with "controller." go to the
            preset.
        progress: called with how far the flight is.
        use: metrics of your own besides those that ship: functions with `@skylimb.metric`, or Python files.
        calibration: what the controller knows of robot and sensors besides their description: a
            calibration.toml, or what `skylimb.calibrate` returned.
        keep: called with the record before anything is scored; of a flight that Ctrl-C ends, with what was
            flown.
        plant: a simulator of your own in place of MuJoCo (`UserPlant`).

    Returns:
        The run; a flight that is lost has status FAILED and its cause, and no scores. A metric of yours that
        fails has no number, and the run's `problems` say why.

    Raises:
        SkylimbError: when a flight cannot be flown; nothing has flown then.
    """
    (takeoff,) = take_off(experiment, (controller,), seed, set, use, calibration, plant)
    return _flown(takeoff, progress, keep)


def begin(
    experiment: str | Path | Experiment = "paper",
    controller: str | Path | Controller | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    calibration: Calibrated | None = None,
    plant: UserPlant | None = None,
) -> SteppedFlight:
    """A flight before its first tick, to be stepped from outside.

    Arguments are those of `run`.

    Returns:
        A flight with `tick`, `signal` and `finish`; driven to its end it is the flight of `run`.
    """
    (takeoff,) = take_off(experiment, (controller,), seed, set, calibration=calibration, plant=plant)
    return SteppedFlight(takeoff)


def compare(
    experiment: str | Path | Experiment = "paper",
    controllers: Sequence[str | Path | Controller] = PAPER_CONTROLLERS,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    use: Sequence[Use] = (),
    calibration: Calibrated | None = None,
    keep: Keep | None = None,
) -> Runs:
    """Fly several controllers through the same experiment with the same seed.

    Arguments are those of `run`.

    Returns:
        Runs by the controllers' names, in the order given, as a dict with a method `plot`.
    """
    ready = take_off(experiment, controllers, seed, set, use, calibration)
    names = [takeoff.controller.name for takeoff in ready]
    alike = sorted({name for name in names if names.count(name) > 1})
    if alike:
        raise ConfigError(f"two controllers are called '{alike[0]}'; a comparison needs a name for each")
    return Runs((one.controller.name, _flown(one, progress, keep)) for one in ready)


def _flown(takeoff: Takeoff, progress: Progress | None, keep: Keep | None) -> Run:
    """Fly a take-off to its end, hand out its record, then score it."""

    def report(done: int, total: int) -> None:
        if progress is not None:
            progress(takeoff.controller.name, done, total)

    def record(flight: Flight) -> Run:
        run = with_origin(simulated_run(takeoff, flight), takeoff)
        if keep is not None:
            keep(run)
        return run

    try:
        flight = fly(takeoff, report)
    except Interrupted as stop:
        record(stop.flight)
        raise
    return scored(record(flight), takeoff.own)
