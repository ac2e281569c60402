"""What must hold between robot, surface and path before anything flies."""

from __future__ import annotations

import numpy as np

from skylimb.base.rotations import rot_z
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.plan import NOTHING, StandingOut
from skylimb.control.missions.reference import Reference
from skylimb.robots.model import Robot
from skylimb.simulation.surfaces import Surface, require_clear, require_fits, require_path

_BEGUN = 0.005
"""Way over which a surface shows its slope, m."""


def require_flyable(surface: Surface, robot: Robot, mission: Mission) -> None:
    """Raise a `ConfigError` unless the tip fits the surface, the robot starts clear and the path stays on.

    Args:
        surface: what is to be touched.
        robot: as it is described.
        mission: the references of the flight.
    """
    tip = robot.description.tip
    require_fits(surface, tip.radius)
    require_clear(surface, points_of(robot, mission.first), tip.radius, robot.name, mission.frame.contact)
    if mission.contact:
        require_path(surface, mission.tip_path[mission.in_phase("slide", "lift")])


def points_of(robot: Robot, first: Reference) -> np.ndarray:
    """Origins of all bodies and the tip of a robot that hovers as a reference asks, W, m, (k, 3)."""
    state = robot.at(first.joint_angles, first.vectoring_angles)
    links = robot.link_poses(first.joint_angles, first.vectoring_angles)
    points = np.array([*(links[body.name][0] for body in robot.bodies), state.tip_root])
    R_WB = rot_z(first.heading - state.tip_heading) @ state.R_root_C.T
    return np.asarray(first.position) + (points - state.cog_root) @ R_WB.T


def standing_out(surface: Surface, mission: Mission) -> StandingOut:
    """What stands out toward the robot under the ways on which the pen is lifted.

    A mission lays its path on the nominal surface, a plane through the middle of the path. A pen that goes
    from stroke to stroke must pass over what stands out of that plane, so whoever plans the flight must know
    how far that is, and how far beyond place and slope at which each lift begins; no controller knows more.

    Returns:
        Nothing where nothing is lifted.
    """
    lifted = np.flatnonzero(mission.in_phase("lift"))
    if not len(lifted):
        return NOTHING
    axis = mission.frame.contact
    path = mission.tip_path[lifted]
    gaps = surface.distance_along(path, axis)
    moved = surface.motion(mission.times)[0] * float(surface.motion_axis @ axis)
    nearest = float(np.nanmin(gaps, initial=0.0)) + min(float(moved.min()), 0.0)
    # A surface that moves may be elsewhere by the time that the pen comes back.
    sways = float(moved.max() - moved.min())
    # A lift begins where touch is wanted no more, also where a stroke is no longer than a tick.
    leaves = np.flatnonzero(np.diff(np.asarray(mission.reference.touch)[lifted]) < -0.5) + 1
    each = np.split(np.arange(len(lifted)), leaves)
    ways = tuple(_beyond_left(path[way], gaps[way]) + sways for way in each)
    return StandingOut(max(0.0, -nearest), ways)


def _beyond_left(path: np.ndarray, gaps: np.ndarray) -> float:
    """How far a surface stands out beyond its place and its slope where a lift began, m.

    Args:
        path: of the lift, (k, 3), m.
        gaps: from there to the surface, (k,), m.
    """
    gone, rise = np.linalg.norm(path - path[0], axis=1), gaps - gaps[0]
    begun = min(int(np.searchsorted(gone, _BEGUN)), len(gone) - 1)
    slope = rise[begun] / max(float(gone[begun]), 1e-9)
    return float(np.nanmax(np.minimum(slope * gone, 0.0) - rise, initial=0.0))
