"""The lab's own YAML files of a robot: motors, servos and its kind, as its launch files load them.

    motor_info: {min_pwm, max_pwm, force_landing_thrust, pwm_conversion_mode, vel_ref_num, ref1: {...}, ...}
    servo_controller: {joints: {angle_sgn, angle_scale, zero_point_offset, controller1: {id, name}, ...}, ...}
    uav_model: 17

Each of the three may stand in a file of its own. Other keys are not looked at.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from skylimb.analysis.exchange.messages import Motor, MotorInfo, UavInfo
from skylimb.apps.ros.servos import Servo, Servos
from skylimb.base.config import from_mapping
from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration, refused
from skylimb.base.keys.fields import fields_of
from skylimb.base.sources import read_source
from skylimb.base.yaml_text import read_yaml
from skylimb.robots.model import Robot

MODEL = 17
"""The lab's number of hydrus_xi."""

_KEYS = ("motor_info", "servo_controller", "uav_model")
_DEGREES = 5
_T = TypeVar("_T")


@configuration
class _Motors:
    """What `motor_info` says of all voltages."""

    min_pwm: Annotated[float, Key("", "least duty", low=0.0, high=1.0)]
    max_pwm: Annotated[float, Key("", "greatest duty", low=0.0, high=1.0)]
    force_landing_thrust: Annotated[float, Key("N", "at which a forced landing ends", low=0.0, high=1000.0)]
    pwm_conversion_mode: Annotated[int, Key("", "0: by a square root, 1: by a polynomial", low=0, high=1)]
    vel_ref_num: Annotated[int, Key("", "voltages with a table of their own", low=1, high=10)]
    min_thrust: Annotated[float, Key("N", "least thrust", low=0.0, high=1000.0)] = 0.0

    def check(self) -> None:
        """The flight controller arms only with a range of duty."""
        if self.min_pwm >= self.max_pwm:
            raise refused(self, "max_pwm", f"is not above min_pwm = {self.min_pwm:g}")


@configuration
class _AtVoltage:
    """What `motor_info.refN` says of one voltage."""

    voltage: Annotated[float, Key("V", "of the battery", low=1.0, high=1000.0)]
    # Without one the flight controller takes 0 N for the most that a rotor gives.
    max_thrust: Annotated[float, Key("N", "greatest thrust", low=0.1, high=1000.0)]
    polynominal: Annotated[
        tuple[float, float, float, float, float],
        Key("", "factors from thrust to duty, in rising powers", low=-1e6, high=1e6),
    ]


@configuration
class _Servo:
    """One servo of `servo_controller`; its group says what it does not."""

    name: Annotated[str, Key("", "of its joint")]
    id: Annotated[int, Key("", "number on the bus", low=0, high=255)]
    angle_sgn: Annotated[Literal[1, -1], Key("", "its sense of turn")]
    angle_scale: Annotated[float, Key("rad", "of a count", low=1e-6, high=1.0)]
    zero_point_offset: Annotated[int, Key("", "count at 0 rad", low=-32768, high=32767)]


@configuration
class _Kind:
    """The lab's number of a kind of robot."""

    uav_model: Annotated[int, Key("", "of the kind", low=0, high=255)] = MODEL


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
    motors = _motors(*found["motor_info"]) if "motor_info" in found else None
    servos = _servos(*found["servo_controller"], robot) if "servo_controller" in found else None
    kind = _Kind()
    if "uav_model" in found:
        path, number = found["uav_model"]
        kind = _known(_Kind, {"uav_model": number}, path, "")
    return LabConfig(motors, servos, kind.uav_model)


def _read(path: Path) -> Mapping[str, Any]:
    try:
        content = read_yaml(read_source(path).content)
    except ValueError as error:
        raise ConfigError(f"'{path}' is no YAML: {error}") from None
    return content if isinstance(content, Mapping) else {}


def _known(cls: type[_T], table: Any, path: Path, at: str) -> _T:
    """What the keys of a class are in a file's table; other keys are not looked at."""
    known = table
    if isinstance(table, Mapping):
        known = {key: table[key] for key in fields_of(cls) if key in table}
    return from_mapping(cls, known, f"'{path}'", at)


def _motors(path: Path, table: Any) -> MotorInfo:
    motors = _known(_Motors, table, path, "motor_info")
    voltages = []
    for index in range(motors.vel_ref_num):
        name = f"ref{index + 1}"
        own = _tables(table, path, "motor_info").get(name, {})
        factors = [own.get(f"polynominal{degree}", 0.0) for degree in range(_DEGREES)]
        one = _known(_AtVoltage, {**own, "polynominal": factors}, path, f"motor_info.{name}")
        voltages.append(Motor(one.voltage, one.max_thrust, one.polynominal))
    return MotorInfo(
        motors.min_pwm,
        motors.max_pwm,
        motors.min_thrust,
        motors.force_landing_thrust,
        motors.pwm_conversion_mode,
        tuple(voltages),
    )


def _servos(path: Path, table: Any, robot: Robot) -> Servos:
    found: dict[str, Servo] = {}
    for group, shared in _tables(table, path, "servo_controller").items():
        for key, own in _tables(shared, path, f"servo_controller.{group}").items():
            if str(key).startswith("controller"):
                servo = _known(_Servo, {**shared, **own}, path, f"servo_controller.{group}.{key}")
                scale = servo.angle_sgn * servo.angle_scale
                found[servo.name] = Servo(servo.id, scale, servo.zero_point_offset)
    return Servos(robot, found)


def _tables(table: Any, path: Path, at: str) -> Mapping[Any, Mapping[str, Any]]:
    """The tables in a table."""
    if not isinstance(table, Mapping):
        raise ConfigError(f"'{path}': {at} is no table")
    return {key: inside for key, inside in table.items() if isinstance(inside, Mapping)}
