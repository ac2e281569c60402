"""A height map from an image, a file of numbers, or a table in the experiment itself."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration, refused
from skylimb.base.sources import Source
from skylimb.simulation.surfaces import bspline
from skylimb.simulation.surfaces.curved import CurvedSurface
from skylimb.simulation.surfaces.spline import Spline
from skylimb.simulation.surfaces.tables import checked_rows, on_grid, read_table, values_in

_MOST_NODES = 400_000


@configuration
class HeightMap(CurvedSurface):
    """A relief on a wall, stretched over `size`, as someone who stands before the wall sees it.

    The first row is the top (largest v), the first column the viewer's left: where v is up, that is the
    largest u.
    """

    curved_along_v: ClassVar[bool] = True
    kind: Literal["heightmap"] = "heightmap"
    file: Annotated[
        str, Key("", "an image (its brightness, 0 to 1), or numbers in .npy, .csv or .txt", file=True)
    ] = ""
    heights: Annotated[
        tuple[tuple[float, ...], ...], Key("", "rows of numbers, in place of a file", low=-1e6, high=1e6)
    ] = ()
    relief: Annotated[
        float,
        Key(
            "m",
            "how far a value of 1 stands out toward the robot; 1 for values in metres",
            low=-10.0,
            high=10.0,
        ),
    ] = 0.05
    smoothing: Annotated[
        float,
        Key(
            "m",
            "standard deviation of a Gaussian that is laid over the values; 0 for none",
            low=0.0,
            high=10.0,
        ),
    ] = 0.0
    resolution: Annotated[
        float,
        Key("m", "pitch of the grid of the smooth surface that goes through the values", low=1e-4, high=1.0),
    ] = 0.01

    def check(self) -> None:
        """Raise a `ConfigError` for values that make no surface."""
        super().check()
        if bool(self.file) == bool(self.heights):
            raise ConfigError(
                "surface 'heightmap' needs either surface.file or surface.heights, and not both"
            )
        _ = self.values  # its checks
        nodes = self.size[0] * self.size[1] / self.resolution**2
        if nodes > _MOST_NODES:
            finest = (self.size[0] * self.size[1] / _MOST_NODES) ** 0.5
            raise refused(
                self,
                "resolution",
                f"makes {nodes:.3g} grid points of {self.size[0]:g} m x {self.size[1]:g} m: at least "
                f"{finest:.2g} m",
            )
        if not self.resolution < min(self.size):
            raise refused(self, "resolution", f"is no grid on {self.size[0]:g} m x {self.size[1]:g} m")

    @cached_property
    def sources(self) -> tuple[Source, ...]:
        """The file as it was read, where the values are in one."""
        return (read_table(self.file, f"height map '{self.file}'"),) if self.file else ()

    @cached_property
    def values(self) -> np.ndarray:
        """The checked values (rows, columns) as given."""
        name = f"height map '{self.file}'" if self.file else "surface.heights"
        values = values_in(self.sources[0], name) if self.file else checked_rows(self.heights, name)
        if values.ndim != 2 or min(values.shape) < 4:
            shape = " x ".join(map(str, values.shape))
            raise ConfigError(f"{name} has the shape {shape}: it needs rows and columns, 4 or more of each")
        bad = np.argwhere(~np.isfinite(values))
        if len(bad):
            row, column = bad[0]
            raise ConfigError(
                f"{name} has {len(bad)} values that are not finite, "
                f"the first in row {row + 1}, column {column + 1}"
            )
        return values

    def make_shape(self) -> Spline:
        """The smooth surface, shifted so that the origin lies on it."""
        relief = self.relief * on_grid(self.values)
        pixel = np.array(self.size) / (np.array(relief.shape) - 1)
        if self.smoothing:
            relief = bspline.smoothed(relief, self.smoothing / pixel)
        count = np.ceil(np.array(self.size) / self.resolution - 1e-9).astype(int) + 1
        axes = [
            np.clip((np.arange(n) - 0.5 * (n - 1)) * self.resolution / step + 0.5 * (cells - 1), 0, cells - 1)
            for n, step, cells in zip(count, pixel, relief.shape, strict=True)
        ]
        nodes = bspline.at_grid(bspline.coefficients(relief), *axes)
        # The same once more, so that the origin lies on it.
        return Spline.through(-nodes - Spline.through(-nodes, self.resolution).at_origin, self.resolution)
