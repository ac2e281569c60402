"""From a robot's name or path to a checked `Robot`."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from skylimb.base.config import from_mapping, parse_toml, read_toml
from skylimb.base.errors import ConfigError, DescriptionError, UnreadableError, unknown_name
from skylimb.base.plugins import added_file, added_names
from skylimb.base.rotations import rotation_from_rpy
from skylimb.base.sources import Source, read_source
from skylimb.robots.description import (
    GRAVITY,
    NO_SERVO,
    Mount,
    PostureFamily,
    RobotDescription,
    Rotor,
    Servo,
    Servos,
    Tip,
)
from skylimb.robots.extent import drawn_radius
from skylimb.robots.flight_check import bounded, check_robot
from skylimb.robots.flight_file import (
    FlightFile,
    PostureSection,
    RotorSection,
    ShapeSection,
    TipSection,
    VectoringSection,
)
from skylimb.robots.links import Link
from skylimb.robots.links_file import Tree, tree_of
from skylimb.robots.model import Robot
from skylimb.robots.urdf import clean_rotation
from skylimb.robots.validation import check_description

FLIGHT_FILE = "flight.toml"
SHIPPED = Path(__file__).parent
"""Folder with a folder for each robot that comes with the package."""
_Z_OUT = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""A frame whose x axis lies along z of another, and whose y axis is the same."""
_LONGEST_NAME = 200
"""Letters of a file's name at most; most file systems end at 255 bytes."""
_FOREIGN = (".urdf", ".xacro", ".xml", ".sdf")
_IMPORT = "skylimb robot import {path} --out FOLDER makes one"


def list_robots() -> dict[str, str]:
    """The robots that come with the package, each with one line about it."""
    files = sorted(SHIPPED.glob(f"*/{FLIGHT_FILE}"))
    return {path.parent.name: str(read_toml(path).get("summary", "")) for path in files}


def load_robot(name_or_path: str | Path, gravity: float = GRAVITY) -> Robot:
    """The robot of that name, or of a user's own pair of files.

    Args:
        name_or_path: a name that `list_robots` knows; or the path of a flight TOML, which names its URDF
            beside it; or a folder with a `flight.toml`.
        gravity: of the place where it flies, m/s^2.

    Raises:
        UnknownNameError: no robot of that name comes with the package.
        ConfigError: the flight TOML is missing, unreadable, or has an unknown key, a wrong type or a value
            out of range.
        DescriptionError: the two files do not describe a robot that can exist and fly.
        AllocationError: the rotors cannot command a thrust and three torques.
    """
    return _load_unchanged(*_read(_flight_path(name_or_path)), gravity)


def load_flight_file(name_or_path: str | Path) -> FlightFile:
    """The flight TOML of a robot, as `load_robot` finds it, its keys checked but not its URDF.

    Raises:
        UnknownNameError: no robot of that name comes with the package.
        ConfigError: the file is missing, unreadable, or has an unknown key, a wrong type or a value out of
            range.
    """
    return _flight_file(read_source(_flight_path(name_or_path)))


@lru_cache(maxsize=16)
def _load_unchanged(flight: Source, urdf: Source, gravity: float) -> Robot:
    robot = Robot(dataclasses.replace(_describe(flight, urdf), gravity=gravity))
    check_robot(robot)
    return bounded(robot)


def read_description(name_or_path: str | Path) -> RobotDescription:
    """What the files say, checked link by link, without the model being built (see `load_robot`)."""
    return _describe(*_read(_flight_path(name_or_path)))


