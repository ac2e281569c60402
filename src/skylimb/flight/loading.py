"""From names to plans: experiment, robot and controllers loaded and checked before anything flies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

from skylimb.analysis.scores.user_scores import UserScore, load_user_scores
from skylimb.base.config import flatten
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.keys.key import shown
from skylimb.base.plugins import added_names
from skylimb.base.sources import read_source
from skylimb.control.calibrated import calibrated
from skylimb.control.controller import (
    Controller,
    controller_from_tables,
    controller_of,
    kept_by_laws,
    load_controller,
)
from skylimb.control.corrections import Calibrated, corrections_of
from skylimb.control.laws.preset import law_folder, preset_file, preset_names
from skylimb.control.laws.slots import SLOTS
from skylimb.flight.experiments.experiment import Experiment, experiment_with, load_experiment, robot_of
from skylimb.flight.plan import FlightPlan, checked
from skylimb.robots.model import Robot

Use = str | Path | ModuleType | UserScore
"""A Python file or module with metrics and figures, or one of them."""

DEFAULT_CONTROLLER = "hybrid"


def plan_flights(
    experiment: str | Path | Experiment,
    controllers: Sequence[str | Path | Controller | None],
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    use: Sequence[Use] = (),
    calibration: Calibrated | None = None,
) -> list[FlightPlan]:
    """Load and check everything before anything flies: one plan for each controller.

    Arguments are those of `skylimb.run` and `skylimb.compare`. A run's own config.toml brings its metrics
    along.

    Raises:
        ConfigError: when something cannot be flown, or the controllers are none, or no list.
    """
    if isinstance(controllers, str | Path):
        raise ConfigError(
            f"controllers = '{controllers}' should be a list, as in controllers=['{controllers}']"
        )
    if not controllers:
        raise ConfigError("controllers is empty; `skylimb list` shows the names")
    given_own = load_user_scores(use)
    loaded = [load_flight(experiment, item, seed, set, calibration) for item in controllers]
    return [
        checked(
            replace(
                one,
                originals=tuple(
                    read_source(name)
                    for name in (experiment, item)
                    if isinstance(name, str | Path) and str(name).endswith(".toml")
                ),
                own=(*load_user_scores(one.experiment.recorded.get("use", ())), *given_own),
            )
        )
        for item, one in zip(controllers, loaded, strict=True)
    ]


def load_flight(
    experiment: str | Path | Experiment,
    controller: str | Path | Controller | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    calibration: Calibrated | None = None,
) -> FlightPlan:
    """The plan by the names that users give, not checked yet; arguments are those of `skylimb.run`."""
    given, gains = parted(set or {})
    if seed is not None:
        given["seed"] = seed
    if isinstance(experiment, Experiment):
        ready = experiment_with(experiment, given)
    else:
        ready = load_experiment(experiment, given)
    return plan_of(ready, controller, gains, calibration)


def plan_of(
    experiment: Experiment,
    controller: str | Path | Controller | None,
    gains: Mapping[str, Any],
    calibration: Calibrated | None,
) -> FlightPlan:
    """The plan of an experiment at hand, not checked yet; `gains` are without "controller."."""
    robot = robot_of(experiment)
    chosen = chosen_controller(controller, experiment, robot, gains)
    if calibration is not None:
        chosen = calibrated(chosen, robot, corrections_of(calibration), gains)
    return FlightPlan(experiment, robot, chosen)


PRESET = "preset"
"""Key of an experiment's controller: the preset whose gains it changes."""


def parted(settings: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Settings by dotted key: the experiment's, and the controller's without "controller.".

    Raises:
        ConfigError: when they are no mapping, but a list as on the command line.
    """
    if not isinstance(settings, Mapping):
        raise ConfigError(
            f"set = {shown(settings)} should be a dict of dotted keys, as in set={{'surface.friction': 0.2}}"
        )
    gains = {key: value for key, value in settings.items() if key.startswith("controller.")}
    rest = {key: value for key, value in settings.items() if key not in gains}
    return rest, {key.removeprefix("controller."): value for key, value in gains.items()}


def chosen_controller(
    given: str | Path | Controller | None, experiment: Experiment, robot: Robot, gains: Mapping[str, Any]
) -> Controller:
    """The controller that was named or handed over; else the one that the experiment brings, else "hybrid".

    Args:
        given: a name, a file, a controller at hand, or None.
        experiment: may hold the tables of a controller.
        robot: the model that the controller believes in.
        gains: dotted keys and new values.
    """
    if given is None and PRESET in experiment.controller:
        return _adapted_preset(dict(experiment.controller), experiment.name, robot, gains)
    if given is None and experiment.controller:
        return _recorded_controller(dict(experiment.controller), experiment.name, robot, gains)
    if given is None or isinstance(given, str | Path):
        return load_controller(str(given or DEFAULT_CONTROLLER), robot, gains)
    return controller_of(given, robot, gains)


def _adapted_preset(
    tables: dict[str, Any], experiment: str, robot: Robot, gains: Mapping[str, Any]
) -> Controller:
    """The preset that an experiment names, with what it changes of it, and other values of some gains."""
    name = tables.pop(PRESET)
    if not isinstance(name, str):
        raise ConfigError(f"experiment {experiment}: controller.{PRESET} = {shown(name)} should be a name")
    known = [*preset_names(), *added_names("controllers")]
    if name not in known:
        raise unknown_name(f"controller.{PRESET} of experiment {experiment}", name, known)
    own = kept_by_laws(flatten(tables), gains, law_folder(preset_file(name)))
    return load_controller(name, robot, {**own, **gains})


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
