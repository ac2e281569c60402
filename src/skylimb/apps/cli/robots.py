"""The verbs about robots of one's own: `robot check` and `robot import`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from skylimb.apps.cli.arguments import arg
from skylimb.base.errors import ConfigError

_File = Annotated[
    str, arg("A .urdf, .xacro or MJCF file, a folder with one, or a robot of skylimb's own form.", "FILE")
]
_Packages = Annotated[str | None, arg("Folder of the packages that xacro and package:// name.", "DIR")]
_Mapping = Annotated[str | None, arg("TOML file that says what the description's names do not tell.", "FILE")]
_Args = Annotated[tuple[str, ...], arg("Arguments of a xacro file.", "NAME=VALUE ...")]
_Mend = Annotated[bool, arg("Replace inertias that no body has by the nearest possible ones.")]


def check_robot(
    file: _File,
    *,
    packages: _Packages = None,
    mapping: _Mapping = None,
    args: _Args = (),
    mend: _Mend = False,
    picture: Annotated[str, arg("Draw it into this new file, a broken one too.", "PNG")] = "",
    rotors: Annotated[
        bool, arg("Say which rotor's loss is outlived, and in what posture it would be; takes up to minutes.")
    ] = False,
) -> int:
    """Check a robot description: mass, inertias, rotors, joints, hover; each doubt with its remedy.

    The last line says whether it can hover, and whether it can touch; what a task takes, `skylimb plan` says.
    Exit code 0: it can hover. 1: it loads and cannot hover. 2: it cannot be read.

    Examples:
        skylimb robot check my_robot.urdf
        skylimb robot check robots/quad/robot.urdf.xacro --packages ~/catkin_ws/src --picture robot.png
        skylimb robot check robot.urdf.xacro --args arms=6 mass=1.2
        skylimb robot check hydrus_xi_quad --rotors
    """
    import skylimb
    from skylimb.apps.robot_import.picture import draw_robot
    from skylimb.apps.robot_import.report import lost_rotors_text, report_text
    from skylimb.base.files import new_file, require_new

    if picture:
        require_new(picture)
    report = skylimb.check_robot_file(file, packages, mapping, args=_arguments(args), mend=mend)
    print(report_text(report))
    if rotors and report.can_hover:
        print(lost_rotors_text(report.description))
    if picture:
        with new_file(picture) as path:
            draw_robot(report, path)
    return 0 if report.can_hover else 1


def import_robot(
    file: _File,
    *,
    out: Annotated[str, arg("New folder for the robot.", "DIR")] = "",
    packages: _Packages = None,
    mapping: _Mapping = None,
    args: _Args = (),
    mend: _Mend = False,
) -> int:
    """Make a robot of skylimb's own form from a URDF or xacro file: `skylimb run --set robot=DIR` flies it.

    The new folder gets robot.urdf, flight.toml, meshes/, check.txt, robot.png and mapping.toml, which says
    what was recognised or assumed: change it and import again with --mapping. Exit codes are those of
    `robot check`.

    Examples:
        skylimb robot import my_robot.urdf --out robots/mine
        skylimb run free_flight --set robot=robots/mine 'posture.waypoints=[]'
        skylimb robot import my_robot.urdf --mapping robots/mine/mapping.toml --out robots/mine2
    """
    import skylimb
    from skylimb.apps.robot_import.report import report_text

    if not out:
        raise ConfigError("--out is missing; it names the robot's new folder")
    report = skylimb.import_robot(file, out, packages, mapping, args=_arguments(args), mend=mend)
    print(report_text(report))
    flown = f"skylimb run free_flight --set robot={out} 'posture.waypoints=[]'"
    print(f"\nWritten to {Path(out)}: {flown}")
    return 0 if report.can_hover else 1


def _arguments(words: tuple[str, ...]) -> dict[str, str]:
    """The arguments of a xacro by name."""
    for word in words:
        if not word.partition("=")[0] or "=" not in word:
            raise ConfigError(f"--args = '{word}' must be NAME=VALUE")
    return dict(word.split("=", 1) for word in words)
