"""The verbs about robots of one's own: `robot check` and `robot import`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

from skylimb.apps.cli.arguments import Positional, arg
from skylimb.base.errors import ConfigError

_File = Annotated[
    Positional[str],
    arg(metavar="FILE", help="A .urdf or .xacro file, a folder with one, or a robot of skylimb's own form."),
]
_Packages = Annotated[str, arg(metavar="DIR", help="Folder of the packages that xacro and package:// name.")]
_Mapping = Annotated[
    str, arg(metavar="FILE", help="TOML file that says what the description's names do not tell.")
]
_Mend = Annotated[bool, arg(help="Replace inertias that no body has by the nearest possible ones.")]


@dataclass(frozen=True)
class CheckRobot:
    """Check a robot description: mass, inertias, rotors, joints, hover; each doubt with its remedy.

    The last line says whether it can hover, and whether it can touch; what a task takes, `skylimb plan` says.
    Exit code 0: it can hover. 1: it loads and cannot hover. 2: it cannot be read.
    """

    examples: ClassVar[str] = """
        skylimb robot check my_robot.urdf
        skylimb robot check robots/quad/robot.urdf.xacro --packages ~/catkin_ws/src --picture robot.png
        skylimb robot check hydrus_xi_quad
    """

    file: _File
    packages: _Packages = ""
    mapping: _Mapping = ""
    mend: _Mend = False
    picture: Annotated[str, arg(metavar="PNG", help="Draw it into this new file, a broken one too.")] = ""

    def __call__(self) -> int:
        """Print the report."""
        from skylimb.apps.robot_import.checking import check_robot_file
        from skylimb.apps.robot_import.picture import draw_robot
        from skylimb.apps.robot_import.report import report_text
        from skylimb.base.files import new_file, require_new

        if self.picture:
            require_new(self.picture)
        report = check_robot_file(self.file, self.packages or None, self.mapping or None, mend=self.mend)
        print(report_text(report))
        if self.picture:
            with new_file(self.picture) as path:
                draw_robot(report, path)
        return 0 if report.can_hover else 1


@dataclass(frozen=True)
class ImportRobot:
    """Make a robot of skylimb's own form from a URDF or xacro file: `skylimb run --set robot=DIR` flies it.

    The new folder gets robot.urdf, flight.toml, meshes/, check.txt, robot.png and mapping.toml, which says
    what was recognised or assumed: change it and import again with --mapping. Exit codes are those of
    `robot check`.
    """

    examples: ClassVar[str] = """
        skylimb robot import my_robot.urdf --out robots/mine
        skylimb run free_flight --set robot=robots/mine 'posture.waypoints=[]'
        skylimb robot import my_robot.urdf --mapping robots/mine/mapping.toml --out robots/mine2
    """

    file: _File
    out: Annotated[str, arg(metavar="DIR", help="New folder for the robot.")] = ""
    packages: _Packages = ""
    mapping: _Mapping = ""
    mend: _Mend = False

    def __call__(self) -> int:
        """Write the folder and print the report."""
        from skylimb.apps.robot_import.report import report_text
        from skylimb.apps.robot_import.writing import import_robot

        if not self.out:
            raise ConfigError("--out is missing; it names the robot's new folder")
        report = import_robot(
            self.file, self.out, self.packages or None, self.mapping or None, mend=self.mend
        )
        print(report_text(report))
        flown = f"skylimb run free_flight --set robot={self.out} 'posture.waypoints=[]'"
        print(f"\nWritten to {Path(self.out)}: {flown}")
        return 0 if report.can_hover else 1


VERBS = {"robot check": CheckRobot, "robot import": ImportRobot}
