"""A controller as data: which law fills each slot of the cascade, and with which gains."""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from skylimb.config import from_mapping, read_toml, require_positive
from skylimb.control.lateral import Vectoring
from skylimb.control.leak import LeakCompensation
from skylimb.errors import ConfigError, unknown_name
from skylimb.estimation.body_state import AngleRateFilter
from skylimb.estimation.calibration import Calibration
from skylimb.estimation.delay import DelayCompensation
from skylimb.estimation.momentum_observer import ObserverGains

PRESETS = Path(__file__).parent / "presets"
SLOTS = ("translation", "attitude", "shape", "contact")
_DEFAULT = {"contact": {"law": "open"}}
_NOT_LAWS = {"target", "machine"}


@dataclass(frozen=True)
class ContactForceFilter:
    """The low pass that makes f_hat of eq:admittance control.

    Attributes:
        cutoff: Hz.
    """

    cutoff: float = 2.0

    def __post_init__(self) -> None:
        require_positive("force_filter", "cutoff", self.cutoff, "Hz")


PARTS: dict[str, type] = {
    "angle_rates": AngleRateFilter,
    "observer": ObserverGains,
    "force_filter": ContactForceFilter,
    "leak": LeakCompensation,
    "calibration": Calibration,
    "delay": DelayCompensation,
    "vectoring": Vectoring,
}
"""Tables of a preset besides the slots."""


@dataclass(frozen=True)
class Slot:
    """One filled slot: the law's module and its gains."""

    name: str
    law: ModuleType
    gains: Any


@dataclass(frozen=True)
class Preset:
    """A filled cascade.

    Attributes:
        name: short name, as on the command line.
        description: one line on what it is.
        translation: what keeps the centre of gravity (control/translation).
        attitude: what keeps the attitude (control/attitude).
        shape: what the arm does (control/shape).
        contact: what is made of the contact (control/contact).
        angle_rates: how the encoders' angles are differenced.
        observer: gains of the momentum observer.
        force_filter: low pass of the contact force.
        leak: compensation of the rotational thrusts' side force.
        tare: whether the observer's free-flight bias is taken off.
        calibration: what else is done with that bias.
        delay: compensation of latency and rotor lag.
        vectoring: which vectoring angles, and whether they move for a side force.
    """

    name: str
    description: str
    translation: Slot
    attitude: Slot
    shape: Slot
    contact: Slot
    angle_rates: AngleRateFilter = field(default_factory=AngleRateFilter)
    observer: ObserverGains = field(default_factory=ObserverGains)
    force_filter: ContactForceFilter = field(default_factory=ContactForceFilter)
    leak: LeakCompensation = field(default_factory=LeakCompensation)
    tare: bool = True
    calibration: Calibration = field(default_factory=Calibration)
    delay: DelayCompensation = field(default_factory=DelayCompensation)
    vectoring: Vectoring = field(default_factory=Vectoring)


def law_names(slot: str) -> list[str]:
    """The laws that ship for a slot: the files of its folder."""
    package = importlib.import_module(f"skylimb.control.{slot}")
    return sorted(
        module.name for module in pkgutil.iter_modules(package.__path__) if module.name not in _NOT_LAWS
    )


def find_law(slot: str, name: str, folder: Path) -> ModuleType:
    """The module of a law, by name or by the path of a user's own file (relative to the preset's folder).

    Raises:
        UnknownNameError: when there is no such law.
        ConfigError: when the file cannot be used as one.
    """
    if name.endswith(".py"):
        return load_module((folder / name).resolve(), ("Gains", "initial_state", "step"))
    if name not in law_names(slot):
        raise unknown_name(f"{slot} law", name, law_names(slot))
    return importlib.import_module(f"skylimb.control.{slot}.{name}")


def load_module(path: Path, needs: tuple[str, ...]) -> ModuleType:
    """A user's Python file as a module, checked to define every name in `needs`.

    Raises:
        ConfigError: when the file is missing, fails to import, or lacks a name.
    """
    if not path.is_file():
        raise ConfigError(f"file '{path}' does not exist")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise ConfigError(f"file '{path}' is not a Python module")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ConfigError(f"file '{path}' fails to import: {type(error).__name__}: {error}") from error
    missing = [name for name in needs if not hasattr(module, name)]
    if missing:
        raise ConfigError(f"file '{path}' does not define {', '.join(missing)} (needed: {', '.join(needs)})")
    return module


def preset_names() -> list[str]:
    """Names of the presets that ship."""
    return sorted(path.stem for path in PRESETS.glob("*.toml"))


def preset_mapping(name_or_path: str) -> tuple[dict[str, Any], Path]:
    """The preset's TOML as a mapping, and the file it came from.

    Raises:
        UnknownNameError: when it is neither a preset's name nor a TOML file.
    """
    if name_or_path.endswith(".toml"):
        path = Path(name_or_path)
        return read_toml(path), path
    if name_or_path not in preset_names():
        raise unknown_name("controller", name_or_path, preset_names())
    path = PRESETS / f"{name_or_path}.toml"
    return read_toml(path), path


def preset_from_mapping(mapping: dict[str, Any], path: Path) -> Preset:
    """A preset from its TOML, every key checked.

    Raises:
        ConfigError: naming the key that is unknown, missing or of the wrong kind.
    """
    name = _typed(mapping, "name", str, path.stem, f"controller {path.stem}")
    where = f"controller {name}"
    allowed = {"name", "description", "tare", *PARTS, *SLOTS}
    for key in mapping:
        if key not in allowed:
            raise unknown_name(f"key of {where}", key, allowed)
    filled: dict[str, Any] = {slot: _slot(mapping, slot, path, where) for slot in SLOTS}
    parts: dict[str, Any] = {
        part: from_mapping(kind, mapping.get(part, {}), f"{where}: {part}") for part, kind in PARTS.items()
    }
    return Preset(
        name=name,
        description=_typed(mapping, "description", str, "", where),
        tare=_typed(mapping, "tare", bool, True, where),
        **parts,
        **filled,
    )


def _slot(mapping: dict[str, Any], slot: str, path: Path, where: str) -> Slot:
    table = mapping.get(slot, _DEFAULT.get(slot))
    if not isinstance(table, dict) or "law" not in table:
        raise ConfigError(
            f'{where} needs a table [{slot}] with law = "..." (known: {", ".join(law_names(slot))})'
        )
    gains = dict(table)
    name = gains.pop("law")
    law = find_law(slot, str(name), path.parent)
    return Slot(str(name), law, from_mapping(law.Gains, gains, f"{where}: {slot}"))


def _typed(mapping: dict[str, Any], key: str, kind: type, default: Any, where: str) -> Any:
    value = mapping.get(key, default)
    if not isinstance(value, kind):
        raise ConfigError(f"{where}: {key} = {value!r} should be a {kind.__name__}")
    return value
