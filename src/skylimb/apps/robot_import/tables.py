"""Motor and servo tables of the laboratory's packages, found by the names of folders."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from skylimb.base.errors import DescriptionError
from skylimb.base.sources import read_source
from skylimb.base.yaml_text import read_yaml

_STEP = 1e-3
"""Time step that `rotor_damping_rate` counts in, s."""
_REFERENCE = re.compile(r"ref\d+")


@dataclass(frozen=True)
class MotorTable:
    """What a motor table says; None where it does not.

    Attributes:
        file: its name.
        thrust_max: N, at a middle voltage.
        voltage: that one, V.
        drag_torque_coefficient: m, without sign.
        thrust_min: N.
        lag: s.
    """

    file: str
    thrust_max: float | None
    voltage: float | None
    drag_torque_coefficient: float | None
    thrust_min: float | None
    lag: float | None


class LabTables(NamedTuple):
    """Of motors; and of simulated servos by group ("joints", "gimbals").

    A servo's is its stiffness (N m/rad) and damping (N m s/rad; 0 for none).
    """

    motors: MotorTable
    servos: Mapping[str, tuple[float, float]]


def find_tables(urdf: Path, packages: Mapping[str, Path]) -> LabTables:
    """The tables of a description, empty where there are none.

    A table belongs to it where the folder is called like the description or its folder:
    `robots/quad/NAME/robot.urdf.xacro` and `config/quad/NAME/MotorInfo.yaml`.

    Raises:
        DescriptionError: a table that is no YAML.
    """
    names = [urdf.name.partition(".")[0], urdf.parent.name]
    package = next((folder for folder in packages.values() if urdf.is_relative_to(folder)), None)
    motors = _first(package, names, "MotorInfo.yaml")
    servos = _first(package, names, "Servo.yaml")
    return LabTables(_motor_table(motors), _servo_tables(servos))


def _first(package: Path | None, names: list[str], file: str) -> Path | None:
    found = sorted(package.glob(f"config/**/{file}")) if package else []
    return next((path for name in names for path in found if path.parent.name == name), None)


def _motor_table(path: Path | None) -> MotorTable:
    table = _read(path, "motor_info")
    entries = [entry for name, entry in table.items() if _REFERENCE.fullmatch(str(name))]
    entries = [entry for entry in entries if _number(entry, "max_thrust")]
    entries.sort(key=lambda entry: _number(entry, "voltage") or 0.0)
    middle = entries[(len(entries) - 1) // 2] if entries else {}
    thrust, least = _number(middle, "max_thrust"), _number(table, "min_thrust")
    kappa, rate = _number(table, "m_f_rate"), _number(table, "rotor_damping_rate")
    # Two fans share a thrust link where the table has the noise of two; it counts one fan.
    fans = 2.0 if "dual_rotor_moment_noise" in table else 1.0
    return MotorTable(
        path.name if path else "",
        None if thrust is None else fans * thrust,
        _number(middle, "voltage"),
        None if kappa is None else abs(kappa),
        None if least is None else max(0.0, fans * least),
        _STEP / rate - _STEP if rate is not None and 0.0 < rate < 1.0 else None,
    )


def _servo_tables(path: Path | None) -> dict[str, tuple[float, float]]:
    found = {}
    for group, entry in _read(path, "servo_controller").items():
        gains = _table(_table(entry, "simulation"), "pid")
        p, d = _number(gains, "p"), _number(gains, "d")
        if p is not None and p > 0.0:
            found[str(group)] = p, max(0.0, d or 0.0)
    return found


def _read(path: Path | None, key: str) -> dict[str, Any]:
    """A table of a file; an empty one without a file."""
    if path is None:
        return {}
    try:
        content = read_yaml(read_source(path).content)
    except ValueError as error:
        raise DescriptionError(f"'{path}' is no YAML: {error}") from None
    return _table(content, key)


def _table(content: Any, key: str) -> dict[str, Any]:
    """A table in a table; an empty one where either is none."""
    table = content.get(key) if isinstance(content, dict) else None
    return table if isinstance(table, dict) else {}


def _number(content: Any, key: str) -> float | None:
    """A number in a table; None where either is none."""
    value = content.get(key) if isinstance(content, dict) else None
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
