"""A picture of a robot in its nominal posture: shapes, rotors, centre of gravity and frames."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from skylimb.apps.robot_import.checking import RobotReport
from skylimb.base.rotations import rotation_from_axis_angle
from skylimb.robots.description import RobotDescription
from skylimb.robots.extent import rim
from skylimb.robots.links import Visual

Pose = tuple[np.ndarray, np.ndarray]

_VIEWS = (
    ("from above and the side", 28.0, -60.0, ""),
    ("from above", 90.0, -90.0, "z"),
    ("from the side", 0.0, -90.0, "y"),
)
"""Title, elevation and azimuth (degrees) of each view, and the axis that points at the viewer."""

_SPINS = {1: "#0072B2", -1: "#D55E00"}
_AXES = ("#B00020", "#2E7D32", "#1565C0")
_INK, _GREY, _LINK = "#1A1A1A", "#9A9A9A", "#666666"
_MOST_EDGES, _SHARP = 300, 0.3
"""Edges of a shape that are drawn at most, and the angle between two faces from which on they are, rad."""


def draw_robot(report: RobotReport, path: str | Path) -> None:
    """Draw the robot of a report in three views into a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.6), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    description = report.description
    poses = link_poses(description, _angles(report))
    for index, (title, elevation, azimuth, unseen) in enumerate(_VIEWS):
        axes: Any = figure.add_subplot(1, 3, index + 1, projection="3d", proj_type="ortho")
        points = _draw(axes, description, poses, labels=index == 1)
        axes.view_init(elev=elevation, azim=azimuth)
        _frame(axes, points, unseen)
        axes.set_title(title, fontsize=9)
    state = "can hover" if report.can_hover else "cannot hover"
    figure.suptitle(
        f"{description.name}: {report.mass:.3f} kg, {len(description.rotors)} rotors, {state}. "
        "Discs: rotors (blue +z, orange -z), arrows: thrust, star: centre of gravity, ball: tip",
        fontsize=9,
        color=_INK if report.can_hover else "#B00020",
    )
    figure.savefig(path, format="png")


def _angles(report: RobotReport) -> dict[str, float]:
    """Nominal joint angles, and the vectoring angles of the hover that was found, by joint."""
    description = report.description
    posture, acting = report.description.posture, report.actuation
    q = posture.offset + posture.slope * posture.theta_nominal
    hover = acting.hover if acting is not None else None
    psi = hover.vectoring_angles if hover else description.vectoring_start
    names = [*description.shape_joints, *description.vectoring_joints]
    return dict(zip(names, map(float, [*q, *psi]), strict=True))


def link_poses(description: RobotDescription, angles: dict[str, float]) -> dict[str, Pose]:
    """Position (m) and orientation of every link's frame in the root's, at joint angles by name (rad).

    It needs no model, so a robot that cannot exist is placed as well.
    """
    poses: dict[str, Pose] = {description.root: (np.zeros(3), np.eye(3))}
    for joint in description.joints:
        xyz, R = poses[joint.parent]
        turned = rotation_from_axis_angle(joint.axis.tolist(), angles.get(joint.name, 0.0))
        poses[joint.child] = (xyz + R @ joint.xyz, R @ joint.R @ turned)
    return poses


def _draw(axes: Any, description: RobotDescription, poses: dict[str, Pose], *, labels: bool) -> np.ndarray:
    points = [xyz for xyz, _ in poses.values()]
    for joint in description.joints:
        ends = np.array([poses[joint.parent][0], poses[joint.child][0]])
        axes.plot(*ends.T, color=_LINK, lw=2.0 if joint.kind == "fixed" else 3.0, solid_capstyle="round")
    for link in description.links:
        for shape in link.collisions or link.visuals:
            placed = poses[link.name][0] + _outline(shape) @ poses[link.name][1].T
            axes.plot(*placed.T, color=_GREY, lw=0.5)
            points += list(placed[np.isfinite(placed[:, 0])])
    size = float(np.ptp(np.array(points), axis=0).max()) or 1.0
    for joint in description.joints:
        if joint.kind != "fixed":
            at, R = poses[joint.child]
            ends = at + np.outer([-0.04 * size, 0.04 * size], R @ joint.axis)
            axes.plot(*ends.T, color="#CC79A7", lw=1.5)
    for rotor in description.rotors:
        at, R = poses[rotor.link]
        centre, frame = at + R @ rotor.xyz, R @ rotor.R
        circle = at + rim(rotor) @ R.T
        axes.plot(*circle.T, color=_SPINS[rotor.spin], lw=1.5)
        axes.quiver(*centre, *(0.16 * size * frame[:, 2]), color=_SPINS[rotor.spin], lw=1.2)
        points += [centre + 0.16 * size * frame[:, 2], *circle]
        if labels:
            axes.text(*centre, rotor.name, fontsize=7, color=_INK)
    masses = np.array([max(link.inertial.mass, 0.0) for link in description.links])
    centres = np.array(
        [poses[link.name][0] + poses[link.name][1] @ link.inertial.com for link in description.links]
    )
    if masses.sum() > 0.0:
        axes.scatter(*(masses @ centres / masses.sum()), marker="*", s=110, color=_INK, zorder=5)
    at, R = poses[description.tip.link]
    tip = at + R @ description.tip.position
    axes.scatter(*tip, s=25, color="#B00020", zorder=5)
    axes.plot(*np.array([at, tip]).T, color="#B00020", lw=1.0)
    points.append(tip)
    for name in {description.root, description.tip.link}:
        at, R = poses[name]
        for column, colour in enumerate(_AXES):
            axes.plot(*np.array([at, at + 0.1 * size * R[:, column]]).T, color=colour, lw=1.5)
    return np.array(points)


def _frame(axes: Any, points: np.ndarray, unseen: str) -> None:
    """Equal scales about the middle of all points."""
    low, high = points.min(axis=0), points.max(axis=0)
    half, middle = 0.55 * float((high - low).max() or 1.0), 0.5 * (low + high)
    axes.set_box_aspect((1.0, 1.0, 1.0))
    axes.tick_params(labelsize=6)
    for name, at in zip("xyz", middle, strict=True):
        axes.set(**{f"{name}lim": (at - half, at + half)})
        axes.set(**{f"{name}ticks": []} if name == unseen else {f"{name}label": f"{name} (m)"})


def _outline(shape: Visual) -> np.ndarray:
    """Sharp edges of a shape's convex hull in its link's frame, m, (3 k, 3): ends of each, then a gap.

    None for a mesh that cannot be read.
    """
    import trimesh
    from trimesh import creation

    made = {"box": creation.box, "cylinder": creation.cylinder, "sphere": partial(creation.icosphere, 1)}
    try:
        if shape.shape == "mesh":
            mesh, scale = trimesh.load(str(shape.mesh), force="mesh"), np.array(shape.size)
        else:
            given = (shape.size,) if shape.shape == "box" else shape.size
            mesh, scale = made[shape.shape](*given), np.ones(3)
        hull = mesh.convex_hull  # type: ignore[union-attr]
        edges = hull.face_adjacency_edges[hull.face_adjacency_angles > _SHARP]
        ends = hull.vertices[edges[:: max(1, len(edges) // _MOST_EDGES)]] * scale
    except Exception:  # readers of many kinds of files raise many kinds of errors; the picture goes on
        return np.zeros((0, 3))
    ends = shape.xyz + ends @ shape.R.T
    return np.concatenate([ends, np.full((len(ends), 1, 3), np.nan)], axis=1).reshape(-1, 3)
