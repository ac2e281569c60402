"""Links and joints as plain data, so that only a new URDF needs the package that reads URDFs.

They stand in `NAME.links.json` beside `NAME.urdf` for robots that ship and for what `skylimb robot import`
writes. Those of any other URDF are kept in the user's cache when it was read once. A file that belongs to
another URDF, or is damaged, is not used. Without a cache all works, only slower.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import warnings
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from skylimb.base.cache import cache_folder, keep, kept
from skylimb.base.sources import Source, content_of
from skylimb.robots.links import Joint, Link
from skylimb.robots.urdf import read_urdf

Tree = tuple[str, tuple[Link, ...], tuple[Joint, ...]]
"""The root link's name, links and joints, as `read_urdf` returns them."""

_VERSION = 2
"""Counts up when reading a URDF gives something else, so that older files are not used."""


def tree_of(urdf: Source, root_link: str | None) -> Tree:
    """What a URDF says, from its file of links where there is one.

    Raises:
        MissingExtraError: there is none, and the package that reads URDFs is not installed.
        SkylimbError: as `read_urdf`.
    """
    key = _key(urdf, root_link)
    # A copy of a robot that ships finds that one's file.
    shipped = sorted(Path(__file__).parent.glob("*/*.links.json"))
    for path in (urdf.path.with_suffix(".links.json"), *shipped):
        tree = _tree_in(content_of(path), path, key)
        if tree is not None:
            return tree
    # The same URDF elsewhere has meshes of its own beside it.
    place = hashlib.sha256(str(urdf.path.parent.absolute()).encode()).hexdigest()[:8]
    cached = cache_folder() / "links" / f"{key}-{place}.json"
    tree = _tree_in(kept(cached), cached, key)
    if tree is not None:
        return tree
    tree = read_urdf(urdf, root_link)
    if _complete(urdf, tree):
        with contextlib.suppress(OSError):
            keep(cached, links_text(urdf, root_link, tree, cached.parent).encode())
    return tree


def links_text(urdf: Source, root_link: str | None, tree: Tree, folder: Path) -> str:
    """The content of a file of links in a folder; it names the meshes in there from there."""

    def plain(value: Any) -> Any:
        if isinstance(value, Path):
            return str(value.relative_to(folder) if value.is_relative_to(folder) else value)
        return value.tolist()

    links = msgspec.to_builtins(tree, enc_hook=plain)
    data = {"key": _key(urdf, root_link), "digest": _digest(links), "tree": links}
    return json.dumps(data, indent=1) + "\n"


def _digest(links: Any) -> str:
    """Of links and joints in a file, so that a number that was changed in there is seen."""
    return hashlib.sha256(json.dumps(links).encode()).hexdigest()[:32]


def _key(urdf: Source, root_link: str | None) -> str:
    """Names a URDF, whatever its line ends, with the root that was asked for."""
    content = urdf.content.replace(b"\r\n", b"\n")
    return hashlib.sha256(b"\0".join((content, str(root_link).encode(), b"%d" % _VERSION))).hexdigest()[:32]


def _tree_in(content: bytes | None, path: Path, key: str) -> Tree | None:
    """The links and joints in the content of a file; None where it is another URDF's, damaged or absent."""

    def made(kind: type, value: Any) -> Any:
        return path.parent / value if issubclass(kind, Path) else np.array(value, dtype=float)

    try:
        data = json.loads(content or b"{}")
        if data["key"] != key:
            return None
        if data["digest"] != _digest(data["tree"]):
            warnings.warn(
                f"'{path}' was changed by hand or damaged, and is not used", UserWarning, stacklevel=3
            )
            return None
        tree = msgspec.convert(data["tree"], Tree, dec_hook=made)
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return tree if all(mesh.is_file() for mesh in _meshes(tree)) else None


def _meshes(tree: Tree) -> list[Path]:
    shapes = [shape for link in tree[1] for shape in (*link.visuals, *link.collisions)]
    return [shape.mesh for shape in shapes if shape.mesh is not None]


def _complete(urdf: Source, tree: Tree) -> bool:
    """Whether every mesh was there; one that was not may be there the next time."""
    return len(_meshes(tree)) == urdf.content.count(b"<mesh")
