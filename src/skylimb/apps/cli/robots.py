"""The verbs about robots of one's own: `robot check` and `robot import`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

from skylimb.apps.cli.arguments import arg
from skylimb.base.errors import ConfigError

_File = Annotated[
    str, arg("A .urdf, .xacro, MJCF or SDF file, a folder with one, or a robot of skylimb's form.", "FILE")
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
    if not report.can_hover:
        return _not_flown(out)
    controller, hovers = _first_flight(out)
    flown = f"skylimb run free_flight{controller} --set {_named(out)} 'posture.waypoints=[]'"
    print(f"\nWritten to {Path(out)}: {flown}")
    return 0 if hovers else 1


def new_robot(
    file: _File,
    *,
    out: Annotated[str, arg("New folder for the robot.", "DIR")] = "",
    mass: Annotated[str, arg("What it weighs, kg.", "KG")] = "",
    arm: Annotated[str, arg("Joints that bend it, or 'none'.", "NAMES")] = "",
    tip: Annotated[
        str, arg("What touches: a link, x y z there (m), and the axis that points out.", "'LINK X Y Z x|z'")
    ] = "",
    spin: Annotated[str, arg("Links of the rotors that turn clockwise, or 'none'.", "NAMES")] = "",
    thrust: Annotated[str, arg("Greatest thrust of the strongest rotor, N.", "N")] = "",
    yes: Annotated[bool, arg("Take every proposal that is not said otherwise.")] = False,
    packages: _Packages = None,
    args: _Args = (),
) -> int:
    """Make a robot from a URDF and some questions: its mass, arm, tip and rotors, each with a proposal.

    A picture of what is recognised is drawn beside the new folder first. The folder is that of
    `robot import`; its mapping.toml has the answers. Exit codes are those of `robot check`.

    Examples:
        skylimb robot new my_robot.urdf --out robots/mine
        skylimb robot new my_robot.urdf --out robots/mine --tip 'tool0 0 0 0.1' --yes
    """
    import sys

    import skylimb
    from skylimb.apps.robot_import.interview import interview
    from skylimb.apps.robot_import.picture import draw_robot
    from skylimb.apps.robot_import.report import report_text
    from skylimb.base.files import new_file, require_new

    if not out:
        raise ConfigError("--out is missing; it names the robot's new folder")
    picture = Path(out).with_name(f"{Path(out).name}.png")
    require_new(out)
    require_new(picture)

    def ask(words: str, proposed: str) -> str:
        if yes:
            return ""
        if not sys.stdin.isatty():
            raise ConfigError(f"nobody is there to answer '{words}'; --yes takes the proposal, {proposed}")
        try:
            return input(f"{words} [{proposed}] ").strip()
        except EOFError:
            raise ConfigError(f"no answer to '{words}'; Enter takes the proposal, {proposed}") from None

    said, drawn = None, False
    answers = {"mass": mass, "arm": arm, "tip": tip, "spin": spin, "thrust": thrust}
    try:
        for report, answered in interview(file, answers, ask, packages, _arguments(args)):
            said = answered
            if not drawn:
                with new_file(picture) as path:
                    draw_robot(report, path)
                print(f"What is recognised is drawn in {picture}. Enter takes the proposal in brackets.")
                drawn = True
        report = skylimb.import_robot(file, out, packages, said, args=_arguments(args))
    except BaseException:  # Ctrl-C as well
        if drawn:  # it would be in the way of the next try
            picture.unlink(missing_ok=True)
        raise
    print(report_text(report))
    if not report.can_hover:
        return _not_flown(out)
    hovers = _first_flight(out)[1]
    print(f"\nWritten to {Path(out)}; a first touch: {_first_touch(out)}")
    return 0 if hovers else 1


def _first_flight(out: str) -> tuple[str, bool]:
    """Fly a hover, and say what came of it: the option that names who flies, and whether any hovers."""
    import skylimb
    from skylimb.apps.robot_import.hover_flight import FIRST, who_hovers

    name, lost = who_hovers(skylimb.load_robot(out))
    for other, why in lost.items():
        print(f"  {'doubt' if name else 'FAULT'}     a hover of 5 s with {other} does not last: {why}")
    if name:
        print(f"  flown     a hover of 5 s with {name}")
    return f" --controller {name}" if name and name != FIRST[0] else "", bool(name)


def _not_flown(out: str) -> int:
    """Say what becomes of a robot that cannot hover; its exit code."""
    print(f"\nWritten to {Path(out)}, to look at; correct what is a FAULT, and make it again")
    return 1


def _named(out: str) -> str:
    """The robot's key as a shell reads it, also with a space in its folder's name."""
    return shlex.quote(f"robot={out}")


def _first_touch(out: str) -> str:
    return f"skylimb run board_tilted_hexarotor --controller following --set {_named(out)}"


def _arguments(words: tuple[str, ...]) -> dict[str, str]:
    """The arguments of a xacro by name."""
    for word in words:
        if not word.partition("=")[0] or "=" not in word:
            raise ConfigError(f"--args = '{word}' must be NAME=VALUE")
    return dict(word.split("=", 1) for word in words)
