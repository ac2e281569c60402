"""The mapping file: what a user says of a description whose names tell too little."""

from __future__ import annotations

from dataclasses import field
from pathlib import Path
from typing import Annotated, Literal

from skylimb.base.config import from_mapping, parse_toml
from skylimb.base.keys import Key, configuration
from skylimb.base.sources import read_source
from skylimb.robots.description import Servo
from skylimb.robots.flight_file import (
    CurrentLimit,
    ImuSection,
    PostureSection,
    RotorInertia,
    RotorRadius,
    ThrustFactor,
    TipSection,
    TorqueConstant,
    TorqueLimit,
)

_TURN = 6.2832
_Place = tuple[float, float, float]
Role = Literal["shape", "vectoring", "rotor", "locked"]


@configuration
class JointRole:
    """What one moving joint is for."""

    name: Annotated[str, Key("", "joint of the URDF")]
    role: Annotated[
        Role,
        Key("", "shape: bends the robot; vectoring: turns rotors; rotor: spins; locked: held at zero"),
    ]


@configuration
class MappedRotor:
    """One rotor; what is left out is proposed."""

    link: Annotated[str, Key("", "link at which the thrust acts, along its z axis turned by rpy")]
    spin: Annotated[Literal[1, -1] | None, Key("", "1 where it turns about +z, -1 about -z")] = None
    drag_torque_coefficient: Annotated[
        float | None, Key("m", "drag torque per thrust, without sign", low=0.0, high=1.0)
    ] = None
    thrust_min: Annotated[float | None, Key("N", "least thrust", low=0.0, high=1e4)] = None
    thrust_max: Annotated[float | None, Key("N", "greatest thrust", above=0.0, high=1e4)] = None
    lag: Annotated[float | None, Key("s", "time constant of the thrust", above=0.0, high=10.0)] = None
    thrust_factor: ThrustFactor = None
    inertia: RotorInertia = None
    torque_limit: TorqueLimit = None
    current_limit: CurrentLimit = None
    torque_constant: TorqueConstant = None
    radius: RotorRadius = None
    xyz: Annotated[_Place, Key("m", "where the thrust acts, in the link's frame", low=-10.0, high=10.0)] = (
        0.0,
        0.0,
        0.0,
    )
    rpy: Annotated[
        _Place, Key("rad", "roll, pitch and yaw of the rotor in the link's frame", low=-_TURN, high=_TURN)
    ] = (0.0, 0.0, 0.0)


@configuration
class Mapping:
    """A whole mapping file. Whatever is left out is recognised or proposed."""

    name: Annotated[str | None, Key("", "short name of the robot")] = None
    joints: tuple[JointRole, ...] = field(default_factory=tuple)
    rotors: tuple[MappedRotor, ...] = field(default_factory=tuple)
    tip: TipSection | None = None
    imu: ImuSection | None = None
    posture: PostureSection | None = None
    shape_servo: Servo | None = None
    vectoring_servo: Servo | None = None
    vectoring_start: Annotated[
        tuple[float, ...] | None,
        Key("rad", "where the search for vectoring angles begins", low=-12.6, high=12.6),
    ] = None

    def role_of(self, joint: str) -> Role | None:
        """The role that the file gives a joint."""
        return next((entry.role for entry in self.joints if entry.name == joint), None)


def read_mapping(path: str | Path | Mapping | None) -> Mapping:
    """The mapping file of that path; an empty one for None; one that is read already as it is.

    Raises:
        ConfigError: it cannot be read, or has an unknown key, a wrong type or a value out of range.
    """
    if path is None:
        return Mapping()
    if isinstance(path, Mapping):
        return path
    source = read_source(path)
    return from_mapping(Mapping, parse_toml(source), str(source.path))
