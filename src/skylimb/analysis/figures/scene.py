"""The three-dimensional scene of a video: the robot, the camera and the lines drawn on the surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from skylimb.analysis.scores.board import Board, nominal_path, strokes
from skylimb.analysis.scores.signals import in_phase

if TYPE_CHECKING:
    import xarray as xr

SPACING = 0.008
"""Metres between the points of a drawn line."""

LIFT = 0.003
"""Metres by which lines stand before the surface, so that they are not lost in it."""

SURFACE_JOINT = "surface_slide"
"""The joint on which a moving surface slides, where the scene has one: what is drawn on it moves along."""

_FLAT = np.eye(3).ravel()


@dataclass(frozen=True)
class DrawnLine:
    """Segments of a line on the surface.

    Attributes:
        since: the sample from which each segment is seen, shape (n,).
        ends: both end points of each, W, m, shape (n, 2, 3).
        rgba: colour.
        width: of the line, m.
    """

    since: np.ndarray
    ends: np.ndarray
    rgba: np.ndarray
    width: float


def load_model(scene: str, size: tuple[int, int]) -> mujoco.MjModel:
    """Compile the scene (MJCF) for pictures of `size` (width, height), with a light if it has none."""
    spec = mujoco.MjSpec.from_string(scene)
    spec.visual.global_.offwidth = max(size[0], spec.visual.global_.offwidth)
    spec.visual.global_.offheight = max(size[1], spec.visual.global_.offheight)
    # Software renderers pay for every triangle and every sample; at this size one hardly sees the difference.
    spec.visual.quality.numslices = 20
    spec.visual.quality.numstacks = 10
    spec.visual.quality.numquads = 1
    spec.visual.quality.shadowsize = 1024
    spec.visual.quality.offsamples = 0
    if not spec.lights:
        spec.worldbody.add_light(pos=[-1.0, -2.0, 5.0], dir=[0.3, 0.4, -0.9], diffuse=[0.6, 0.6, 0.6])
    return spec.compile()


def camera_of(log: xr.Dataset, board: Board | None) -> mujoco.MjvCamera:
    """A camera for a flight that was flown; see `place_camera`."""
    normal = board.normal if board is not None else np.zeros(3)
    return place_camera(log.cog_position.values, log.tip_position.values, normal)


def place_camera(cogs: np.ndarray, tips: np.ndarray, normal: np.ndarray) -> mujoco.MjvCamera:
    """A camera that sees the drawn side of the surface and the whole robot.

    Args:
        cogs: where the centre of gravity comes, W, m, (n, 3).
        tips: where the tip comes, W, m, (n, 3).
        normal: out of the surface toward the robot, W, (3,); zeros without a surface.
    """
    cog, tip = np.median(cogs, axis=0), np.median(tips, axis=0)
    ahead = (tip - cog) * [1.0, 1.0, 0.0]
    camera = mujoco.MjvCamera()
    camera.lookat[:] = 0.45 * cog + 0.55 * tip
    # Stand on the side toward which the surface turns its face, and under it if that is downward.
    turn = -48.0 if np.cross(ahead, normal)[2] >= 0 else 48.0
    camera.azimuth = float(np.degrees(np.arctan2(ahead[1], ahead[0]))) + turn
    camera.elevation = 20.0 if normal[2] < -0.5 else -25.0
    camera.distance = 3.1
    return camera


def eye_and_target(camera: mujoco.MjvCamera) -> dict[str, list[float]]:
    """Where a camera stands (`position`) and looks (`target`), W, m, ready for JSON."""
    azimuth, elevation = np.radians(camera.azimuth), np.radians(camera.elevation)
    ahead = np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    target = np.array(camera.lookat)
    return {"target": target.tolist(), "position": (target - camera.distance * ahead).tolist()}


def pen_trace(log: xr.Dataset, rgb: np.ndarray) -> DrawnLine:
    """What the pen draws, growing with time."""
    since, ends = [np.zeros(0, dtype=int)], [np.zeros((0, 2, 3))]
    for stroke in strokes(log):
        numbers, segments = _spaced(log.tip_position.values[stroke])
        since.append(stroke.start + numbers)
        ends.append(segments)
    return DrawnLine(np.concatenate(since), np.concatenate(ends), _rgba(rgb), 0.011)


def nominal_line(log: xr.Dataset, board: Board | None) -> DrawnLine:
    """The nominal path, dashed, seen from the beginning."""
    path = nominal_path(log, board) if in_phase(log, "slide").any() else np.zeros((0, 3))
    ends = dashes(path)
    return DrawnLine(np.zeros(len(ends), dtype=int), ends, _rgba(np.array([0.35, 0.35, 0.35])), 0.005)


def dashes(path: np.ndarray) -> np.ndarray:
    """A path, (n, 3), as dashes: the ends of their segments, (k, 2, 3)."""
    _, ends = _spaced(path)
    return ends[np.arange(len(ends)) % 6 < 3]


class Lines:
    """Draws the segments of some lines that are seen at a moment.

    Successive moments are cheap: a segment that stands in the scene already is not made again.

    Args:
        lines: the lines.
        board: whose face they lie on; flat on it where it is a plane.
        motion: where the surface stands at each sample, W, m, shape (time, 3).
    """

    def __init__(self, lines: Sequence[DrawnLine], board: Board | None, motion: np.ndarray) -> None:
        segments = [(*one, line) for line in lines for one in zip(line.since, line.ends, strict=True)]
        self._segments = sorted(segments, key=itemgetter(0))
        self._since = [segment[0] for segment in self._segments]
        self._board, self._motion = board, motion
        self._moves = bool(np.any(motion != motion[:1]))
        self._first = self._made = 0

    def draw(self, scene: mujoco.MjvScene, sample: int) -> None:
        """Add what is seen at `sample` behind the geoms that `scene` has.

        Args:
            scene: the same at every call, with the model's geoms and nothing else that was added.
            sample: number of the log's sample.
        """
        seen = int(np.searchsorted(self._since, sample, side="right"))
        seen = min(seen, scene.maxgeom - scene.ngeom)
        if self._moves or scene.ngeom != self._first:
            self._first, self._made = scene.ngeom, 0
        for index in range(self._made, seen):
            self._make(scene.geoms[self._first + index], index, sample)
        self._made = max(self._made, seen)
        scene.ngeom = self._first + seen

    def _make(self, geom: mujoco.MjvGeom, index: int, sample: int) -> None:
        since, ends, line = self._segments[index]
        normal = self._board.normal if self._board is not None else np.zeros(3)
        begin, end = ends + LIFT * normal + self._motion[sample] - self._motion[since]
        width, rgba = line.width, line.rgba
        if self._board is not None and self._board.relief is None:
            along = end - begin
            length = float(np.linalg.norm(along))
            along = along / length
            axes = np.stack([along, np.cross(normal, along), normal], axis=1)
            half = np.array([0.5 * length + 0.2 * width, 0.5 * width, 0.001])
            mujoco.mjv_initGeom(
                geom, mujoco.mjtGeom.mjGEOM_BOX, half, 0.5 * (begin + end), axes.ravel(), rgba
            )
        else:
            kind = mujoco.mjtGeom.mjGEOM_CAPSULE
            mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), _FLAT, rgba)
            mujoco.mjv_connector(geom, kind, 0.5 * width, begin, end)
        geom.category = mujoco.mjtCatBit.mjCAT_DECOR


def surface_motion(model: mujoco.MjModel, configuration: np.ndarray) -> np.ndarray:
    """How far the surface stands from its first place at each sample: W, m, shape (time, 3)."""
    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, SURFACE_JOINT)
    if joint < 0:
        return np.zeros((len(configuration), 3))
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body_quat[model.jnt_bodyid[joint]])
    slid = configuration[:, model.jnt_qposadr[joint]]
    return (slid - slid[0])[:, None] * (rotation.reshape(3, 3) @ model.jnt_axis[joint])


def _spaced(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Segments about `SPACING` long along the line: the index at which each ends, and its ends (n, 2, 3)."""
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    wanted = np.arange(0.0, travelled[-1], SPACING)
    keep = np.unique(np.searchsorted(travelled, wanted))
    return keep[1:], np.stack([points[keep[:-1]], points[keep[1:]]], axis=1)


def _rgba(rgb: np.ndarray) -> np.ndarray:
    return np.append(rgb, 1.0).astype(np.float32)
