"""The text of a URDF: from a .urdf, expanded .xacro, MJCF or SDF file, or the one file of a folder."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from skylimb.apps.robot_import.mapping import MappedRotor
from skylimb.apps.robot_import.sdf import read_sdf
from skylimb.base.errors import DescriptionError, UnknownNameError
from skylimb.base.sources import read_source
from skylimb.base.xml_text import read_xml
from skylimb.robots.packages import find_packages

_SECONDS = 20.0
_SDF = re.compile(rb"\s*(<\?xml[^>]*>\s*)?(<!--.*?-->\s*)*<sdf\b", re.DOTALL)


@dataclass(frozen=True)
class UrdfText:
    """A URDF as text.

    Attributes:
        path: the file that the user named.
        content: the URDF, xacro expanded.
        packages: where packages lie, by name.
        rotors: those that the file says beside the URDF.
    """

    path: Path
    content: bytes
    packages: Mapping[str, Path]
    rotors: tuple[MappedRotor, ...] = ()


def read_urdf_text(
    path: str | Path, packages: str | Path | None = None, arguments: Mapping[str, str] | None = None
) -> UrdfText:
    """The URDF that a user named.

    Args:
        path: a .urdf, .xacro, MJCF or SDF file, or a folder with one of them.
        packages: a folder with the packages that `$(find NAME)` and `package://NAME` mean; those around the
            file are found anyway.
        arguments: values of the xacro's arguments, `<xacro:arg>`, by name.

    Raises:
        DescriptionError: not one such file, no XML, or a xacro that cannot be expanded.
        UnreadableError: no such file.
    """
    path = _the_file(Path(path))
    source = read_source(path)
    if packages is not None and not Path(packages).is_dir():
        raise DescriptionError(f"--packages: '{packages}' is no folder")
    known = find_packages(*([Path(packages)] if packages is not None else []), source.path.parent)
    content = source.content
    if _SDF.match(content) and not arguments:
        content, models = read_sdf(source.path, [Path(packages)] if packages is not None else [])
        return UrdfText(source.path, content, {**known, **models})
    try:
        kind = read_xml(content).tag
    except ValueError as error:
        raise DescriptionError(f"'{path}' is no XML of a robot: {error}") from None
    if kind == "mujoco" and not arguments:
        from skylimb.apps.robot_import.mjcf import read_mjcf  # the engine is slow to import

        content, rotors = read_mjcf(source.path)
        return UrdfText(source.path, content, known, rotors)
    if path.suffix.lower() == ".xacro" or b"xmlns:xacro" in content[:4000]:
        content = _expanded(source.path, known, arguments or {})
    elif arguments:
        raise DescriptionError(f"'{path}' is no xacro file and takes no arguments ({', '.join(arguments)})")
    return UrdfText(source.path, content, known)


def _the_file(path: Path) -> Path:
    if not path.is_dir():
        return path
    found = sorted([*path.rglob("*.urdf"), *path.rglob("*.urdf.xacro")]) or sorted(path.rglob("*.sdf"))
    if len(found) == 1:
        return found[0]
    if not found:
        raise DescriptionError(f"the folder '{path}' has no .urdf, .urdf.xacro or .sdf file")
    names = ", ".join(str(file.relative_to(path)) for file in found[:8])
    more = f" and {len(found) - 8} more" if len(found) > 8 else ""
    raise DescriptionError(f"the folder '{path}' has {len(found)} descriptions; name one: {names}{more}")


def _expanded(path: Path, packages: Mapping[str, Path], arguments: Mapping[str, str]) -> bytes:
    """The file expanded in a process of its own: a xacro is a program, and may not end."""
    names = json.dumps({name: str(folder) for name, folder in packages.items()})
    script = Path(__file__).parent / "xacro_process.py"
    try:
        done = subprocess.run(
            [sys.executable, str(script), str(path), names, json.dumps(dict(arguments))],
            capture_output=True,
            timeout=_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise DescriptionError(f"expanding '{path}' takes longer than {_SECONDS:g} s") from None
    if done.returncode == 0:
        return done.stdout
    lines = done.stderr.decode(errors="replace").strip().splitlines() or ["it ended without a word"]
    missing = re.search(r"Package not found: (\S+?)['\"]?$", lines[-1])
    if missing:
        raise UnknownNameError(
            f"'{path.name}' needs package '{missing[1]}', which is not found; say where packages lie: "
            f"--packages DIR (known: {', '.join(sorted(packages)) or 'none'})"
        )
    lacking = re.search(r"Undefined substitution argument (\S+)", lines[-1])
    hint = f"; say --args {lacking[1]}=VALUE" if lacking else ""
    raise DescriptionError(f"'{path}' cannot be expanded: {lines[-1][:400]}{hint}")
