"""What the pen touches: surfaces that are one geometry to the physics and to the analysis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skylimb.base.config import from_mapping
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.base.keys.key import shown
from skylimb.base.plugins import added_file, added_names
from skylimb.simulation.surfaces.ball import Sphere
from skylimb.simulation.surfaces.board import Board
from skylimb.simulation.surfaces.checks import require_clear, require_fits, require_path, way_clear
from skylimb.simulation.surfaces.curved import CurvedSurface
from skylimb.simulation.surfaces.cylinder import Cylinder, Pipe
from skylimb.simulation.surfaces.friction_map import FrictionMap, Patch
from skylimb.simulation.surfaces.heightmap import HeightMap
from skylimb.simulation.surfaces.hole import Hole
from skylimb.simulation.surfaces.meshes import MeshSurface
from skylimb.simulation.surfaces.pair_friction import PairFriction
from skylimb.simulation.surfaces.post import Post
from skylimb.simulation.surfaces.sine import Corrugated, SineWall
from skylimb.simulation.surfaces.steps import Ramp, Ridge, Step
from skylimb.simulation.surfaces.surface import Surface
from skylimb.simulation.surfaces.valve import Valve

_KINDS: tuple[type[Surface], ...] = (
    Board, Cylinder, Pipe, Post, Sphere, SineWall, Corrugated, Step, Ridge, Ramp, HeightMap, MeshSurface,
    Valve, Hole,
)  # fmt: skip
SURFACES: dict[str, type[Surface]] = {str(kind.kind): kind for kind in _KINDS}
"""Every kind of surface by the name that `surface.kind` gives it."""


def surface_from_mapping(mapping: Mapping[str, Any], where: str = "surface") -> Surface:
    """The surface that a table describes; `kind` is one of `SURFACES`, a board by default, or a Python file.

    Raises:
        ConfigError: a key of the wrong type, or a value out of range.
        UnknownNameError: a kind or key that does not exist.
    """
    kind = mapping.get("kind", "board")
    if not isinstance(kind, str):
        known = ", ".join(sorted(SURFACES))
        raise ConfigError(
            f"{where}: surface.kind = {shown(kind)} should be a name, one of {known}, or a Python file"
        )
    if file := added_file("surfaces", kind, kind in SURFACES):
        kind = file.as_posix()
        mapping = {**mapping, "kind": kind}
    if kind.endswith(".py"):
        from skylimb.simulation.surfaces.user_surface import user_surface  # few surfaces are the user's own

        return from_mapping(user_surface(kind), mapping, where, at="surface")
    if kind not in SURFACES:
        raise unknown_name("surface.kind", kind, [*SURFACES, *added_names("surfaces")], (".py",))
    return from_mapping(SURFACES[kind], mapping, where, at="surface")


__all__ = [
    "SURFACES",
    "Board",
    "Corrugated",
    "CurvedSurface",
    "Cylinder",
    "FrictionMap",
    "HeightMap",
    "Hole",
    "MeshSurface",
    "PairFriction",
    "Patch",
    "Pipe",
    "Post",
    "Ramp",
    "Ridge",
    "SineWall",
    "Sphere",
    "Step",
    "Surface",
    "Valve",
    "require_clear",
    "require_fits",
    "require_path",
    "surface_from_mapping",
    "way_clear",
]
