"""The calls that users make: fly one controller, compare several, or step a flight by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from skylimb.analysis.own import Own, load_own, with_own_scores
from skylimb.control.cascade import calibrated
from skylimb.control.controller import (
    Controller,
    controller_from_tables,
    controller_of,
    load_controller,
)
from skylimb.control.corrections import Calibrated, corrections_of
from skylimb.control.slots import SLOTS
from skylimb.errors import ConfigError
from skylimb.experiments.experiment import Experiment, experiment_with, load_experiment
from skylimb.flights.flying import begin_loop, fly
from skylimb.flights.pressable import warn_of_friction
from skylimb.flights.record import recorded
from skylimb.flights.sources import originals
from skylimb.flights.stepped import SteppedFlight
from skylimb.flights.takeoff import Takeoff, prepare
from skylimb.recording.run import Run
from skylimb.recording.runs import Runs
from skylimb.robots.loader import load_robot
from skylimb.robots.model import Robot

Progress = Callable[[str, int, int], None]
"""Called now and then with (controller, ticks flown, ticks in all)."""

Use = str | Path | ModuleType | Own
"""A Python file or module with metrics and figures, or one of them."""

DEFAULT_CONTROLLER = "hybrid"
PAPER_CONTROLLERS = ("pid", "impedance", "admittance", "hybrid")


def run(
    experiment: str | Experiment = "paper",
    controller: str | Controller | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    use: Sequence[Use] = (),
    calibration: Calibrated | None = None,
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

    Returns:
        The run; a flight that is lost has status FAILED and its cause, and no scores.

    Raises:
        SkylimbError: when a flight cannot be flown; nothing has flown then.
    """
    (takeoff,) = take_off(experiment, (controller,), seed, set, use, calibration)
    return _flown(takeoff, progress)


def begin(
    experiment: str | Experiment = "paper",
    controller: str | Controller | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    calibration: Calibrated | None = None,
) -> SteppedFlight:
    """A flight before its first tick, to be stepped from outside.

    Arguments are those of `run`.

    Returns:
        A flight with `tick`, `signal` and `finish`; driven to its end it is the flight of `run`.
    """
    (takeoff,) = take_off(experiment, (controller,), seed, set, calibration=calibration)
    return SteppedFlight(takeoff, begin_loop(takeoff))


def compare(
    experiment: str | Experiment = "paper",
    controllers: Sequence[str | Controller] = PAPER_CONTROLLERS,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    use: Sequence[Use] = (),
    calibration: Calibrated | None = None,
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
    return Runs((one.controller.name, _flown(one, progress)) for one in ready)


def _flown(takeoff: Takeoff, progress: Progress | None) -> Run:
    """Fly a take-off to its end."""

    def report(done: int, total: int) -> None:
        if progress is not None:
            progress(takeoff.controller.name, done, total)

    return with_own_scores(recorded(takeoff, fly(takeoff, report)), takeoff.own)


def take_off(
    experiment: str | Experiment,
    controllers: Sequence[str | Controller | None],
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    use: Sequence[Use] = (),
    calibration: Calibrated | None = None,
) -> list[Takeoff]:
    """Load and check everything before anything flies: one take-off for each controller.

    Arguments are those of `run` and `compare`. A run's own config.toml brings its metrics along.
    """
    given_own = load_own(use)
    given, gains = parted(set or {})
    if seed is not None:
        given["seed"] = seed
    named = experiment
    if isinstance(experiment, Experiment):
        experiment = experiment_with(experiment, given)
    else:
        experiment = load_experiment(experiment, given)
    robot = load_robot(experiment.robot)
    ready = [chosen_controller(item, experiment, robot, gains) for item in controllers]
    if calibration is not None:
        found = corrections_of(calibration)
        ready = [calibrated(controller, robot, found, gains) for controller in ready]
    own = (*load_own(experiment.recorded.get("use", ())), *given_own)
    takeoffs = [
        prepare(experiment, robot, controller, originals(named, item), own)
        for item, controller in zip(controllers, ready, strict=True)
    ]
    for controller in ready:
        warn_of_friction(experiment, robot, controller)
    return takeoffs


def parted(settings: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Settings by dotted key: the experiment's, and the controller's without "controller."."""
    gains = {key: value for key, value in settings.items() if key.startswith("controller.")}
    rest = {key: value for key, value in settings.items() if key not in gains}
    return rest, {key.removeprefix("controller."): value for key, value in gains.items()}


def chosen_controller(
    given: str | Controller | None, experiment: Experiment, robot: Robot, gains: Mapping[str, Any]
) -> Controller:
    """The controller that was named or handed over; else the one that the experiment brings, else "hybrid".

    Args:
        given: a name, a file, a controller at hand, or None.
        experiment: may hold the tables of a controller.
        robot: the model that the controller believes in.
        gains: dotted keys and new values.
    """
    if given is None and experiment.controller:
        return _recorded_controller(dict(experiment.controller), experiment.name, robot, gains)
    if given is None or isinstance(given, str):
        return load_controller(given or DEFAULT_CONTROLLER, robot, gains)
    return controller_of(given, robot, gains)


def _recorded_controller(
    tables: dict[str, Any], experiment: str, robot: Robot, gains: Mapping[str, Any]
) -> Controller:
    """The controller of a run's config.toml, with other values of some gains."""
    if "file" not in tables and not set(SLOTS) & set(tables):
        raise ConfigError(
            f"experiment {experiment} was flown by '{tables.get('name')}', a Python controller at hand "
            "that its file does not hold; name another with --controller"
        )
    return controller_from_tables(tables, Path("config.toml"), robot, gains)
