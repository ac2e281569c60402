"""How near a robot's discs and bodies came to the surface, besides the tool that is to touch it."""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.rotations import rotation_from_quaternion
from skylimb.robots.extent import Part, parts_of
from skylimb.robots.model import Robot
from skylimb.simulation.plant import Plant
from skylimb.simulation.surfaces.touched import Touched

_EVERY = 0.05
"""Time between the moments that are looked at first, s; around the nearest of them every tick is."""


class Clearance(NamedTuple):
    """The part that came nearest: its name, its least distance (m, negative behind the surface), when (s)."""

    part: str
    distance: float
    time: float


def least_clearance(plant: Plant, qpos: np.ndarray, times: np.ndarray, surface: Touched) -> Clearance:
    """The nearest that any part of the robot that flew came to the surface.

    A part counts by points of its hull, so it is exact for what is flat and cannot see what pokes between
    them.

    Args:
        plant: what flew.
        qpos: configuration of the scene at the ticks, (ticks, nq).
        times: of the ticks, s, (ticks,).
        surface: as it was then.
    """
    step = max(round(_EVERY / float(times[1] - times[0])), 1) if len(times) > 1 else 1
    seldom = _nearest(plant, qpos[::step], times[::step], surface)
    around = np.abs(times - seldom.time) < _EVERY
    closely = _nearest(plant, qpos[around], times[around], surface)
    return min(seldom, closely, key=lambda one: one.distance)


def _nearest(plant: Plant, qpos: np.ndarray, times: np.ndarray, surface: Touched) -> Clearance:
    """The nearest that any part came at just these moments; see `least_clearance`."""
    parts, which, poses = _parts(plant.robot)
    angles = (qpos[:, list(plant.joint_qpos)].T, qpos[:, list(plant.vectoring_qpos)].T)
    placed = poses.map(len(times))(*angles).full().T.reshape(len(times), -1, 4, 3)
    turns = np.array([rotation_from_quaternion(row) for row in qpos[:, 3:7]])
    # Row 0 is the link's origin, the others are its axes: all in the root's frame, then in W.
    placed = placed @ turns.transpose(0, 2, 1)[:, None]
    placed[:, :, 0] += qpos[:, None, :3]

    def distances(link: Any, points: np.ndarray, ticks: np.ndarray) -> np.ndarray:
        """Of points (k, 3) of a link, or of one link each, from the surface at some ticks, m, (ticks, k)."""
        xyz, axes = placed[ticks][:, link, 0], placed[ticks][:, link, 1:]
        world = xyz + np.einsum(
            "kp,tkpi->tki", points, np.broadcast_to(axes, (len(ticks), len(points), 3, 3))
        )
        found = surface.signed_distance(world.reshape(-1, 3), np.repeat(times[ticks], len(points)))
        return np.nan_to_num(found, nan=np.inf).reshape(len(ticks), -1)

    # A part is no farther than its middle, and no nearer than that less its size: most are out at once.
    middles = np.array([part.points.mean(axis=0) for part in parts])
    radii = np.array([part.radius for part in parts])
    reach = distances(which, middles, np.arange(len(times))) - radii
    sizes = [
        np.linalg.norm(part.points - middle, axis=1).max()
        for part, middle in zip(parts, middles, strict=True)
    ]
    least = reach.min()
    found = [Clearance("", math.inf, 0.0)]
    for index, (part, size) in enumerate(zip(parts, sizes, strict=True)):
        ticks = np.flatnonzero(reach[:, index] - size <= least)
        if len(ticks):
            near = distances([which[index]], part.points, ticks).min(axis=1) - part.radius
            at = int(np.argmin(near))
            found.append(Clearance(part.name, float(near[at]), float(times[ticks[at]])))
    return min(found, key=lambda one: one.distance)


@functools.lru_cache(maxsize=16)
def _parts(robot: Robot) -> tuple[list[Part], list[int], ca.Function]:
    """The parts, the number of each one's link, and (q, psi) -> places and axes of the links, (12 links,)."""
    parts = parts_of(robot.description)
    links = list(dict.fromkeys(part.link for part in parts))
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    found = ca.vertcat(*map(ca.vec, robot.link_pose_function(*links).call([q, psi])))
    which = [links.index(part.link) for part in parts]
    return parts, which, ca.Function("parts", [q, psi], [ca.densify(found)], {"cse": True})
