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
    names: dict[Path, str] = {}
    lost: dict[str, str] = {}
    for link in tree.root.findall("link"):
        for element in [*link.findall("visual"), *link.findall("collision")]:
            mesh = element.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.get("filename", "")
            file = find_file(name, folder, packages)
            if file is None:
                lost[name] = "is not there"
            elif not convert and (file.suffix.lower() in DRAWN):
                mesh.set("filename", str(file))
                continue
            elif not convert:
                lost[name] = f"is {file.suffix}, which `skylimb robot import` turns into STL"
            else:
                content = _drawable(file)
                if content is not None:
                    if file not in names:
                        suffix = file.suffix.lower() if file.suffix.lower() in DRAWN else ".stl"
                        names[file] = _free_name(f"{file.stem}{suffix}", copies)
                        copies[names[file]] = content
                    mesh.set("filename", names[file])
                    continue
                lost[name] = "cannot be read"
            link.remove(element)
    return copies, _doubts(lost)


def _doubts(lost: dict[str, str]) -> list[Doubt]:
    doubts = []
    for reason in dict.fromkeys(lost.values()):
        files = [name for name, why in lost.items() if why == reason]
        more = f" and {len(files) - 1} more" if len(files) > 1 else ""
        what = f"mesh '{files[0][:120]}'{more}"
        remedy = "say where packages lie (--packages DIR); the robot flies without them"
        doubts.append(Doubt(what, f"{reason}; left out of the picture", remedy))
    return doubts


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
