"""A user's mesh as a wall: its front, seen along the contact axis, as a smooth surface."""

from __future__ import annotations

import io
import itertools
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from skylimb.base.errors import ConfigError, missing_extra
from skylimb.base.keys import Key, configuration
from skylimb.base.rotations import rotation_from_rpy
from skylimb.base.sources import Source, read_source
from skylimb.simulation.surfaces.curved import CurvedSurface
from skylimb.simulation.surfaces.spline import Spline

_KINDS = ("stl", "obj", "ply", "off", "gltf", "glb")
"""Neither archives, which may unpack to anything, nor formats that other programs read."""
_BLOCK, _MOST_PLACES = 200_000, 20_000_000
"""Points in boxes around triangles that are looked at at once, and in all."""
_LARGEST = 50.0  # m: a wall beyond this was given in millimetres


@configuration
class MeshSurface(CurvedSurface):
    """The front of a mesh: what a ray along the contact axis meets first, made smooth by a cubic B-spline.

    The mesh's x axis points into the surface, y along u and z along v, after `mesh_rpy`; the middle of its
    bounding box comes to u = v = 0. Its front must cover all of `size`, and the smooth surface must agree
    with it to `tolerance`.
    """

    curved_along_v: ClassVar[bool] = True
    kind: Literal["mesh"] = "mesh"
    size: tuple[float, float] = (0.8, 0.8)
    file: Annotated[str, Key("", "STL, OBJ, PLY, OFF, glTF or GLB", file=True)] = ""
    scale: Annotated[
        float, Key("m", "length of one unit of the file; 0.001 for millimetres", above=0.0, high=1000.0)
    ] = 1.0
    mesh_rpy: Annotated[
        tuple[float, float, float],
        Key("rad", "roll, pitch and yaw that turn the mesh's axes into (w, u, v)", low=-6.3, high=6.3),
    ] = (0.0, 0.0, 0.0)
    allow_open: Annotated[
        bool, Key("", "whether a mesh with a border, such as a scanned sheet, is welcome")
    ] = False
    resolution: Annotated[float, Key("m", "pitch of the grid of the smooth surface", low=1e-4, high=0.1)] = (
        0.005
    )
    tolerance: Annotated[
        float, Key("m", "largest distance allowed between mesh and smooth surface", low=1e-6, high=0.1)
    ] = 0.001

    def check(self) -> None:
        """Raise a `ConfigError` for a mesh that is no wall."""
        super().check()
        if not self.file:
            raise ConfigError("surface 'mesh' needs surface.file, the path of an STL or OBJ file")
        _ = self.shape  # the mesh's checks

    @property
    def sources(self) -> tuple[Source, ...]:
        """The mesh's file, and those that it names, as they were read."""
        return self._mesh[1]

    @cached_property
    def _mesh(self) -> tuple[Any, tuple[Source, ...]]:
        return _read(self.file, f"mesh '{self.file}'")

    @cached_property
    def triangles(self) -> np.ndarray:
        """(n, 3, 3) corners of the checked mesh's triangles as (w, u, v), m, centred in u and v."""
        name = f"mesh '{self.file}'"
        mesh, _ = self._mesh
        corners = np.asarray(mesh.triangles, dtype=float)
        if not len(corners) or not float(mesh.area) > 0.0:
            raise ConfigError(f"{name} is empty or cut off: it has no triangle with an area")
        if not (self.allow_open or mesh.is_watertight):
            raise ConfigError(
                f"{name} is open (it has a border or a hole): close it, "
                "or set surface.allow_open = true for a sheet"
            )
        corners = self.scale * corners @ rotation_from_rpy(*self.mesh_rpy).T
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        largest = float((high - low).max())
        if largest > _LARGEST:
            raise ConfigError(
                f"{name} is {largest:.4g} m large: is it in millimetres? Then set surface.scale = "
                f"{self.scale * 1e-3:g}"
            )
        return corners - [0.0, *(0.5 * (low + high))[1:]]

    def make_shape(self) -> Spline:
        """The smooth front, shifted so that the origin lies on it."""
        name = f"mesh '{self.file}'"
        count = np.ceil(np.array(self.size) / self.resolution - 1e-9).astype(int) + 1
        # Twice as fine as the spline's grid, so that every other point is a check that the spline did not
        # see.
        u, v = ((np.arange(2 * n - 1) - (n - 1)) * 0.5 * self.resolution for n in count)
        triangles = self.triangles
        try:
            front = front_heights(triangles, u, v)
        except ConfigError as error:
            raise ConfigError(f"{name}: {error}") from None
        missing = np.argwhere(np.isnan(front))
        if len(missing):
            i, j = missing[len(missing) // 2]
            box = np.ptp(triangles, axis=(0, 1))
            raise ConfigError(
                f"{name} does not cover surface.size = {self.size[0]:g} m x {self.size[1]:g} m: "
                f"there is nothing at u = {u[i]:.3g} m, v = {v[j]:.3g} m; "
                f"it spans {box[1]:.3g} m x {box[2]:.3g} m in all"
            )
        shape = Spline.through(front[::2, ::2], self.resolution)
        h = shape.on_grid(u, v)
        hu, hv = np.gradient(h, u, v)
        error = np.abs(h - front) / np.sqrt(1.0 + hu**2 + hv**2)
        i, j = np.unravel_index(np.argmax(error), error.shape)
        if error[i, j] > self.tolerance:
            raise ConfigError(
                f"{name}: a smooth surface is off by {1e3 * error[i, j]:.3g} mm at u = {u[i]:.3g} m, "
                f"v = {v[j]:.3g} m (surface.tolerance = {1e3 * self.tolerance:g} mm): lower "
                f"surface.resolution = {self.resolution:g} m, or raise the tolerance to round edges"
            )
        return Spline.through(front[::2, ::2] - shape.at_origin, self.resolution)


def _read(file: str, name: str) -> tuple[Any, tuple[Source, ...]]:
    """The mesh in a file, and every file that was read for it."""
    try:
        import trimesh
        from trimesh.resolvers import FilePathResolver
    except ImportError:
        raise missing_extra("trimesh") from None
    try:
        source = read_source(file)
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}") from None
    read = [source]

    class Recorded(FilePathResolver):
        """Finds the files that a mesh's file names (buffers, materials), and keeps what was read."""

        def get(self, name: str) -> bytes:
            read.append(read_source(source.path.parent / name.strip()))
            return read[-1].content

    kind = source.path.suffix.lower().lstrip(".")
    if kind not in _KINDS:
        raise ConfigError(f"{name}: cannot read a '.{kind}' file; these are known: {', '.join(_KINDS)}")
    try:
        mesh = trimesh.load_mesh(
            io.BytesIO(source.content),
            file_type=kind,
            resolver=Recorded(str(source.path)),
            process=False,
        )
        corners = np.asarray(mesh.vertices, dtype=float)
        if not np.isfinite(corners).all():
            bad = int(np.argwhere(~np.isfinite(corners))[0][0])
            raise ConfigError(
                f"{name} has corners that are not finite numbers, the first is corner {bad + 1}: "
                f"{corners[bad].tolist()}"
            )
        mesh.process()  # which leaves such corners out, and their triangles, without a word
        return mesh, tuple(read)
    except ConfigError:
        raise
    except Exception as error:  # trimesh raises whatever its readers do
        message = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ConfigError(f"{name} cannot be read: {message}") from error


