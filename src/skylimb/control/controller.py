"""What a controller is to the loop, and how one is found by name or file."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol, TypeGuard

from skylimb.base.config import flatten, from_mapping, put
from skylimb.base.errors import ConfigError
from skylimb.base.keys import units_of
from skylimb.base.signals import Signal
from skylimb.base.user_modules import load_module, sources_of_module
from skylimb.control.calibrated import calibrated
from skylimb.control.cascade import Cascade, build_cascade
from skylimb.control.corrections import CALIBRATION, Corrections
from skylimb.control.estimation.records import Measurement
from skylimb.control.laws.preset import (
    IMU,
    IMU_KEY,
    ROBOTS,
    law_folder,
    of_case,
    preset_from_mapping,
    preset_mapping,
)
from skylimb.control.laws.slots import find_law, keys_of_law
from skylimb.control.laws.user_controller import (
    CompiledUserController,
    Origin,
    UserController,
    user_controller,
)
from skylimb.control.missions.reference import Reference
from skylimb.control.records import Command
from skylimb.robots.controlled_axes import kind_of
from skylimb.robots.model import Robot


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


ConfigurableController = Cascade | UserController
"""A controller whose gains are keys: they can be set, swept, tuned and recorded by name."""

TraceableController = Cascade | CompiledUserController
"""A controller whose `step` runs on CasADi symbols, so that it can be compiled and written as C."""


def is_configurable(controller: Controller) -> TypeGuard[ConfigurableController]:
    """Whether a controller's gains are keys."""
    return isinstance(controller, ConfigurableController)


def is_traceable(controller: Controller) -> TypeGuard[TraceableController]:
    """Whether a controller can be traced and compiled."""
    return isinstance(controller, TraceableController)


def require_compiled(controller: Controller, what: str) -> TraceableController:
    """The controller itself, no part of which flies in Python.

    Args:
        controller: one that a preset or a user's file makes.
        what: cannot be done with such a part, for example "written as C".

    Raises:
        ConfigError: naming the part, and why it cannot be compiled.
    """
    if not is_traceable(controller):
        raise ConfigError(f"controller '{controller.name}' flies in Python and cannot be {what}")
    for law, why in controller.in_python.items():
        raise ConfigError(f"{law} flies in Python and cannot be {what}: {why}")
    return controller


def load_controller(
    name_or_path: str, robot: Robot, overrides: Mapping[str, Any] | None = None
) -> Controller:
    """A preset by name, a preset in a TOML file, or a user's controller in a Python file.

    A Python file defines `controller(robot)`, which returns an object that follows `Controller`.

    Args:
        name_or_path: "hybrid", "my_gains.toml" or "my_controller.py".
        robot: the model that the controller believes in.
        overrides: dotted keys of its gains and their new values, for example {"translation.damping_ratio":
            [1, 1, 1]}.

    Raises:
        UnknownNameError: when there is no such preset.
        ConfigError: when the file cannot be used, or gains are no dataclass and overrides are given.
    """
    return controller_from_tables(*preset_mapping(name_or_path), robot, overrides)


def controller_from_tables(
    tables: Mapping[str, Any], path: Path, robot: Robot, overrides: Mapping[str, Any] | None = None
) -> Cascade | UserController:
    """A controller from the tables of a preset, or of a user's controller: its `file`, and its gains.

    Arguments are those of `cascade_from_tables`.
    """
    if "file" not in tables:
        return cascade_from_tables(tables, path, robot, overrides)
    gains = {key: value for key, value in tables.items() if key not in ("name", "description", "file")}
    made = _users_controller(str(path.parent / str(tables["file"])), robot)
    return made.with_gains({**gains, **(overrides or {})})


