"""What the pen touches: surfaces that are one geometry to the physics and to the analysis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skylimb.config import from_mapping
from skylimb.errors import ConfigError, unknown_name
from skylimb.simulation.surfaces.board import Board
from skylimb.simulation.surfaces.surface import Surface, SurfaceParts

SURFACES: dict[str, type[Surface]] = {"board": Board}
"""Every kind of surface by the name that `surface.kind` gives it."""


def surface_from_mapping(mapping: Mapping[str, Any], where: str = "surface") -> Surface:
    """The surface that a table describes; its key `kind` selects among `SURFACES`, a board by default.

    Raises:
        ConfigError: a key of the wrong type, or a value out of range.
        UnknownNameError: a kind or key that does not exist.
    """
    kind = mapping.get("kind", "board")
    if not isinstance(kind, str):
        raise ConfigError(
            f"{where}: surface.kind = {kind!r} should be a name, one of {', '.join(sorted(SURFACES))}"
        )
    if kind not in SURFACES:
        raise unknown_name("surface", kind, SURFACES)
    return from_mapping(SURFACES[kind], mapping, where)


__all__ = ["SURFACES", "Board", "Surface", "SurfaceParts", "surface_from_mapping"]
