"""An experiment: everything that a flight needs besides the controller, read from one TOML file."""

from __future__ import annotations

import copy
import dataclasses
import functools
import os
from collections.abc import Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Annotated, Any

from skylimb.analysis.recording.origin import TABLE, absolute, changes_since, used_files
from skylimb.analysis.recording.versions import origin_versions
from skylimb.base.config import from_mapping, put, read_toml, to_mapping, value_of
from skylimb.base.errors import ConfigError, SkylimbError, UnknownNameError, unknown_name
from skylimb.base.keys import Key, KeyInfo, configuration, keys_of
from skylimb.base.keys.key import shown
from skylimb.base.plugins import added_file, added_names
from skylimb.control.laws.file_kinds import require_kind
from skylimb.control.loop.terminations import Terminations
from skylimb.control.missions.configuration import MissionConfig
from skylimb.control.planning.posture_path import PostureConfig
from skylimb.control.planning.user_path import spelled_out
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.events import Event, events_from_mapping
from skylimb.flight.experiments.tolerances import Tolerances
from skylimb.flight.experiments.unknown_keys import unknown_key
from skylimb.robots.description import GRAVITY
from skylimb.robots.loader import list_robots, load_robot
from skylimb.robots.model import Robot
from skylimb.simulation.plant_config import PlantConfig
from skylimb.simulation.sensors import SensorConfig
from skylimb.simulation.surfaces import SURFACES, Surface, surface_from_mapping
from skylimb.simulation.surfaces.placement import check_unit_vector

EXPERIMENTS = Path(__file__).parent / "library"

_MOST_NAMED = 4

_NOW_EVENTS = {
    "disturbance": 'kind = "push" and time in place of start',
    "gain_changes": 'kind = "gain" and duration in place of blend',
    "pushes": 'kind = "push" and time in place of start',
    "surface_changes": 'kind = "surface" and duration in place of blend',
}
"""Tables that experiments had before events were one list, and how they are written."""


@configuration
class Settings(MissionConfig):
    """All of an experiment but its surface and its events."""

    name: Annotated[str, Key("", "short name")] = ""
    description: Annotated[str, Key("", "one line on what it is")] = ""
    robot: Annotated[str, Key("", "a robot's name, or the folder or flight file of your own", file=True)] = (
        "hydrus_xi_quad"
    )
    seed: Annotated[int, Key("", "seed of the sensors' noise", low=0, high=2**63 - 1)] = 0
    controller_rate: Annotated[float, Key("Hz", "control ticks a second", low=10.0, high=10_000.0)] = 200.0
    gravity: Annotated[float, Key("m/s^2", "of the place, for plant and model alike", low=9.7, high=9.9)] = (
        GRAVITY
    )
    contact_axis: Annotated[
        tuple[float, float, float],
        Key("", "unit vector in W, the nominal direction into the surface", low=-1.001, high=1.001),
    ] = (1.0, 0.0, 0.0)
    surface_error: Annotated[
        tuple[float, float, float] | None,
        Key(
            "m",
            "believed less true surface.position, W: where the mission flies to; none for no error",
            low=-1.0,
            high=1.0,
        ),
    ] = None
    posture: PostureConfig = field(default_factory=PostureConfig)
    sensors: SensorConfig = field(default_factory=SensorConfig)
    plant: PlantConfig = field(default_factory=PlantConfig)
    terminations: Terminations = field(default_factory=Terminations)
    supervisor: Limits = field(default_factory=Limits)
    tolerances: Tolerances = field(default_factory=Tolerances)
    stop_at: Annotated[
        float | None,
        Key(
            "s",
            "time since take-off at which the flight is stopped before its mission's end",
            above=0.0,
            high=1e5,
        ),
    ] = None

    def check(self) -> None:
        """Refuse a contact axis that is no unit vector."""
        check_unit_vector(self, "contact_axis")