def cascade_from_tables(
    tables: Mapping[str, Any], path: Path, robot: Robot, overrides: Mapping[str, Any] | None = None
) -> Cascade:
    """A cascade from a preset's tables.

    Args:
        tables: of the preset; what they say of this robot, or of an IMU that an override switches on
            (`preset.of_case`), counts like an override.
        path: their file, which says where a law given by path is sought (`preset.law_folder`).
        robot: the model that the controller believes in.
        overrides: dotted keys and their new values. Where one names another law for a slot, the slot keeps
            those of the preset's keys that the new law has, and takes its defaults for the rest.
    """
    mapping = copy.deepcopy(dict(tables))
    overrides = overrides or {}
    names, imu = (robot.name, kind_of(robot)), bool(overrides.get(IMU_KEY))
    case = of_case(mapping, names, imu, f"controller {path.stem}")
    for table in (ROBOTS, IMU):
        mapping.pop(table, None)
    for changes in (case, overrides):
        _change(mapping, changes, path)
    # A table without a robot is a key in the wrong place, which the preset's check names.
    named = "robot" in mapping.get(CALIBRATION, {})
    found = mapping.pop(CALIBRATION) if named else None
    cascade = build_cascade(robot, preset_from_mapping(mapping, path))
    if found is None:
        return cascade
    return calibrated(
        cascade, robot, from_mapping(Corrections, found, f"controller {path.stem}", CALIBRATION)
    )


def _change(mapping: dict[str, Any], changes: Mapping[str, Any], path: Path) -> None:
    """Write values into a preset's tables; a slot with another law keeps of its keys those that this has."""
    for key in changes:
        slot, _, rest = key.partition(".")
        if rest == "law":
            kept = kept_by_laws(flatten({slot: mapping.get(slot, {})}), changes, law_folder(path))
            mapping[slot] = {}
            for name, gain in kept.items():
                put(mapping, name, gain)
    for key, value in changes.items():
        put(mapping, key, value)


def kept_by_laws(gains: Mapping[str, Any], changes: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Those of some gains that are left where changes name other laws for their slots.

    Args:
        gains: dotted keys and their values.
        changes: dotted keys and their new values.
        folder: a law given by path is sought there.
    """
    kept = dict(gains)
    for key, law in changes.items():
        slot, _, rest = key.partition(".")
        if rest == "law":
            known = {f"{slot}.{name}" for name in keys_of_law(find_law(slot, str(law), folder))}
            kept = {
                name: gain for name, gain in kept.items() if name in known or not name.startswith(f"{slot}.")
            }
    return kept


def _users_controller(file: str, robot: Robot) -> UserController:
    module = load_module(Path(file), ())
    if not hasattr(module, "controller") and hasattr(module, "Gains") and hasattr(module, "step"):
        raise ConfigError(
            f"file '{file}' is a law, not a controller; name it in the slot of a preset, as in [translation] "
            f'law = "{file}", or for one flight: --controller hybrid --set controller.translation.law={file}'
        )
    if not hasattr(module, "controller") and (hasattr(module, "height") or hasattr(module, "closest")):
        raise ConfigError(
            f"file '{file}' is a surface, not a controller; name it in an experiment, as in [surface] kind = "
            f'"{file}", or for one flight: --set surface.kind={file}'
        )
    module = load_module(Path(file), ("controller",))
    origin = Origin(Path(file).as_posix(), module.controller, sources_of_module(module))
    return user_controller(origin.made(robot), robot, origin)


def controller_of(given: Controller, robot: Robot, overrides: Mapping[str, Any] | None = None) -> Controller:
    """A controller at hand: a user's own object is compiled where that can be.

    Args:
        given: a controller of skylimb's, or an object of the user's.
        robot: the model that a user's controller believes in.
        overrides: dotted keys of its gains and their new values.

    Raises:
        ConfigError: when the object lacks something, or has no such gains.
    """
    ready = given if is_configurable(given) else user_controller(given, robot)
    return ready.with_gains(overrides or {})


def resolved_tables(controller: Controller) -> dict[str, Any]:
    """All that a controller was made from as plain tables; only the name where it has no more."""
    return controller.tables() if is_configurable(controller) else {"name": controller.name}


def controller_signals(controller: Controller) -> Mapping[str, Signal]:
    """Unit, frame and meaning of the signals that a controller or its laws declare."""
    return controller.signals if is_configurable(controller) else {}


def controller_units(controller: Controller) -> dict[str, str]:
    """Unit of every gain that has one, by dotted key; empty for a controller that has no such keys."""
    return units_of(controller.key_tables()) if is_configurable(controller) else {}
