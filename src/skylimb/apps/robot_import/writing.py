"""A checked description written as a robot of skylimb's: URDF, flight TOML, meshes and findings."""

from __future__ import annotations

import collections.abc
from dataclasses import replace
from pathlib import Path

import tomli_w

from skylimb.apps.robot_import.checking import RobotReport, check_robot_file, flight_tables
from skylimb.apps.robot_import.mapping import Mapping, Role
from skylimb.apps.robot_import.picture import draw_robot
from skylimb.apps.robot_import.proposal import URDF_NAME
from skylimb.apps.robot_import.report import report_text
from skylimb.base.errors import DescriptionError
from skylimb.base.files import new_folder, require_new
from skylimb.base.sources import read_source
from skylimb.robots.flight_file import FlightFile
from skylimb.robots.links_file import links_text
from skylimb.robots.loader import FLIGHT_FILE, describe
from skylimb.robots.urdf import read_urdf

CHECK, PICTURE, MAPPING = "check.txt", "robot.png", "mapping.toml"


def import_robot(
    path: str | Path,
    out: str | Path,
    packages: str | Path | None = None,
    mapping: str | Path | Mapping | None = None,
    *,
    args: collections.abc.Mapping[str, str] | None = None,
    mend: bool = False,
) -> RobotReport:
    """Check a description and write it as a robot that `load_robot` and `--set robot=DIR` take.

    A new folder gets `robot.urdf`, its links and joints as data, `flight.toml`, `meshes/`, `check.txt` with
    the findings, `robot.png`, and `mapping.toml`, a draft of what can be said otherwise.

    Args:
        path: as `check_robot_file`.
        out: the new folder.
        packages: as `check_robot_file`.
        mapping: as `check_robot_file`.
        args: as `check_robot_file`.
        mend: as `check_robot_file`.

    Raises:
        SkylimbError: the description cannot be read, or the folder cannot be written.
    """
    require_new(out)
    report = check_robot_file(path, packages, mapping, args=args, mend=mend, convert=True)
    if report.flight is None:
        raise DescriptionError(f"'{path}' is a robot of skylimb's form already; copy its folder")
    with new_folder(out) as folder:
        (folder / URDF_NAME).write_bytes(report.urdf)
        (folder / FLIGHT_FILE).write_text(_flight_text(report.flight, report), encoding="utf-8")
        (folder / MAPPING).write_text(mapping_text(report.flight, report.roles), encoding="utf-8")
        (folder / CHECK).write_text(report_text(report) + "\n", encoding="utf-8")
        for name, content in report.meshes.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(content)
        urdf = read_source(folder / URDF_NAME)
        tree = read_urdf(urdf)
        links = links_text(urdf, None, tree, urdf.path.parent)
        (folder / URDF_NAME).with_suffix(".links.json").write_text(links, encoding="utf-8")
        # Meshes that were turned into another kind are drawn as well, and a robot that cannot be is, too.
        drawn = describe(report.flight, read_source(folder / FLIGHT_FILE), urdf, tree)
        draw_robot(replace(report, description=drawn), folder / PICTURE)
    return report


def _flight_text(flight: FlightFile, report: RobotReport) -> str:
    doubts = "".join(f"# - {doubt}\n" for doubt in report.doubts)
    return (
        f"# What the URDF beside this file cannot say about {flight.name}; made from {report.path.name} by "
        "`skylimb robot import`.\n# Units: m, kg, N, N m, s, rad.\n"
        + (f"# What is doubtful or assumed:\n{doubts}" if doubts else "")
        + f"\n{tomli_w.dumps(flight_tables(flight))}"
    )


def mapping_text(flight: FlightFile, roles: collections.abc.Mapping[str, Role]) -> str:
    """A mapping file that says what was recognised or proposed, to be changed and handed to --mapping.

    Args:
        flight: as it was proposed.
        roles: of all joints that move in the file, by name: one that is left out would be guessed anew.
    """
    tables = flight_tables(flight)
    shape, vectoring = tables.get("shape", {}), tables.get("vectoring", {})
    known = {
        "name": flight.name,
        "shape_servo": shape.get("servo"),
        "vectoring_servo": vectoring.get("servo"),
        "vectoring_start": vectoring.get("start"),
        "tip": tables["tip"],
        "imu": tables.get("imu"),
        "posture": tables.get("posture"),
        "joints": [{"name": name, "role": role} for name, role in roles.items()],
        "rotors": tables["rotors"],
    }
    said = {key: value for key, value in known.items() if value is not None}
    return (
        "# Change what is wrong and import again with --mapping. What is left out is proposed anew.\n"
        "# Roles of joints: shape (bends the robot), vectoring (turns rotors), rotor (spins),\n"
        "# locked (held at zero).\n"
        "# Thrust acts along z of a rotor's link, turned by rpy; spin is 1 where it turns about +z.\n\n"
        + tomli_w.dumps(said)
    )
