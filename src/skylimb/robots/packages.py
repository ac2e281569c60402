"""Where `package://NAME/FILE` of a robot description lies, without ROS."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

MANIFEST = "package.xml"
_NAME = re.compile(r"<name>\s*([\w.-]+)\s*</name>")
_DEEPEST = 6
_MOST = 20_000
"""Folders that are looked into at most, so that a home folder named by mistake does not hang the search."""


def find_packages(*folders: Path) -> dict[str, Path]:
    """Packages by name: every folder with a `package.xml` below the given ones, and those that hold them.

    Args:
        folders: where to look. Their own parents are looked at as well, not what else lies in these.
    """
    found: dict[str, Path] = {}
    for folder in folders:
        start = folder.resolve()
        for manifest in (*_manifests(start), *(parent / MANIFEST for parent in start.parents)):
            name = _name_in(manifest)
            if name:
                found.setdefault(name, manifest.parent)
    return found


def find_file(name: str, folder: Path, packages: Mapping[str, Path] | None = None) -> Path | None:
    """The file that a URDF in `folder` names, None where it is not there.

    Args:
        name: a path beside the URDF, `file://...` or `package://NAME/...`.
        folder: the URDF's.
        packages: where packages lie; those around the URDF are found anyway.
    """
    scheme, separator, rest = name.rpartition("://")
    candidates = [folder / rest]
    if separator and scheme == "package":
        package, _, inside = rest.partition("/")
        known = (packages or {}).get(package) or _package_around(package, folder)
        candidates = [*([known / inside] if known else []), folder / inside, folder / rest]
    try:
        return next((path for path in candidates if path.is_file()), None)
    except (OSError, ValueError):  # no name that a file can have
        return None


def _package_around(package: str, folder: Path) -> Path | None:
    for parent in (folder, *folder.parents):
        if parent.name == package or _name_in(parent / MANIFEST) == package:
            return parent
    return None


def _name_in(manifest: Path) -> str:
    try:
        match = _NAME.search(manifest.read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return ""
    return match[1] if match else ""


def _manifests(folder: Path) -> Iterator[Path]:
    for count, (path, inside, files) in enumerate(os.walk(folder)):
        if count > _MOST:
            return
        depth = len(Path(path).relative_to(folder).parts)
        inside[:] = sorted(name for name in inside if depth < _DEEPEST and not name.startswith("."))
        if MANIFEST in files:
            yield Path(path) / MANIFEST
