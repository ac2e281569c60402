"""The lab's own YAML files of a robot: motors, servos and its kind, as its launch files load them.

    motor_info: {min_pwm, max_pwm, force_landing_thrust, pwm_conversion_mode, vel_ref_num, ref1: {...}, ...}
    servo_controller: {joints: {angle_sgn, angle_scale, zero_point_offset, controller1: {id, name}, ...}, ...}
    uav_model: 17

Each of the three may stand in a file of its own. Other keys are not looked at.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.messages import Motor, MotorInfo, UavInfo
from skylimb.apps.ros1.servos import Servo, Servos
from skylimb.base.errors import ConfigError
from skylimb.base.sources import read_source
from skylimb.robots.model import Robot

MODEL = 17
"""The lab's number of hydrus_xi."""

_KEYS = ("motor_info", "servo_controller", "uav_model")
_DEGREES = 5


@dataclass(frozen=True)
class LabConfig:
    """What the robot's own files say.

    Attributes:
        motors: for `motor_info`; None where no file says.
        servos: between angles and counts; None where no file says.
        model: the lab's number of the robot's kind.
    """

    motors: MotorInfo | None = None
    servos: Servos | None = None
    model: int = MODEL

    def uav(self, robot: Robot) -> UavInfo:
        """For `uav_info`."""
        return UavInfo(robot.n_rotors, self.model)


def read_lab_config(paths: Iterable[str | Path], robot: Robot) -> LabConfig:
    """What some files say of a robot.

    Raises:
        ConfigError: for a file that is no YAML, has none of the three keys or one that another has, lacks an
            entry, or has one that cannot be; for servos of a joint that is not there.
    """
    found: dict[str, tuple[Path, Any]] = {}
    for path in map(Path, paths):
        table = _read(path)
        keys = [key for key in _KEYS if key in table]
        if not keys:
            raise ConfigError(f"'{path}' has none of {', '.join(_KEYS)}")
        for key in keys:
            if key in found:
                raise ConfigError(f"'{path}' and '{found[key][0]}' both have {key}")
            found[key] = path, table[key]
    motors = _motors(_Entry(*found["motor_info"], "motor_info")) if "motor_info" in found else None
    servos = None
    if "servo_controller" in found:
        servos = _servos(_Entry(*found["servo_controller"], "servo_controller"), robot)
    model = MODEL
    if "uav_model" in found:
        path, value = found["uav_model"]
        model = _Entry(path, {"uav_model": value}, "").whole("uav_model", 0, 255)
    return LabConfig(motors, servos, model)


class _Entry:
    """A table of a file; what is wrong in it is said with its place."""

    def __init__(self, path: Path, content: Any, place: str) -> None:
        self._path, self._place = path, place
        if not isinstance(content, Mapping):
            raise ConfigError(f"'{path}': {place} is no table")
        self.content = {str(key): value for key, value in content.items()}

    def error(self, key: str, words: str) -> ConfigError:
        return ConfigError(f"'{self._path}': {self._name(key)} {words}")

    def _name(self, key: str) -> str:
        return f"{self._place}.{key}" if self._place else key

    def table(self, key: str) -> _Entry:
        if key not in self.content:
            raise self.error(key, "is missing")
        return _Entry(self._path, self.content[key], self._name(key))

    def number(self, key: str, low: float, high: float, default: float | None = None) -> float:
        value = self.content.get(key, default)
        if value is None:
            raise self.error(key, "is missing")
        if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
            raise self.error(key, f"= {value!r} is outside of {low:g} .. {high:g}")
        return float(value)

    def whole(self, key: str, low: int, high: int, default: int | None = None) -> int:
        value = self.number(key, low, high, default)
        if value != int(value):
            raise self.error(key, f"= {value:g} is no whole number")
        return int(value)


def _read(path: Path) -> Mapping[str, Any]:
    import yaml

    try:
        content = yaml.safe_load(read_source(path).content)
    except (yaml.YAMLError, UnicodeDecodeError, ValueError, RecursionError) as error:
        raise ConfigError(f"'{path}' is no YAML: {' '.join(str(error).split())[:200]}") from None
    return content if isinstance(content, Mapping) else {}


def _motors(entry: _Entry) -> MotorInfo:
    low, high = entry.number("min_pwm", 0.0, 1.0), entry.number("max_pwm", 0.0, 1.0)
    if low >= high:
        # The flight controller arms only with a range of duty.
        raise entry.error("max_pwm", f"= {high:g} is not above min_pwm = {low:g}")
    motors = []
    for index in range(1, entry.whole("vel_ref_num", 1, 10) + 1):
        one = entry.table(f"ref{index}")
        polynomial = tuple(one.number(f"polynominal{degree}", -1e6, 1e6, 0.0) for degree in range(_DEGREES))
        # Without one the flight controller takes 0 N for the most that a rotor gives.
        greatest = one.number("max_thrust", 0.1, 1000.0)
        motors.append(Motor(one.number("voltage", 1.0, 1000.0), greatest, polynomial))
    return MotorInfo(
        low,
        high,
        entry.number("min_thrust", 0.0, 1000.0, 0.0),
        entry.number("force_landing_thrust", 0.0, 1000.0),
        entry.whole("pwm_conversion_mode", 0, 1),
        tuple(motors),
    )


def _servos(entry: _Entry, robot: Robot) -> Servos:
    found: dict[str, Servo] = {}
    for group in entry.content:
        if not isinstance(entry.content[group], Mapping):
            continue
        table = entry.table(group)
        for key in table.content:
            if not key.startswith("controller"):
                continue
            one = table.table(key)
            own = _Entry(one._path, {**table.content, **one.content}, one._place)
            name = str(own.content.get("name", ""))
            scale = own.number("angle_scale", 1e-6, 1.0)
            sign = own.whole("angle_sgn", -1, 1)
            if sign == 0:
                raise own.error("angle_sgn", "= 0 is neither 1 nor -1")
            zero = own.whole("zero_point_offset", -32768, 32767)
            found[name] = Servo(own.whole("id", 0, 255), math.copysign(scale, sign), zero)
    return Servos(robot, found)
