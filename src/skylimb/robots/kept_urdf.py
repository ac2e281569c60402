"""What was read from a URDF that flew, kept in the user's cache: importing its reader takes a second.

A file there is named after everything that decides what is in it, and holds plain numbers. One that is
damaged is as good as none. Without a cache all works, only slower.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from skylimb.base.files import replacing
from skylimb.base.sources import Source
from skylimb.robots import description, urdf
from skylimb.robots.description import Inertial, Joint, Link, Visual

Tree = tuple[str, tuple[Link, ...], tuple[Joint, ...]]
"""The root link's name, links, joints, as `urdf.read_urdf` returns them."""


def known_tree(source: Source, root_link: str | None) -> Tree | None:
    """What `read_urdf` returned for the same file before, or None where nobody kept it."""
    try:
        data = json.loads(_file(source, root_link).read_text(encoding="utf-8"))
        return data["root"], tuple(map(_link, data["links"])), tuple(map(_joint, data["joints"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None


def keep_tree(tree: Tree, source: Source, root_link: str | None) -> None:
    """Keep it for the next process.

    A robot with meshes is not kept: which of them are there may change without the URDF.
    """
    root, links, joints = tree
    path = _file(source, root_link)
    if b"<mesh" in source.content or not path.is_absolute() or path.is_file():
        return
    data = {
        "root": root,
        "links": [dataclasses.asdict(link) for link in links],
        "joints": [dataclasses.asdict(joint) for joint in joints],
    }
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path, durable=False) as aside:
            aside.write_text(json.dumps(data, default=np.ndarray.tolist), encoding="utf-8")


def _file(source: Source, root_link: str | None) -> Path:
    import platformdirs

    key = hashlib.sha256("\0".join((source.digest, str(root_link), _reader())).encode()).hexdigest()[:32]
    return platformdirs.user_cache_path("skylimb") / "urdf" / f"{key}.json"


@cache
def _reader() -> str:
    """Digest of the code that reads a URDF and of the records that it fills."""
    files = (urdf.__file__, description.__file__, __file__)
    return hashlib.sha256(b"\0".join(Path(file).read_bytes() for file in files)).hexdigest()


def _link(data: dict[str, Any]) -> Link:
    return Link(
        data["name"],
        Inertial(**_arrays(data["inertial"], "com", "inertia")),
        tuple(map(_visual, data["visuals"])),
        tuple(map(_visual, data["collisions"])),
    )


def _visual(data: dict[str, Any]) -> Visual:
    return Visual(**{**_arrays(data, "xyz", "R"), "size": tuple(data["size"]), "rgba": tuple(data["rgba"])})


def _joint(data: dict[str, Any]) -> Joint:
    return Joint(**_arrays(data, "xyz", "R", "axis"))


def _arrays(data: dict[str, Any], *names: str) -> dict[str, Any]:
    return {**data, **{name: np.array(data[name], dtype=float) for name in names}}
