"""A robot description held against what can exist and fly; each doubt by name, with value and remedy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from skylimb.apps.robot_import.doubts import Doubt, together
from skylimb.apps.robot_import.findings import (
    collision_doubts,
    faults,
    flight_doubts,
    hover_doubts,
    inertia_doubts,
    rotor_doubts,
)
from skylimb.apps.robot_import.mapping import Mapping as MappingFile
from skylimb.apps.robot_import.mapping import Role, read_mapping
from skylimb.apps.robot_import.mechanics import Actuation, actuation
from skylimb.apps.robot_import.meshes import settle_meshes
from skylimb.apps.robot_import.posture_choice import choose_posture
from skylimb.apps.robot_import.proposal import propose
from skylimb.apps.robot_import.repairs import repair
from skylimb.apps.robot_import.roles import recognise
from skylimb.apps.robot_import.self_collision import SelfCollision, find_self_collisions
from skylimb.apps.robot_import.tables import find_tables
from skylimb.apps.robot_import.thrust_limits import axle_of
from skylimb.apps.robot_import.tree import UrdfTree
from skylimb.apps.robot_import.urdf_text import read_urdf_text
from skylimb.base.errors import SkylimbError
from skylimb.base.sources import Source
from skylimb.robots.description import RobotDescription
from skylimb.robots.flight_check import (
    bounded,
    check_moving_bodies,
)
from skylimb.robots.flight_file import FlightFile, PostureSection
from skylimb.robots.loader import FLIGHT_FILE, describe, list_robots, read_description
from skylimb.robots.model import Robot
from skylimb.robots.turned_rotors import ENOUGH
from skylimb.robots.urdf import read_urdf
from skylimb.robots.validation import check_description

_MASS = 1e-9
"""Mass that an import may gain or lose, kg."""


@dataclass(frozen=True, eq=False)
class RobotReport:
    """What a check found.

    Attributes:
        path: what was checked.
        description: the robot; nothing of it has to be possible.
        mass_in: sum of the masses that the file says, kg.
        actuation: what its rotors can do, None where the model cannot be built.
        collisions: what touches, None where the physics engine refuses the robot.
        doubts: all findings.
        flight: the flight file that was proposed, None for a robot that has one.
        urdf: content of the URDF that goes with it.
        meshes: contents of the meshes that go with it, by their path.
        roles: what each joint that moves in the file was taken for, by its name.
    """

    path: Path
    description: RobotDescription
    mass_in: float
    actuation: Actuation | None
    collisions: SelfCollision | None
    doubts: tuple[Doubt, ...]
    flight: FlightFile | None = None
    urdf: bytes = b""
    meshes: dict[str, bytes] = field(default_factory=dict)
    roles: dict[str, Role] = field(default_factory=dict)

    @property
    def can_hover(self) -> bool:
        """Whether nothing forbids a flight: it can be read, built and held in the air."""
        return not self.reasons

    @property
    def reasons(self) -> tuple[Doubt, ...]:
        """What forbids to hover."""
        return tuple(doubt for doubt in self.doubts if doubt.fatal)

    @property
    def can_touch(self) -> bool:
        """Whether it can hover, and its tip comes first to a surface."""
        return self.can_hover and self.actuation is not None and bool(self.actuation.touch)

    @property
    def mass(self) -> float:
        """Mass of the model, kg."""
        return self.description.mass


def check_robot_file(
    path: str | Path,
    packages: str | Path | None = None,
    mapping: str | Path | MappingFile | None = None,
    *,
    args: Mapping[str, str] | None = None,
    mend: bool = False,
    convert: bool = False,
) -> RobotReport:
    """Check a URDF or xacro file, a folder with one, or a robot of skylimb's own form.

    Args:
        path: .urdf, .xacro, MJCF or SDF, a folder, a flight TOML, or the name of a robot that ships.
        packages: folder of the packages that xacro and meshes name.
        mapping: TOML file that says what names do not tell, or what was read of one.
        args: values of a xacro's arguments by name.
        mend: whether impossible inertias are replaced by the nearest possible ones.
        convert: whether meshes are copied, so that the robot can be written elsewhere.

    Raises:
        SkylimbError: the description cannot be read.
    """
    if _is_ours(path):
        description = read_description(path)
        return _report(Path(path), description, description.mass, [])
    text = read_urdf_text(path, packages, args)
    said = read_mapping(mapping)
    said = replace(said, rotors=said.rotors or text.rotors)
    tree = UrdfTree(text.content, text.path.name)
    tree.hold_stiff()
    mass_in = tree.total_mass()
    roles = recognise(tree, said)
    axles = [axle_of(joint) for joint in roles.spinning]
    tables = find_tables(text.path, text.packages)
    # Before the repairs, which leave links and joints only.
    drag = tree.root.find("m_f_rate")
    doubts = [*roles.doubts, *repair(tree, roles, mend=mend)]
    if drag is not None:
        tree.root.append(drag)
    flight, assumed = propose(tree, roles, axles, said, tables)
    tree.keep_robot_only()
    written = UrdfTree(tree.text(), text.path.name) if convert else tree
    copies, lost = settle_meshes(written, text.path.parent, text.packages, convert=convert)
    if convert:  # what is checked names the meshes where they lie
        settle_meshes(tree, text.path.parent, text.packages, convert=False)
    urdf = Source(text.path, tree.text())
    flight_source = Source(text.path.with_name(FLIGHT_FILE), b"")
    links = read_urdf(urdf)
    description = describe(flight, flight_source, urdf, links)
    doubts += [*assumed, *lost]
    if flight.posture is not None and said.posture is None:
        description, flight = _with_posture(description, flight, doubts)
    report = _report(text.path, description, mass_in, doubts)
    return replace(report, flight=flight, urdf=written.text(), meshes=copies, roles=roles.by_name())


def _is_ours(path: str | Path) -> bool:
    given = Path(path)
    return (
        given.suffix.lower() == ".toml"
        or (given.is_dir() and (given / FLIGHT_FILE).is_file())
        or (str(path) in list_robots() and not given.exists())
    )


def _with_posture(
    description: RobotDescription, flight: FlightFile, doubts: list[Doubt]
) -> tuple[RobotDescription, FlightFile]:
    try:
        check_description(description)
        robot = Robot(description)
        if robot.pairs.n_rotors < ENOUGH:  # no law flies it, however it stands
            return description, flight
        family = choose_posture(robot)
    except SkylimbError:
        return description, flight  # the checks say what is wrong with it
    nominal = np.round(family.offset + family.slope * family.theta_nominal, 3).tolist()
    doubts.append(
        Doubt(
            "the postures",
            f"are not said; joints of {nominal} rad are taken as nominal",
            "say [posture] in a mapping file",
        )
    )
    section = PostureSection(
        tuple(map(float, family.offset)),
        tuple(map(float, family.slope)),
        float(family.theta_min),
        float(family.theta_max),
        float(family.theta_nominal),
    )
    return replace(description, posture=family), replace(flight, posture=section)


def _report(path: Path, description: RobotDescription, mass_in: float, doubts: list[Doubt]) -> RobotReport:
    found = [*doubts, *inertia_doubts(description)]
    if any(rotor.radius is None for rotor in description.rotors):
        unknown = "is neither said nor drawn, so a disc that touches a surface is not seen"
        found.append(Doubt("radius of the rotors", unknown, "say radius in a mapping file"))
    if abs(description.mass - mass_in) > _MASS:
        differ = f"{mass_in:.6f} kg went in and {description.mass:.6f} kg came out"
        found.append(Doubt("mass", differ, "report this", fatal=True))
    if not any(doubt.fatal for doubt in found):
        found += faults(lambda: check_description(description), "the description")
    acting: Actuation | None = None
    collisions: SelfCollision | None = None
    if not any(doubt.fatal for doubt in found):
        robot = Robot(description)
        found += faults(lambda: check_moving_bodies(robot), "a moving body")
        robot = bounded(robot)
        acting = actuation(robot)
        if not any(doubt.fatal for doubt in found):  # else all that follows says the same in other words
            found += [*rotor_doubts(robot), *flight_doubts(robot, acting)]
            try:
                collisions = find_self_collisions(description)
            except SkylimbError as error:
                found.append(Doubt("the simulation", str(error), "look at meshes and inertias", fatal=True))
            else:
                found += collision_doubts(collisions, description.mass)
        if not any(doubt.fatal for doubt in found):
            found += hover_doubts(robot)
    return RobotReport(path, description, mass_in, acting, collisions, together(found))


def flight_tables(flight: FlightFile) -> dict[str, Any]:
    """The flight file as tables for TOML, empty ones left out."""
    from skylimb.base.config import to_mapping

    tables = to_mapping(flight)
    for rotor in tables["rotors"]:
        for key in ("xyz", "rpy"):
            if not any(rotor[key]):
                del rotor[key]
    return tables
