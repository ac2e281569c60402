"""What a calibration found, in a controller's own model: of its robot, its measurements and its commands.

    measurement, turned back -> cascade with the robot as it really is -> thrusts, as the rotors need them

The centre of gravity belongs to the model. The misalignment is taken off every measured attitude, and every
commanded thrust is divided by its rotor's scale. Latency and lag are gains of laws that have them.
"""

from __future__ import annotations

import copy
import dataclasses
import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Protocol

import numpy as np

from skylimb.base.config import from_mapping, parse_toml, put, to_mapping
from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, Vector3, configuration
from skylimb.base.rotations import quaternion_product
from skylimb.base.sources import read_source
from skylimb.control.estimation.records import Measurement
from skylimb.control.laws.preset import DEFAULT_LAWS, law_folder
from skylimb.control.laws.slots import find_law, keys_of_law
from skylimb.control.records import Command
from skylimb.robots.description import Rotor
from skylimb.robots.links import Inertial, Link
from skylimb.robots.model import Robot

FORMAT = "skylimb calibration"

CALIBRATION = "calibration"
"""A controller's table with what a calibration found."""

GAINS = {"latency": "estimation.delay.latency", "rotor_lag": "allocation.rotor_lag.time_constant"}
"""Keys of laws that a calibration sets, by its own names."""


@configuration
class Corrections:
    """The part of a calibration that a controller uses."""

    robot: Annotated[str, Key("", "name of the robot that it was made for")]
    robot_digest: Annotated[str, Key("", "digest of that robot's description")]
    attitude_misalignment: Annotated[
        Vector3, Key("rad", "rotation vector from the true to the measured body axes", low=-0.5, high=0.5)
    ] = (0.0, 0.0, 0.0)
    cog_offset: Annotated[
        Vector3, Key("m", "true less described centre of gravity, root link's axes", low=-0.3, high=0.3)
    ] = (0.0, 0.0, 0.0)
    rotor_scale: Annotated[
        tuple[float, ...],
        Key("", "true over commanded thrust of each rotor; empty for ones", low=0.2, high=2.0),
    ] = ()
    rotor_lag: Annotated[
        float, Key("s", "time constant of the thrusts; negative keeps the controller's", low=-1.0, high=1.0)
    ] = -1.0
    latency: Annotated[
        float, Key("s", "age of a measurement; negative keeps the controller's", low=-1.0, high=0.2)
    ] = -1.0


def read_corrections(path: str | Path) -> Corrections:
    """The corrections in a calibration.toml.

    Raises:
        ConfigError: when it cannot be read, is no calibration, or has a value that no robot can have.
    """
    tables = parse_toml(read_source(path), path)
    if tables.get("format") != FORMAT:
        raise ConfigError(f"'{path}' is no calibration: format = {tables.get('format')!r}, not '{FORMAT}'")
    names = [one.name for one in dataclasses.fields(Corrections)]
    values: dict[str, Any] = {}
    for name in names:
        found = tables.get(name)
        if name in ("robot", "robot_digest"):
            values[name] = found
        elif not isinstance(found, Mapping) or "value" not in found:
            raise ConfigError(f"'{path}' has no table [{name}] with a value")
        else:
            # Files of before corrected by all that they had.
            values[name] = found.get("used", found["value"])
    return from_mapping(Corrections, values, str(path))


class HasCorrections(Protocol):
    """What knows its corrections, such as the result of `skylimb.calibrate`."""

    @property
    def corrections(self) -> Corrections:
        """What a controller uses of it."""
        ...


Calibrated = str | Path | Corrections | HasCorrections
"""A calibration: a calibration.toml, or what `skylimb.calibrate` returned."""


def corrections_of(given: Calibrated) -> Corrections:
    """The corrections of a calibration at hand or in a file."""
    if isinstance(given, Corrections):
        return given
    if isinstance(given, str | Path):
        return read_corrections(given)
    return given.corrections


