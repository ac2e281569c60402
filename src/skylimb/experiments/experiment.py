"""An experiment: everything that a flight needs besides the controller, read from one TOML file."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skylimb.config import from_mapping, put, read_toml, require_range, to_mapping
from skylimb.errors import ConfigError, unknown_name
from skylimb.planning.posture_path import PostureConfig
from skylimb.planning.trajectories import TrajectoryConfig
from skylimb.simulation.disturbance import DisturbanceConfig
from skylimb.simulation.gain_changes import GainChange
from skylimb.simulation.mission import ApproachConfig, PhaseConfig, contact_frame
from skylimb.simulation.plant import PlantConfig
from skylimb.simulation.sensors import SensorConfig
from skylimb.simulation.surfaces import Surface, surface_from_mapping

EXPERIMENTS = Path(__file__).parent / "library"


@dataclass(frozen=True)
class Settings:
    """All of an experiment but its surface.

    Attributes:
        name: short name.
        description: one line on what it is.
        robot: a robot's name, or the folder or file of the user's own.
        seed: of the sensors' noise.
        controller_rate: control ticks a second, Hz.
        contact_axis: nominal direction into the surface, W.
        trajectory: path in the sliding plane.
        approach: how the robot comes to the surface and leaves it.
        phases: how long it waits.
        posture: postures to go through during the slide; none in contact.
        disturbance: a push on the flying robot.
        sensors: what it measures.
        plant: how the real robot differs from its description.
        gain_changes: gains of the controller that change in flight.
    """

    name: str = ""
    description: str = ""
    robot: str = "hydrus_xi_quad"
    seed: int = 0
    controller_rate: float = 200.0
    contact_axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    trajectory: TrajectoryConfig = field(default_factory=TrajectoryConfig)
    approach: ApproachConfig = field(default_factory=ApproachConfig)
    phases: PhaseConfig = field(default_factory=PhaseConfig)
    posture: PostureConfig = field(default_factory=PostureConfig)
    disturbance: DisturbanceConfig = field(default_factory=DisturbanceConfig)
    sensors: SensorConfig = field(default_factory=SensorConfig)
    plant: PlantConfig = field(default_factory=PlantConfig)
    gain_changes: tuple[GainChange, ...] = ()

    def __post_init__(self) -> None:
        require_range("experiment", "controller_rate", self.controller_rate, 10.0, 10_000.0, "Hz")
        require_range("experiment", "seed", self.seed, 0, 2**63 - 1)
        contact_frame(self.contact_axis)


@dataclass(frozen=True)
class Experiment(Settings):
    """An experiment.

    Attributes:
        surface: what is touched.
        controller: tables of a preset to fly where nobody names another, as a run's own config.toml has
            them; empty for none.
    """

    surface: Surface = field(default_factory=lambda: surface_from_mapping({}))
    controller: Mapping[str, Any] = field(default_factory=dict)

    @property
    def control_period(self) -> float:
        """Time between two control ticks, s."""
        return 1.0 / self.controller_rate

    def to_mapping(self) -> dict[str, Any]:
        """The experiment as nested plain values, as in its file."""
        mapping = to_mapping(self)
        for name in ("controller", "gain_changes"):
            if not mapping[name]:
                del mapping[name]
        return mapping


def experiment_names() -> list[str]:
    """Names of the experiments that ship."""
    return sorted(path.stem for path in EXPERIMENTS.glob("*.toml"))


def load_experiment(name_or_path: str, set: Mapping[str, Any] | None = None) -> Experiment:
    """An experiment by name or TOML file, some of its values replaced.

    Args:
        name_or_path: "paper", or a path that ends in .toml.
        set: dotted keys and their new values, for example {"surface.slope": 0.2}.

    Raises:
        UnknownNameError: when there is no such experiment or key.
        ConfigError: when a value has the wrong type or is out of range.
    """
    mapping = experiment_tables(name_or_path)
    for key, value in (set or {}).items():
        put(mapping, key, value)
    return experiment_from_mapping(mapping, f"experiment {Path(name_or_path).stem}")


def experiment_tables(name_or_path: str) -> dict[str, Any]:
    """The tables of an experiment's file as they stand in it, and its name; defaults are not filled in.

    Raises:
        UnknownNameError: when there is no such experiment.
        ConfigError: when the file cannot be read.
    """
    if str(name_or_path).endswith(".toml"):
        path = Path(name_or_path)
    elif name_or_path in experiment_names():
        path = EXPERIMENTS / f"{name_or_path}.toml"
    else:
        raise unknown_name("experiment", str(name_or_path), experiment_names())
    return {"name": path.stem, **read_toml(path)}


def experiment_from_mapping(mapping: Mapping[str, Any], where: str) -> Experiment:
    """An experiment from nested tables, every key checked."""
    tables = dict(mapping)
    surface, controller = _table(tables, "surface", where), _table(tables, "controller", where)
    known = {f.name for f in dataclasses.fields(Experiment)}
    for key in tables:
        if key not in known:
            raise unknown_name(f"key of {where}", key, known)
    settings = from_mapping(Settings, tables, where)
    values = {f.name: getattr(settings, f.name) for f in dataclasses.fields(Settings)}
    # The surface faces the robot along the experiment's contact axis unless it is told otherwise.
    surface = {"contact_axis": list(settings.contact_axis), **surface}
    return Experiment(**values, surface=surface_from_mapping(surface, where), controller=controller)


def _table(tables: dict[str, Any], name: str, where: str) -> dict[str, Any]:
    table = tables.pop(name, {})
    if not isinstance(table, dict):
        raise ConfigError(f"{where}: {name} = {table!r} should be a table")
    return table


def experiment_with(experiment: Experiment, changes: Mapping[str, Any]) -> Experiment:
    """A copy of an experiment with the values under some dotted keys replaced, checked like a file's."""
    mapping = experiment.to_mapping()
    for key, value in changes.items():
        put(mapping, key, value)
    return experiment_from_mapping(mapping, f"experiment {experiment.name}")
