"""The meshes of a description: found, turned into a kind that the physics engine draws, or left out."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from skylimb.apps.robot_import.doubts import Doubt
from skylimb.apps.robot_import.tree import UrdfTree, triple
from skylimb.base.errors import SkylimbError
from skylimb.base.sources import read_source
from skylimb.robots.packages import find_file
from skylimb.robots.urdf import DRAWN

FOLDER = "meshes"

_LARGEST = 10.0
"""Longest side of a mesh that is believed, m."""

_HEAD = 84
"""Bytes of an STL file before its first triangle."""


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
        Contents of the copies by their path, and a doubt for what was taken out or is too large.
    """
    copies: dict[str, bytes] = {}
    settled: dict[str, _Settled] = {}
    doubts: list[Doubt] = []
    for link in tree.root.findall("link"):
        for element in [*link.findall("visual"), *link.findall("collision")]:
            mesh = element.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.get("filename", "")
            if name not in settled:
                settled[name] = _settled(find_file(name, folder, packages), copies if convert else None)
            one, what = settled[name], f"mesh '{name[:120]}'"
            if one.why:
                link.remove(element)
                doubts.append(Doubt(what, f"{one.why}; left out of the picture", one.remedy))
                continue
            mesh.set("filename", one.name)
            size = one.size * max(np.abs(triple(mesh, "scale", (1.0, 1.0, 1.0))))
            if size > _LARGEST:
                value = f"of link '{link.get('name')}' is {size:.3g} m large; is it in millimetres?"
                doubts.append(Doubt(what, value, 'say scale="0.001 0.001 0.001"'))
    return copies, doubts


class _Settled(NamedTuple):
    """What becomes of a mesh.

    Attributes:
        name: what it is called from now on.
        size: its longest side, in its file's unit.
        why: it is left out; empty where it is not.
        remedy: for that.
    """

    name: str = ""
    size: float = 0.0
    why: str = ""
    remedy: str = ""


def _settled(file: Path | None, copies: dict[str, bytes] | None) -> _Settled:
    """What becomes of a mesh; with `copies` it becomes one of them."""
    if file is None:
        remedy = "say where packages lie (--packages DIR); the robot flies without them"
        return _Settled(why="is not there", remedy=remedy)
    drawn, remedy = file.suffix.lower() in DRAWN, "mend its file; the robot flies without it"
    if copies is None and not drawn:
        why = f"is {file.suffix or 'without an ending'}, which `skylimb robot import` turns into STL"
        return _Settled(why=why, remedy="none is needed")
    try:
        content = read_source(file).content
        if not drawn:
            content = _as_stl(content, file.suffix)
        suffix = file.suffix.lower() if drawn else ".stl"
        size = _size(content, f"mesh{suffix}")
    except (SkylimbError, ValueError) as error:
        why = " ".join(str(error).partition("Element name")[0].split()).removeprefix("Error: ")[:200]
        return _Settled(why=f"cannot be drawn ({why})", remedy=remedy)
    if copies is None:
        return _Settled(str(file), size)
    name = _free_name(f"{file.stem}{suffix}", copies)
    copies[name] = content
    return _Settled(name, size)


def _size(content: bytes, name: str) -> float:
    """The longest side of a mesh, read as in every flight.

    Raises:
        ValueError: the engine does not take it.
    """
    import mujoco

    spec = mujoco.MjSpec()
    spec.assets = {name: content}
    spec.add_mesh(name="mesh", file=name)
    geom = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
    geom.contype = geom.conaffinity = 0
    return float(np.ptp(spec.compile().mesh_vert, axis=0).max())


def _free_name(name: str, taken: Mapping[str, bytes]) -> str:
    path, count = f"{FOLDER}/{name}", 1
    while path in taken:
        count += 1
        stem, _, suffix = name.rpartition(".")
        path = f"{FOLDER}/{stem}-{count}.{suffix}"
    return path


def _as_stl(content: bytes, suffix: str) -> bytes:
    """A mesh of another kind as STL.

    Raises:
        ValueError: it cannot be read.
    """
    import trimesh

    try:
        mesh = trimesh.load(io.BytesIO(content), file_type=suffix[1:].lower(), force="mesh")
        written = mesh.export(file_type="stl")  # type: ignore[union-attr]
    except Exception:  # readers of many kinds of files raise many kinds of errors: all mean "cannot be read"
        written = b""
    if not isinstance(written, bytes) or len(written) <= _HEAD:
        raise ValueError(f"is no mesh of kind {suffix}")
    return written
