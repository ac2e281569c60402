"""The picture of what a robot can do in a posture: its pushes around the tip, its torques in hover."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial import ConvexHull

from skylimb.analysis.figures import style
from skylimb.base.rotations import rot_z
from skylimb.studies.planning.feasible_wrench import FeasibleWrench
from skylimb.studies.planning.outline import outline

_AROUND = np.linspace(0.0, 2.0 * np.pi, 40)
_AXES = ("+x", "-x", "+y", "-y", "+z", "-z")


@style.styled
def wrench_figure(feasible: FeasibleWrench, pushes: Mapping[str, tuple[np.ndarray, float]]) -> Figure:
    """The robot from the side with its pushes, and the torques that are left while it hovers.

    Args:
        feasible: what is drawn.
        pushes: the greatest push by name: unit vector in the heading frame and force in N,
            NaN where none was found.
    """
    figure = Figure(figsize=(style.WIDTH, 2.4))
    left = figure.add_axes((-0.04, -0.12, 0.5, 1.15), projection="3d", proj_type="ortho")
    bars = figure.add_axes((0.52, 0.2, 0.12, 0.62))
    right = figure.add_axes((0.655, 0.04, 0.29, 0.82), projection="3d", proj_type="ortho")
    for axes in (left, right):
        axes.patch.set_visible(False)  # they reach under the bars
    _draw_robot(left, feasible)
    _draw_pushes(left, feasible, pushes)
    _draw_bars(bars, pushes)
    _draw_torques(right, feasible)
    radius = 0.0 if feasible.hover_torques is None else max(feasible.hover_torques.margin(np.zeros(3)), 0.0)
    figure.text(0.02, 0.93, "The robot and its tip's pushes at rest", weight="bold", size=8)
    figure.text(0.48, 0.93, "Greatest push, N", weight="bold", size=8)
    figure.text(0.69, 0.93, "Torques in hover, N m", weight="bold", size=8)
    figure.text(0.69, 0.87, f"at least {radius:.2f} about every axis (ball)", size=6.5)
    return figure


def _draw_robot(axes: Any, feasible: FeasibleWrench) -> None:
    """Links, rotors with their hover thrusts, centre of gravity and tip, in the heading frame."""
    state = feasible.state
    to_heading = rot_z(-state.tip_heading) @ state.R_root_C.T
    chain, rotors = outline(feasible.robot, feasible.joint_angles, feasible.vectoring_angles)
    chain = (chain - state.cog_root) @ to_heading.T
    axes.plot(*chain.T, color=style.DARK, lw=2.0)
    for (place, axis, disc), thrust in zip(rotors, state.hover_thrusts, strict=True):
        at, up = to_heading @ (place - state.cog_root), 0.02 * thrust * to_heading @ axis
        axes.plot(*(to_heading @ (disc - state.cog_root).T), color=style.TRUTH, lw=0.8)
        axes.quiver(*at, *up, color=style.CURVES[0], lw=0.9, arrow_length_ratio=0.15)
    axes.plot(0.0, 0.0, 0.0, "*", color=style.CURVES[4], ms=7, label="centre of gravity")
    axes.plot(*chain[-1], "o", color=style.DARK, ms=3)
    axes.view_init(elev=32.0, azim=-75.0)
    axes.set_axis_off()
    corner = chain.min(axis=0) - np.array([0.0, 0.15, 0.0])
    axes.plot(*np.array([corner, corner + np.array([0.5, 0.0, 0.0])]).T, color=style.DARK, lw=1.0)
    axes.text(*(corner + np.array([0.25, -0.28, 0.0])), "0.5 m along the heading", fontsize=6, ha="center")


def _draw_pushes(axes: Any, feasible: FeasibleWrench, pushes: Mapping[str, tuple[np.ndarray, float]]) -> None:
    """The set of level pushes where it is solid, else an arrow for each push; drawn from the tip on."""
    tip = rot_z(-feasible.state.tip_heading) @ feasible.state.tip_C
    level = feasible.level_pushes
    found = {name: push for name, push in pushes.items() if np.isfinite(push[1])}
    most = max([force for _, force in found.values()] + [1e-9])
    if level is not None and level.dimension == 3 and len(level.vertices):
        most = float(np.linalg.norm(level.vertices, axis=1).max())
        _draw_solid(axes, tip + 0.5 / most * level.vertices, style.CURVES[1])
    for name, (direction, force) in found.items():
        colour = style.CURVES[1] if name in _AXES else style.CURVES[3]
        end = tip + 0.5 / most * force * direction
        axes.quiver(*tip, *(end - tip), color=colour, lw=1.4, arrow_length_ratio=0.12)
        if name not in _AXES:  # the axes' names stand beside their bars, in the figure's own directions
            axes.text(*(end + 0.08 * direction), name, fontsize=6, color=colour, ha="center", va="center")
    _tidy(axes)


def _draw_bars(axes: Any, pushes: Mapping[str, tuple[np.ndarray, float]]) -> None:
    """The greatest push in each direction, N."""
    names, forces = list(pushes), [force for _, force in pushes.values()]
    colours = [style.CURVES[1] if name in _AXES else style.CURVES[3] for name in names]
    places = np.arange(len(names))[::-1]
    labels = ["none found" if np.isnan(force) else f"{force:.1f}" for force in forces]
    forces = np.nan_to_num(forces)  # without a bar; the label says why
    bars = axes.barh(places, forces, color=colours, height=0.6)
    axes.bar_label(bars, labels, fontsize=6, padding=2)
    axes.set_yticks(places, names)
    axes.set_xlim(0.0, 1.35 * max([*forces, 1e-9]))
    axes.set_xticks([])
    axes.spines["bottom"].set_visible(False)
    axes.tick_params(labelsize=6.5, length=0)


def _draw_torques(axes: Any, feasible: FeasibleWrench) -> None:
    """The torques in hover, and the greatest ball of torques about every axis among them."""
    torques = feasible.hover_torques
    if torques is None or torques.dimension < 3 or not len(torques.vertices):
        axes.text2D(0.1, 0.5, "It cannot hover with torques about all axes", transform=axes.transAxes)
        axes.set_axis_off()
        return
    _draw_solid(axes, torques.vertices, style.CURVES[0])
    radius = max(torques.margin(np.zeros(3)), 0.0)
    polar = np.linspace(0.0, np.pi, 20)[:, None]
    ball = np.sin(polar) * np.cos(_AROUND), np.sin(polar) * np.sin(_AROUND), np.cos(polar) + 0.0 * _AROUND
    axes.plot_surface(*(radius * part for part in ball), color=style.CURVES[2], alpha=0.6, lw=0)
    axes.set(xlabel="roll", ylabel="pitch", zlabel="yaw")
    axes.view_init(elev=28.0, azim=-60.0)
    _tidy(axes)


def _tidy(axes: Any) -> None:
    axes.set_aspect("equal")
    axes.tick_params(labelsize=5.5, pad=-2)
    axes.grid(lw=0.3)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.labelpad = -6
        axis.label.set_size(6.5)
        axis.set_major_locator(MaxNLocator(4))


def _draw_solid(axes: Any, vertices: np.ndarray, colour: str) -> None:
    hull = ConvexHull(vertices)
    faces = Poly3DCollection(vertices[hull.simplices], alpha=0.15, facecolor=colour)
    axes.add_collection3d(faces)
    for simplices in _edges(hull):
        axes.plot(*vertices[simplices].T, color=colour, lw=0.6)


def _edges(hull: ConvexHull) -> list[list[int]]:
    """Edges between two triangles that do not lie in one plane."""
    found = []
    for i, neighbours in enumerate(hull.neighbors):
        for k, j in enumerate(neighbours):
            flat = np.allclose(hull.equations[i], hull.equations[j], atol=1e-9)
            if j > i and not flat:
                found.append([vertex for n, vertex in enumerate(hull.simplices[i]) if n != k])
    return found
