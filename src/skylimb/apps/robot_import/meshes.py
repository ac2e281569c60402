"""The meshes of a description: found, turned into a kind that the physics engine draws, or left out."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

from skylimb.apps.robot_import.doubts import Doubt
from skylimb.apps.robot_import.tree import UrdfTree
from skylimb.base.sources import read_source
from skylimb.robots.packages import find_file
from skylimb.robots.urdf import DRAWN

FOLDER = "meshes"


def settle_meshes(
    tree: UrdfTree, folder: Path, packages: Mapping[str, Path], *, convert: bool
) -> tuple[dict[str, bytes], list[Doubt]]:
    """Let the tree name meshes that are there and can be drawn; others are taken out.

    Args:
        tree: changed in place.
        folder: where the URDF lay.
        packages: folders of packages by name.
        convert: whether the tree shall name copies below `meshes/`, other kinds turned into STL; else it
            names the files where they lie.

    Returns:
        Contents of the copies by their path, and a doubt for what was taken out.
    """
    copies: dict[str, bytes] = {}
    settled: dict[str, tuple[str, str]] = {}
    for link in tree.root.findall("link"):
        for element in [*link.findall("visual"), *link.findall("collision")]:
            mesh = element.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.get("filename", "")
            if name not in settled:
                settled[name] = _settled(find_file(name, folder, packages), copies if convert else None)
            if settled[name][0]:
                mesh.set("filename", settled[name][0])
            else:
                link.remove(element)
    remedy = "say where packages lie (--packages DIR); the robot flies without them"
    return copies, [
        Doubt(f"mesh '{name[:120]}'", f"{why}; left out of the picture", remedy)
        for name, (_, why) in settled.items()
        if why
    ]


def _settled(file: Path | None, copies: dict[str, bytes] | None) -> tuple[str, str]:
    """What a mesh is called from now on, or else why it is left out; with `copies` it becomes one of them."""
    if file is None:
        return "", "is not there"
    drawn = file.suffix.lower() in DRAWN
    if copies is None:
        return (
            (str(file), "")
            if drawn
            else ("", f"is {file.suffix}, which `skylimb robot import` turns into STL")
        )
    content = _drawable(file)
    if content is None:
        return "", "cannot be read"
    name = _free_name(f"{file.stem}{file.suffix.lower() if drawn else '.stl'}", copies)
    copies[name] = content
    return name, ""


def _free_name(name: str, taken: Mapping[str, bytes]) -> str:
    path, count = f"{FOLDER}/{name}", 1
    while path in taken:
        count += 1
        stem, _, suffix = name.rpartition(".")
        path = f"{FOLDER}/{stem}-{count}.{suffix}"
    return path


def _drawable(file: Path) -> bytes | None:
    """The file's content where the engine draws it, else as STL; None where it cannot be read."""
    import trimesh

    try:
        given = read_source(file).content
        if file.suffix.lower() in DRAWN:
            return given
        mesh = trimesh.load(io.BytesIO(given), file_type=file.suffix[1:].lower(), force="mesh")
        content = mesh.export(file_type="stl")  # type: ignore[union-attr]
    except Exception:  # readers of many kinds of files raise many kinds of errors: all mean "cannot be read"
        return None
    return content if isinstance(content, bytes) and len(content) > 84 else None
