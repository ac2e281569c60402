"""What a controller is to the loop, and how one is found by name or file."""

from __future__ import annotations

import copy
from collections.abc import Hashable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol, TypeGuard, runtime_checkable

from skylimb.config import put
from skylimb.control.cascade import Cascade, build_cascade
from skylimb.control.needs import Needs
from skylimb.control.preset import preset_from_mapping, preset_mapping
from skylimb.control.records import Command
from skylimb.control.slots import find_law, keys_of_law
from skylimb.errors import ConfigError
from skylimb.estimation.records import Measurement
from skylimb.keys import Table, units_of
from skylimb.missions.reference import Reference
from skylimb.robots.model import Robot
from skylimb.user_code import UserCode
from skylimb.user_modules import load_module


@runtime_checkable
class Controller(Protocol):
    """Anything that turns a measurement and a reference into a command.

    The paper's cascade follows it, and so does a user's own class. `gains` and `initial_state` may be of
    any kind that `step` understands; None will do. A controller that sets the mission's pace, wants a
    preview of the reference or takes off with other vectoring angles has an attribute `needs` (see
    `control.needs`).
    """

    @property
    def name(self) -> str:
        """Short name for records and figures."""
        ...

    def gains(self) -> Any:
        """Numbers that may change in flight."""
        ...

    def initial_state(self) -> Any:
        """What the controller remembers before the first tick."""
        ...

    def step(
        self, gains: Any, state: Any, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[Any, Command, Mapping[str, Any]]:
        """One tick of `dt` seconds: the new state, the command, and signals to record under their names."""
        ...


@runtime_checkable
class TraceableController(Controller, Protocol):
    """A controller whose `step` runs on CasADi symbols, so that it can be compiled and written as C."""

    @property
    def robot(self) -> Robot:
        """The controller's model of the robot."""
        ...

    @property
    def needs(self) -> Needs:
        """What it needs of the loop."""
        ...

    def structure(self) -> Hashable:
        """Everything that its traced step depends on besides numbers: laws, robot, structure of its state."""
        ...

    def require(self, dt: float) -> None:
        """Raise a `ConfigError` when it cannot work at a control period of `dt` s."""
        ...

    def check_gain(self, key: str, value: Any, where: str) -> None:
        """Raise a `ConfigError` that begins with `where` unless the gain of this key may have this value."""
        ...

    def key_tables(self) -> Iterator[Table]:
        """Every key that it was made from, with value, unit, range and meaning."""
        ...

    def tables(self) -> dict[str, Any]:
        """All that it was made from as plain tables, for a run's record."""
        ...


def is_traceable(controller: Controller) -> TypeGuard[TraceableController]:
    """Whether a controller can be traced and compiled."""
    return isinstance(controller, TraceableController)


def load_controller(
    name_or_path: str, robot: Robot, overrides: Mapping[str, Any] | None = None
) -> Controller:
    """A preset by name, a preset in a TOML file, or a user's controller in a Python file.

    A Python file defines `controller(robot)`, which returns an object that follows `Controller`.

    Args:
        name_or_path: "hybrid", "my_gains.toml" or "my_controller.py".
        robot: the model that the controller believes in.
        overrides: dotted keys of a preset and their new values, for example {"translation.damping_ratio":
            [1, 1, 1]}.

    Raises:
        UnknownNameError: when there is no such preset.
        ConfigError: when the file cannot be used, or overrides are given to a Python file.
    """
    if name_or_path.endswith(".py"):
        if overrides:
            raise ConfigError(
                f"controller '{name_or_path}' is a Python file; its gains cannot be set from outside"
            )
        return _users_controller(Path(name_or_path), robot)
    return controller_from_tables(*preset_mapping(name_or_path), robot, overrides)


def controller_from_tables(
    tables: Mapping[str, Any], path: Path, robot: Robot, overrides: Mapping[str, Any] | None = None
) -> Cascade:
    """A cascade from a preset's tables.

    Args:
        tables: of the preset.
        path: their file, which a law given by path is sought beside.
        robot: the model that the controller believes in.
        overrides: dotted keys and their new values. Where one names another law for a slot, the slot keeps
            those of the preset's keys that the new law has, and takes its defaults for the rest.
    """
    mapping = copy.deepcopy(dict(tables))
    overrides = overrides or {}
    for key, law in overrides.items():
        slot, _, rest = key.partition(".")
        if rest == "law":
            known = keys_of_law(find_law(slot, str(law), path.parent))
            mapping[slot] = _common(mapping.get(slot, {}), known)
    for key, value in overrides.items():
        put(mapping, key, value)
    return build_cascade(robot, preset_from_mapping(mapping, path))


def _common(table: Mapping[str, Any], known: Iterable[str]) -> dict[str, Any]:
    """The part of a table whose dotted keys are known."""
    known = list(known)
    found: dict[str, Any] = {}
    for key, value in table.items():
        below = [name.partition(".")[2] for name in known if name.partition(".")[0] == key]
        if isinstance(value, Mapping):
            found[key] = _common(value, below)
        elif below:
            found[key] = value
    return found


def _users_controller(path: Path, robot: Robot) -> Controller:
    make = load_module(path, ("controller",)).controller
    with UserCode(f"controller(robot) of '{path.name}'"):
        made = make(robot)
    missing = [name for name in ("name", "gains", "initial_state", "step") if not hasattr(made, name)]
    if missing:
        raise ConfigError(f"controller(robot) in '{path}' returns an object without {', '.join(missing)}")
    return made


def resolved_tables(controller: Controller) -> dict[str, Any]:
    """A preset as plain tables, for a run's record; only the name for a controller that has none."""
    return controller.tables() if is_traceable(controller) else {"name": controller.name}


def controller_units(controller: Controller) -> dict[str, str]:
    """Unit of every gain that has one, by dotted key; empty for a controller that has no such keys."""
    return units_of(controller.key_tables()) if is_traceable(controller) else {}