@configuration
class Experiment(Settings):
    """An experiment: everything that a flight needs besides the controller."""

    surface: Surface = field(default_factory=lambda: surface_from_mapping({}))
    events: tuple[Event, ...] = ()
    controller: Annotated[
        Mapping[str, Any],
        Key(
            "",
            'what flies where nobody names another: tables of a preset, or preset = "NAME" and what is other '
            "than in it; a run's own config.toml has the tables",
        ),
    ] = field(default_factory=dict)
    recorded: Annotated[
        Mapping[str, Any],
        Key("", "what produced a run, in its own config.toml; what has changed since is reported"),
    ] = field(default_factory=dict)

    @property
    def control_period(self) -> float:
        """Time between two control ticks, s."""
        return 1.0 / self.controller_rate

    @property
    def path_center(self) -> tuple[float, float, float]:
        """Where the middle of the path is believed to be on the surface, W, m."""
        x, y, z = self.surface.position
        dx, dy, dz = self.surface_error or (0.0, 0.0, 0.0)
        return (x + dx, y + dy, z + dz)

    def to_mapping(self) -> dict[str, Any]:
        """The experiment as nested plain values, as in its file."""
        mapping = to_mapping(self)
        for name in ("controller", "events", "recorded"):
            if not mapping[name]:
                del mapping[name]
        return mapping


def experiment_names() -> list[str]:
    """Names of the experiments that ship."""
    return sorted(path.stem for path in EXPERIMENTS.glob("*.toml"))


def load_experiment(name_or_path: str | Path, set: Mapping[str, Any] | None = None) -> Experiment:
    """An experiment by name or TOML file, some of its values replaced.

    Args:
        name_or_path: "paper", or a path that ends in .toml.
        set: dotted keys and their new values, for example {"surface.slope": 0.2}.

    Raises:
        UnknownNameError: when there is no such experiment or key.
        ConfigError: when a value has the wrong type or is out of range.
    """
    where = f"experiment {Path(name_or_path).stem}"
    mapping = experiment_tables(name_or_path)
    if not set:
        return experiment_from_mapping(mapping, where)
    before = copy.deepcopy(mapping)
    for key, value in set.items():
        put(mapping, key, value)
    experiment = experiment_from_mapping(mapping, where)
    if not experiment.description or "description" in set:
        return experiment
    return replace(experiment, description=_described(experiment, before, set))


def _described(experiment: Experiment, before: dict[str, Any], set: Mapping[str, Any]) -> str:
    """A file's description with the keys that were set otherwise, as it may be untrue of what they change."""
    here: dict[str, Any] = experiment.to_mapping()
    try:
        there: dict[str, Any] = experiment_from_mapping(before, "").to_mapping()
    except SkylimbError:  # a file that is only good with what was set
        there = {}
    keys = [key for key in set if key not in ("name", "seed") and value_of(here, key) != value_of(there, key)]
    more = f" and {len(keys) - _MOST_NAMED} more" if len(keys) > _MOST_NAMED else ""
    otherwise = f"; set otherwise: {', '.join(keys[:_MOST_NAMED])}{more}" if keys else ""
    return f"{experiment.description.rstrip('.') if keys else experiment.description}{otherwise}"


def experiment_tables(name_or_path: str | Path) -> dict[str, Any]:
    """The tables of an experiment's file as they stand in it, and its name; defaults are not filled in.

    Raises:
        UnknownNameError: when there is no such experiment.
        ConfigError: when the file cannot be read, or is a controller's.
    """
    path, known = Path(name_or_path), experiment_names()
    if not str(name_or_path).endswith(".toml"):
        name = str(name_or_path)
        file = added_file("experiments", name, name in known)
        if file is None and name not in known:
            known += added_names("experiments")
            raise unknown_name("experiment", name, known, (".toml",))
        path = file or EXPERIMENTS / f"{name}.toml"
    tables = read_toml(path)
    require_kind(tables, str(name_or_path), "experiment")
    return {"name": path.stem, **_beside(tables, path.parent)}