def _flight_path(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if any(len(part) > _LONGEST_NAME for part in path.parts):  # the operating system refuses to look
        raise unknown_name("robot", str(name_or_path), list_robots())
    if path.is_dir():
        if (path / FLIGHT_FILE).is_file():
            return path / FLIGHT_FILE
        raise DescriptionError(f"the folder '{path}' has no {FLIGHT_FILE} ({_IMPORT.format(path=path)})")
    is_path = path.suffix != "" or len(path.parts) > 1
    if path.suffix.lower() in _FOREIGN:
        raise ConfigError(
            f"'{path}' is no robot yet; name the flight TOML that points to it, or its folder "
            f"({_IMPORT.format(path=path)})"
        )
    if is_path:
        return path
    ships = bool(path.name) and (SHIPPED / path / FLIGHT_FILE).is_file()
    file = added_file("robots", str(name_or_path), ships)
    if file is None and not ships:
        raise unknown_name("robot", str(name_or_path), [*list_robots(), *added_names("robots")])
    return file or SHIPPED / path / FLIGHT_FILE


def _read(path: Path) -> tuple[Source, Source]:
    """The flight TOML and the URDF that it names."""
    flight = read_source(path)
    try:
        return flight, read_source(flight.path.parent / _flight_file(flight).urdf)
    except UnreadableError as error:
        raise DescriptionError(str(error)) from None


def _flight_file(source: Source) -> FlightFile:
    return from_mapping(FlightFile, parse_toml(source), str(source.path))


def _servos(servo: Servo, joints: tuple[str, ...], where: str) -> Servos:
    """What the flight file says of the servos of some joints; `where` is its key there."""
    numbers = dict[str, np.ndarray]()
    for key, value in vars(servo).items():
        if isinstance(value, tuple) and len(value) != len(joints):
            raise DescriptionError(
                f"{where}.{key} has {len(value)} numbers for {len(joints)} joints ({', '.join(joints)}); "
                "give one for each, or a single number for all"
            )
        numbers[key] = np.broadcast_to(np.asarray(value, dtype=float), len(joints))
    return Servos(**numbers)


def _digest(*sources: Source) -> str:
    total = hashlib.sha256()
    for source in sources:
        # The same text with other line ends is the same description.
        total.update(source.content.replace(b"\r\n", b"\n"))
        total.update(b"\0")
    return total.hexdigest()


def _describe(flight_source: Source, urdf: Source) -> RobotDescription:
    flight = _flight_file(flight_source)
    description = describe(flight, flight_source, urdf, tree_of(urdf, flight.root_link))
    check_description(description)
    return description


def describe(flight: FlightFile, flight_source: Source, urdf: Source, tree: Tree) -> RobotDescription:
    """What the two files say together; whether such a robot can exist is not checked here.

    Args:
        flight: what the flight TOML says.
        flight_source: that file.
        urdf: the other one.
        tree: what stands in the URDF.

    Raises:
        UnknownNameError: the flight file names a link or joint that is not there.
    """
    root, links, joints = tree
    _require_known("measured_link", [flight.measured_link], [link.name for link in links])
    _require_known("tip.link", [flight.tip.link], [link.name for link in links])
    _require_known("imu.link", [flight.imu.link] if flight.imu else [], [link.name for link in links])
    _require_known("rotors.link", [rotor.link for rotor in flight.rotors], [link.name for link in links])
    moving = [joint.name for joint in joints if joint.kind != "fixed"]
    shape = flight.shape or ShapeSection((), NO_SERVO)
    vectoring = flight.vectoring or VectoringSection((), NO_SERVO, ())
    posture = flight.posture or PostureSection((), (), 0.0, 1.0, 0.0)
    _require_known("shape.joints", shape.joints, moving)
    _require_known("vectoring.joints", vectoring.joints, moving)
    return RobotDescription(
        name=flight.name,
        summary=flight.summary,
        root=root,
        links=links,
        joints=joints,
        rotors=tuple(_rotor(section, index, links) for index, section in enumerate(flight.rotors)),
        shape_joints=shape.joints,
        vectoring_joints=vectoring.joints,
        shape_servos=_servos(shape.servo, shape.joints, "shape.servo"),
        vectoring_servos=_servos(vectoring.servo, vectoring.joints, "vectoring.servo"),
        vectoring_start=np.array(vectoring.start, dtype=float),
        tip=Tip(
            flight.tip.link,
            np.array(flight.tip.position, dtype=float),
            flight.tip.radius,
            None if flight.tip.stem is None else np.array(flight.tip.stem, dtype=float),
            flight.tip.heading or "tool",
            tool_rotation(flight.tip),
        ),
        posture=PostureFamily(
            np.array(posture.offset, dtype=float),
            np.array(posture.slope, dtype=float),
            posture.theta_min,
            posture.theta_max,
            posture.theta_nominal,
            posture.contact_side,
        ),
        measured_link=flight.measured_link,
        digest=_digest(flight_source, urdf),
        folder=flight_source.path.parent,
        sources=(flight_source, urdf),
        imu_mount=flight.imu and Mount(flight.imu.link, *_pose(flight.imu.xyz, flight.imu.rpy)),
    )


def _require_known(key: str, names: Iterable[str], known: Sequence[str]) -> None:
    for name in names:
        if name not in known:
            kind = "moving joint" if key.endswith("joints") else "link"
            raise unknown_name(f"{kind} in {key}", name, known)


def _pose(xyz: Sequence[float], rpy: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    return np.array(xyz, dtype=float), clean_rotation(rotation_from_rpy(*rpy))


def tool_rotation(tip: TipSection) -> np.ndarray:
    """Orientation (3, 3) of a tool in its link's frame, its x axis out."""
    R = rotation_from_rpy(*(tip.rpy or (0.0, 0.0, 0.0)))
    return clean_rotation(R @ _Z_OUT if tip.forward == "z" else R)


def _rotor(section: RotorSection, index: int, links: Sequence[Link]) -> Rotor:
    xyz, R = _pose(section.xyz, section.rpy)
    radius = section.radius or drawn_radius(links, section.link, xyz, R[:, 2])
    return Rotor(
        name=section.name or f"rotor{index + 1}",
        link=section.link,
        xyz=xyz,
        R=R,
        spin=section.spin,
        # A rotor that turns about +z is dragged about -z, and so is the body it sits on.
        drag_torque_coefficient=-section.spin * section.drag_torque_coefficient,
        thrust_min=section.thrust_min,
        thrust_max=section.thrust_most,
        lag=section.lag,
        thrust_factor=section.thrust_factor,
        inertia=section.inertia,
        torque_max=section.torque_max,
        radius=radius,
    )
