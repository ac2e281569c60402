"""A controller as data: which law fills each slot of the cascade, and with which gains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from skylimb.base.config import flatten, from_mapping, read_toml, to_mapping, with_overrides
from skylimb.base.errors import ConfigError, UnknownNameError, unknown_name
from skylimb.base.keys.key import shown
from skylimb.base.plugins import added_file, added_names
from skylimb.base.signals import Signal
from skylimb.control.laws import Laws
from skylimb.control.laws.fields import require_fit
from skylimb.control.laws.file_kinds import require_kind
from skylimb.control.laws.slots import SLOTS, Slot, Slots, find_law, law_names, right_key
from skylimb.control.needs import Needs, merged

PRESETS = Path(__file__).parents[1] / "presets"
DEFAULT_LAWS = {"estimation": "momentum", "contact": "open", "allocation": "pseudoinverse"}
"""Laws of the slots that a preset may leave out: the paper's."""

ROBOTS, IMU = "robots", "imu"
"""Tables of a preset that say what is different for a robot, by its name, and with an IMU."""

IMU_KEY = "estimation.smoothing.imu"
"""The key by which an IMU does."""


@dataclass(frozen=True)
class Preset:
    """A filled cascade.

    Attributes:
        name: short name, as on the command line.
        description: one line on what it is.
        slots: the law of every slot and its gains.
    """

    name: str
    description: str
    slots: Slots

    @property
    def laws(self) -> Laws:
        """The law of every slot."""
        return Laws(*(slot.law for slot in self.slots))

    @property
    def needs(self) -> Needs:
        """What its laws need of the loop, together."""
        return merged(slot.needs for slot in self.slots)

    @property
    def signals(self) -> dict[str, Signal]:
        """Unit, frame and meaning of the signals that laws in a user's file declare."""
        declared = [getattr(slot.law, "signals", {}) for slot in self.slots]
        return {name: signal for signals in declared for name, signal in signals.items()}

    @property
    def in_python(self) -> dict[str, str]:
        """Laws of its users' that fly in Python, each with the reason why it cannot be compiled."""
        return {
            f"{name} law '{slot.name}'": next(iter(slot.python.values())).why
            for name, slot in zip(SLOTS, self.slots, strict=True)
            if slot.python
        }

    def with_slot(self, slot: str, filled: Slot) -> Preset:
        """The preset with another law in one slot."""
        return Preset(self.name, self.description, self.slots._replace(**{slot: filled}))

    def with_gain(self, key: str, value: Any, where: str) -> Preset:
        """The preset with another value of a gain; a `ConfigError` begins with `where`."""
        slot, _, rest = key.partition(".")
        filled = getattr(self.slots, slot)
        return self.with_slot(
            slot, replace(filled, gains=with_overrides(filled.gains, {rest: value}, where, slot))
        )

    def tables(self) -> dict[str, Any]:
        """The preset as plain tables, which `preset_from_mapping` reads back."""
        filled = zip(SLOTS, self.slots, strict=True)
        tables = {name: {"law": slot.name, **to_mapping(slot.gains)} for name, slot in filled}
        return {"name": self.name, "description": self.description, **tables}


def preset_names() -> list[str]:
    """Names of the presets that ship."""
    return sorted(path.stem for path in PRESETS.glob("*.toml"))


def preset_mapping(name_or_path: str) -> tuple[dict[str, Any], Path]:
    """The preset's TOML as a mapping, and the file it came from; of a controller in Python, its `file`.

    Raises:
        UnknownNameError: when it is neither a controller's name nor a file.
        ConfigError: when the file cannot be read, or is an experiment's.
    """
    path = preset_file(name_or_path)
    if path.suffix == ".py":
        return {"file": path.name}, path
    tables = read_toml(path)
    require_kind(tables, name_or_path, "controller")
    return tables, path