def front_heights(triangles: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Smallest w of triangles (n, 3, 3) of (w, u, v) over the grid u x v; NaN where there is none.

    Raises:
        ConfigError: they lie so often over each other that it would take long.
    """
    heights = np.full((len(u), len(v)), np.inf)
    (_, u0, v0), (_, u1, v1), (_, u2, v2) = triangles.transpose(1, 2, 0)
    flat = np.abs((u1 - u0) * (v2 - v0) - (u2 - u0) * (v1 - v0)) < 1e-15
    triangles = triangles[~flat]  # the others are seen edge-on
    slack = 1e-9 * (float(np.ptp(u)) + float(np.ptp(v)))
    first_u = np.searchsorted(u, triangles[:, :, 1].min(axis=1) - slack)
    last_u = np.searchsorted(u, triangles[:, :, 1].max(axis=1) + slack)
    first_v = np.searchsorted(v, triangles[:, :, 2].min(axis=1) - slack)
    last_v = np.searchsorted(v, triangles[:, :, 2].max(axis=1) + slack)
    counts = (last_u - first_u) * (last_v - first_v)
    most = max(_MOST_PLACES, 10 * heights.size)
    if counts.sum() > most:
        raise ConfigError(
            f"its {len(triangles)} triangles lie {counts.sum():.3g} times over the grid's points, more than "
            f"{most:.3g}: simplify the mesh"
        )
    # Many small triangles at once: each with every point of the grid in the box around it.
    blocks = np.searchsorted(np.cumsum(counts), np.arange(0, counts.sum() + _BLOCK, _BLOCK))
    for begin, end in itertools.pairwise(np.unique([0, *blocks, len(counts)])):
        number = np.repeat(np.arange(begin, end), counts[begin:end])
        within = np.arange(len(number)) - np.repeat(
            np.cumsum(counts[begin:end]) - counts[begin:end], counts[begin:end]
        )
        width = last_v[number] - first_v[number]
        i, j = first_u[number] + within // width, first_v[number] + within % width
        (w0, u0, v0), (w1, u1, v1), (w2, u2, v2) = triangles[number].transpose(1, 2, 0)
        area = (u1 - u0) * (v2 - v0) - (u2 - u0) * (v1 - v0)
        du, dv = u[i] - u0, v[j] - v0
        b1 = (du * (v2 - v0) - dv * (u2 - u0)) / area
        b2 = (dv * (u1 - u0) - du * (v1 - v0)) / area
        inside = (b1 >= -1e-9) & (b2 >= -1e-9) & (b1 + b2 <= 1.0 + 1e-9)
        w = w0 + b1 * (w1 - w0) + b2 * (w2 - w0)
        np.minimum.at(heights, (i[inside], j[inside]), w[inside])
    return np.where(np.isfinite(heights), heights, np.nan)