def _beside(tables: dict[str, Any], folder: Path) -> dict[str, Any]:
    """An experiment's tables, every file that they name sought in `folder`, where their own file lies.

    Of a run's config.toml, what has changed since stands in place of what produced it, with the files of the
    user's metrics.
    """
    changes = changes_since(tables, folder, origin_versions()) if TABLE in tables else []
    tables = _with_path(tables)
    recorded = {"changes": changes, "use": used_files(tables, folder)}
    recorded = {name: value for name, value in recorded.items() if value}
    tables = {**absolute(tables, folder), **({TABLE: recorded} if recorded else {})}
    files = (key for key, info in experiment_keys().items() if info.key.file)
    for key in (*files, "surface.kind", *_code_keys(tables)):
        value = value_of(tables, key)
        if isinstance(value, str) and _is_file(key, value, folder):
            put(tables, key, Path(os.path.abspath(folder / value)).as_posix())
    return tables


def _with_path(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The tables with a path of the user's own named by its three keys."""
    path = tables.get("trajectory")
    return {**tables, "trajectory": spelled_out(path)} if isinstance(path, Mapping) else dict(tables)


def _is_file(key: str, value: str, folder: Path) -> bool:
    """Whether a value names a file, and no robot or law that ships."""
    if key.endswith((".law", "surface.kind")):
        return value.endswith(".py")
    if key == "robot":
        return ("/" in value or os.path.exists(folder / value)) and value not in list_robots()
    return bool(value)


def _code_keys(tables: Mapping[str, Any]) -> list[str]:
    """Dotted keys of an experiment's controller that may name a Python file."""
    controller = tables.get("controller")
    slots = [name for name, table in controller.items() if isinstance(table, dict)] if controller else []
    return ["controller.file", *(f"controller.{name}.law" for name in slots)]


@functools.cache
def experiment_keys() -> dict[str, KeyInfo]:
    """Every dotted key that an experiment may have, those of all surfaces with it."""
    surfaces = {f"surface.{key}": info for kind in SURFACES.values() for key, info in keys_of(kind).items()}
    return {**keys_of(Settings), **surfaces}


def experiment_from_mapping(mapping: Mapping[str, Any], where: str) -> Experiment:
    """An experiment from nested tables, every key checked."""
    tables = _with_path(mapping)
    surface, controller = _table(tables, "surface", where), _table(tables, "controller", where)
    recorded = _table(tables, "recorded", where)
    events = events_from_mapping(tables.pop("events", ()), where)
    known = {f.name for f in dataclasses.fields(Experiment)}
    for key, value in tables.items():
        if key in _NOW_EVENTS:
            raise UnknownNameError(f"{where}: '{key}' is written as [[events]] with {_NOW_EVENTS[key]} now")
        if key not in known:
            raise unknown_key(where, key, value, known, experiment_keys())
    settings = from_mapping(Settings, tables, where)
    values = {f.name: getattr(settings, f.name) for f in dataclasses.fields(Settings)}
    # The surface faces the robot along the experiment's contact axis unless the file says otherwise.
    surface = {"contact_axis": list(settings.contact_axis), **surface}
    made = surface_from_mapping(surface, where)
    return Experiment(**values, surface=made, events=events, controller=controller, recorded=recorded)


def _table(tables: dict[str, Any], name: str, where: str) -> dict[str, Any]:
    table = tables.pop(name, {})
    if not isinstance(table, dict):
        raise ConfigError(f"{where}: {name} = {shown(table)} should be a table")
    return table


def require_contact(experiment: Experiment, called: str, purpose: str) -> None:
    """Raise a `ConfigError` for an experiment that touches nothing: there is nothing to `purpose` then."""
    if not experiment.approach.contact:
        raise ConfigError(f"{called} touches nothing (approach.contact); there is nothing to {purpose}")


def robot_of(experiment: Experiment) -> Robot:
    """The robot of an experiment, at the experiment's place; see `load_robot`."""
    return load_robot(experiment.robot, experiment.gravity)


def experiment_with(experiment: Experiment, changes: Mapping[str, Any]) -> Experiment:
    """A copy of an experiment with the values under some dotted keys replaced, checked like a file's."""
    mapping = experiment.to_mapping()
    for key, value in changes.items():
        put(mapping, key, value)
    return experiment_from_mapping(mapping, f"experiment {experiment.name}")