def preset_file(name_or_path: str) -> Path:
    """The TOML or Python file of a controller, by its name or by itself.

    Raises:
        UnknownNameError: when it is neither a controller's name nor such a file.
        ConfigError: when a package adds the name and it is not the package's alone.
    """
    if name_or_path.endswith((".toml", ".py")):
        return Path(name_or_path)
    known = preset_names()
    file = added_file("controllers", name_or_path, name_or_path in known)
    if file is None and name_or_path not in known:
        known += added_names("controllers")
        raise unknown_name("controller", name_or_path, known, (".py", ".toml"))
    return file or PRESETS / f"{name_or_path}.toml"


def law_folder(preset: Path) -> Path:
    """Where a law that a preset names by its file is sought: beside the preset's own file.

    For a preset that ships this is the working directory: nobody's law lies among those of skylimb.
    """
    return Path() if preset.parent == PRESETS else preset.parent


def preset_from_mapping(mapping: Mapping[str, Any], path: Path) -> Preset:
    """A preset from its TOML, every key checked.

    Args:
        mapping: the tables; what they say of single robots or an IMU is left to `of_case`.
        path: their file, which says where a law given by path is sought (`law_folder`).

    Raises:
        ConfigError: naming the key that is unknown, missing or of the wrong kind; or laws that do not fit.
    """
    name = _text(mapping, "name", path.stem, f"controller {path.stem}")
    where = f"controller {name}"
    for key, value in mapping.items():
        if key not in ("name", "description", ROBOTS, IMU, *SLOTS):
            raise _unknown(where, key, value)
    slots = Slots(*(_slot(mapping, slot, path, where) for slot in SLOTS))
    require_fit(slots, where)
    return Preset(name, _text(mapping, "description", "", where), slots)


def of_case(mapping: Mapping[str, Any], names: Sequence[str], imu: bool, where: str) -> dict[str, Any]:
    """What a preset says of one robot, and of an IMU: dotted keys and their values.

    Args:
        mapping: the preset's tables: one below `robots` for each robot or kind that needs others, and `imu`.
        names: of the robot, then of its kind; the first that has a table counts.
        imu: whether an IMU says the motion.
        where: the preset, for error messages.

    Raises:
        ConfigError: when `robots` is no table of tables, or `imu` none.
    """
    robots, with_imu = mapping.get(ROBOTS, {}), mapping.get(IMU, {})
    below = robots.items() if isinstance(robots, dict) else [("", robots)]
    for key, table in [*((f"{ROBOTS}.{key}".rstrip("."), table) for key, table in below), (IMU, with_imu)]:
        if not isinstance(table, dict):
            right = IMU if key == IMU else f"{ROBOTS}.NAME"
            raise ConfigError(f"{where}: {key} = {shown(table)} should be a table, [{right}]")
    own = next((robots[name] for name in names if name in robots), {})
    return flatten(own) | flatten(with_imu if imu else {})


def _slot(mapping: Mapping[str, Any], slot: str, path: Path, where: str) -> Slot:
    table = mapping.get(slot, {})
    law = table.get("law", DEFAULT_LAWS.get(slot)) if isinstance(table, dict) else None
    if law is None:
        raise ConfigError(
            f'{where} needs a table [{slot}] with law = "..." (known: {", ".join(law_names(slot))})'
        )
    module = find_law(slot, str(law), law_folder(path))
    gains = {key: value for key, value in table.items() if key != "law"}
    return Slot(str(law), module, from_mapping(module.Gains, gains, where, slot))


def _unknown(where: str, key: str, value: Any) -> UnknownNameError:
    """The error for a key that is no slot; it names the key's place inside of a slot where there is one."""
    below = f".{next(iter(value))}" if isinstance(value, dict) and value else ""
    right = right_key(key + below)
    if right is None:
        return unknown_name(f"key of {where}", key, ("name", "description", *SLOTS))
    return UnknownNameError(
        f"unknown key 'controller.{key}{below}' of {where}; did you mean 'controller.{right}'?"
    )


def _text(mapping: Mapping[str, Any], key: str, default: str, where: str) -> str:
    value = mapping.get(key, default)
    if not isinstance(value, str):
        raise ConfigError(f"{where}: {key} = {shown(value)} should be a text")
    return value
