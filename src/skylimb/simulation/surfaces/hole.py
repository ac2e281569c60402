"""A hole with a chamfer in a flat face, for a peg: eight flat walls, each a few of the engine's boxes."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import quaternion_from_rotation
from skylimb.simulation.surfaces.box import closest_on_box
from skylimb.simulation.surfaces.geom import Geom, name_of
from skylimb.simulation.surfaces.surface import Surface

WALLS = 8
"""Flat walls around the hole."""


class Block(NamedTuple):
    """A box in the surface's axes (w, u, v).

    Attributes:
        center: m, (3,).
        half: half lengths along its own axes, m, (3,).
        axes: its axes as columns, (3, 3).
    """

    center: np.ndarray
    half: np.ndarray
    axes: np.ndarray


@configuration
class Hole(Surface):
    """A blind hole along w through `position`, in an eight-sided block as wide as `size`.

    Its face is w = 0. It is an octagon across, `radius` from its axis to its walls. A chamfer of 45 degrees
    opens it, as wide as it is deep. The block ends at its edges, also for the contact.
    """

    many: ClassVar[bool] = True
    path_on_plane: ClassVar[bool] = True
    kind: Literal["hole"] = "hole"
    size: Annotated[tuple[float, float], Key("m", "extent of the block along u and v", 0.05, 2.0)] = (
        0.4,
        0.4,
    )
    radius: Annotated[float, Key("m", "from its axis to its walls", 0.002, 0.5)] = 0.017
    chamfer: Annotated[float, Key("m", "width and depth of the chamfer", 0.001, 0.2)] = 0.02
    depth: Annotated[float, Key("m", "from the face to its floor", 0.002, 1.0)] = 0.06

    def check(self) -> None:
        """Refuse a chamfer below the floor, a small block, and a hole that moves or whose friction varies."""
        super().check()
        self.require_still()
        if self.chamfer >= self.depth:
            raise ConfigError(
                f"surface.chamfer = {self.chamfer:g} m must be less than surface.depth = {self.depth:g} m"
            )
        if self.size[0] != self.size[1] or 0.5 * self.size[0] <= 1.2 * (self.radius + self.chamfer):
            raise ConfigError(
                f"surface.size = {list(self.size)} m: a block with a hole is as high as wide, and wider than "
                f"{2.4 * (self.radius + self.chamfer):.3g} m"
            )

    @property
    def tightest_hollow(self) -> float:
        """The hole's own."""
        return self.radius

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """Its boxes: for each wall the chamfer, the wall below it and the face around it; then the floor."""
        half, below = 0.5 * self.size[0], 0.5 * self.depth
        slant = self.chamfer * np.sqrt(0.5)
        found = []
        for angle in 2.0 * np.pi * np.arange(WALLS) / WALLS:
            out = np.array([0.0, np.cos(angle), np.sin(angle)])
            side = np.array([0.0, -np.sin(angle), np.cos(angle)])
            into = np.array([1.0, 0.0, 0.0])
            upright = np.stack([into, out, side], axis=1)
            # From the chamfer's edge down to the wall's, and into the block.
            along, deep = (into - out) * np.sqrt(0.5), (into + out) * np.sqrt(0.5)
            middle = 0.5 * self.chamfer * into + (self.radius + 0.5 * self.chamfer) * out
            leaning = np.stack([along, deep, side], axis=1)
            # Its back stays within the block.
            thick = 0.5 * slant
            wide = (self.radius + 2.0 * self.chamfer) * np.tan(np.pi / WALLS)
            found.append(Block(middle + thick * deep, np.array([slant, thick, wide]), leaning))
            for start, top in ((self.radius, self.chamfer), (self.radius + self.chamfer, 0.0)):
                thick, tall = 0.5 * (half - start), 0.5 * (self.depth - top)
                center = (top + tall) * into + (start + thick) * out
                wide = half * np.tan(np.pi / WALLS)
                found.append(Block(center, np.array([tall, thick, wide]), upright))
        floor = np.array([self.depth + below, 0.0, 0.0])
        return (*found, Block(floor, np.array([below, 0.7 * half, 0.7 * half]), np.eye(3)))

    def local_closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """On the nearest of its boxes; of a point inside several the one whose face is farthest."""
        points = np.asarray(points, dtype=float)
        feet, normals, gaps = zip(*(_closest(block, points) for block in self.blocks), strict=True)
        best = np.argmin(np.stack(gaps, axis=-1), axis=-1)[..., None, None]
        chosen = [
            np.take_along_axis(np.stack(values, axis=-2), best, axis=-2)[..., 0, :]
            for values in (feet, normals)
        ]
        return chosen[0], chosen[1]

    @property
    def geoms(self) -> tuple[Geom, ...]:
        """Its boxes, which are looked at as they are touched."""
        return tuple(
            Geom("box", block.half, block.center, quaternion_from_rotation(block.axes), name_of(index))
            for index, block in enumerate(self.blocks)
        )


def _closest(block: Block, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Closest points of a box, outward normals there, and signed distances."""
    foot, normal, gap = closest_on_box((points - block.center) @ block.axes, block.half)
    return foot @ block.axes.T + block.center, normal @ block.axes.T, gap
