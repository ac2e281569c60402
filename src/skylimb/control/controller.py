"""What a controller is to the loop, and how one is found by name or file."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol, TypeGuard, runtime_checkable

from skylimb.config import put
from skylimb.control.cascade import Cascade, build_cascade
from skylimb.control.needs import Needs
from skylimb.control.preset import load_module, preset_from_mapping, preset_mapping
from skylimb.control.records import Command
from skylimb.errors import ConfigError
from skylimb.estimation.records import Measurement
from skylimb.missions.reference import Reference
from skylimb.robots.model import Robot


class Controller(Protocol):
    """Anything that turns a measurement and a reference into a command.

    The paper's cascade follows it, and so does a user's own class. `gains` and `initial_state` may be of
    any kind that `step` understands; None will do.
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
    """A controller whose step may be traced with symbols and compiled."""

    @property
    def robot(self) -> Robot:
        """The robot that it believes in."""
        ...

    @property
    def needs(self) -> Needs:
        """What it needs of the loop."""
        ...

    def structure(self) -> tuple[Any, ...]:
        """Everything that its traced step depends on besides its arguments; hashable."""
        ...

    def require(self, dt: float) -> None:
        """Raise a `ConfigError` when it cannot be flown with ticks of `dt` seconds."""
        ...

    def tables(self) -> dict[str, Any]:
        """The controller as plain tables for a run's record."""
        ...


def is_traceable(controller: Controller) -> TypeGuard[TraceableController]:
    """Whether a controller's step may be traced and compiled; a user's plain Python class may not."""
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
    """A cascade from a preset's tables; `path` is their file, which a law given by path is sought beside."""
    mapping = copy.deepcopy(dict(tables))
    for key, value in (overrides or {}).items():
        put(mapping, key, value)
    return build_cascade(robot, preset_from_mapping(mapping, path))


def _users_controller(path: Path, robot: Robot) -> Controller:
    make = load_module(path, ("controller",)).controller
    try:
        made = make(robot)
    except Exception as error:
        raise ConfigError(f"controller(robot) in '{path}' fails: {type(error).__name__}: {error}") from error
    missing = [name for name in ("name", "gains", "initial_state", "step") if not hasattr(made, name)]
    if missing:
        raise ConfigError(f"controller(robot) in '{path}' returns an object without {', '.join(missing)}")
    return made


def resolved_tables(controller: Controller) -> dict[str, Any]:
    """A controller as plain tables for a run's record; only the name for a user's own."""
    return controller.tables() if is_traceable(controller) else {"name": controller.name}