def require_made_for(robot: Robot, corrections: Corrections) -> None:
    """Raise a `ConfigError` unless a calibration was made for this robot, as it is described now."""
    if corrections.robot != robot.name:
        raise ConfigError(
            f"the calibration was made for robot '{corrections.robot}'; '{robot.name}' needs one of its own"
        )
    if corrections.robot_digest != robot.description.digest:
        raise ConfigError(
            f"the calibration was made for another description of robot '{robot.name}'; calibrate it again"
        )
    if corrections.rotor_scale and len(corrections.rotor_scale) != robot.n_rotors:
        raise ConfigError(
            f"the calibration has {len(corrections.rotor_scale)} rotor scales; '{robot.name}' has "
            f"{robot.n_rotors} rotors"
        )


def believed_robot(robot: Robot, corrections: Corrections) -> Robot:
    """The robot with its centre of gravity where it was found, and with what its rotors really can.

    The root link's centre of mass moves, as in `plant.cog_offset`. Equal calibrations share one model, so
    that their flights share a compiled tick.
    """
    scales = tuple(corrections.rotor_scale) or (1.0,) * robot.n_rotors
    return _believed(robot, tuple(corrections.cog_offset), scales)


@functools.lru_cache(maxsize=64)
def _believed(robot: Robot, cog_offset: Vector3, scales: tuple[float, ...]) -> Robot:
    description = robot.description
    offset = np.asarray(cog_offset) * robot.mass

    def moved(link: Link) -> Link:
        if link.name != description.root:
            return link
        inertial = link.inertial
        return dataclasses.replace(
            link, inertial=Inertial(inertial.mass, inertial.com + offset / inertial.mass, inertial.inertia)
        )

    def able(rotor: Rotor, scale: float) -> Rotor:
        return dataclasses.replace(
            rotor, thrust_min=rotor.thrust_min * scale, thrust_max=rotor.thrust_max * scale
        )

    rotors = tuple(able(rotor, scale) for rotor, scale in zip(description.rotors, scales, strict=True))
    return Robot(dataclasses.replace(description, links=tuple(map(moved, description.links)), rotors=rotors))


def turned_back(corrections: Corrections, measurement: Measurement) -> Measurement:
    """The measurement with its attitude as the body's axes really are."""
    e = np.asarray(corrections.attitude_misalignment, dtype=float)
    size = float(np.sqrt(1.0 + 0.25 * (e @ e)))
    back = np.concatenate([[1.0], -0.5 * e]) / size
    return measurement._replace(quaternion=quaternion_product(measurement.quaternion, back))


def for_rotors(corrections: Corrections, command: Command) -> Command:
    """The command that makes the rotors give the thrusts that are wanted."""
    if not corrections.rotor_scale:
        return command
    return command._replace(thrusts=command.thrusts / np.asarray(corrections.rotor_scale))


def with_corrections(preset: Mapping[str, Any], path: Path, corrections: Corrections) -> dict[str, Any]:
    """A preset's tables with a calibration: what its laws have as gains stands among those.

    Args:
        preset: the tables.
        path: their file, which says where a law given by path is sought (`preset.law_folder`).
        corrections: what was found.
    """
    tables: dict[str, Any] = {**copy.deepcopy(dict(preset)), CALIBRATION: correction_table(corrections)}
    for name, key in GAINS.items():
        slot, _, rest = key.partition(".")
        law = str(tables.get(slot, {}).get("law", DEFAULT_LAWS.get(slot)))
        value = float(getattr(corrections, name))
        if value >= 0.0 and rest in keys_of_law(find_law(slot, law, law_folder(path))):
            put(tables, key, value)
    return tables


def correction_table(corrections: Corrections) -> dict[str, Any]:
    """The corrections as a controller's table; what has become a gain stands among the gains."""
    return to_mapping(dataclasses.replace(corrections, rotor_lag=-1.0, latency=-1.0))
