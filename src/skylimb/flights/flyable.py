"""What must hold between robot, surface and path before anything flies."""

from __future__ import annotations

import mujoco
import numpy as np

from skylimb.missions.mission import Mission
from skylimb.simulation.plant import Plant
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.surfaces import Surface, require_clear, require_fits, require_path


def require_flyable(plant: Plant, mission: Mission, start: mujoco.MjData) -> None:
    """Raise a `ConfigError` unless the tip fits the surface, the robot starts clear and the path stays on.

    Args:
        plant: what flies, and its surface.
        mission: the references of the flight.
        start: the plant's state before take-off.
    """
    surface, tip = plant.surface, plant.robot.description.tip
    require_fits(surface, tip.radius)
    bodies = start.xpos[1:][[not name.startswith("surface") for name in _body_names(plant.model)]]
    points = np.vstack([bodies, start.site(TIP_SITE).xpos])
    require_clear(surface, points, tip.radius, plant.robot.name)
    if mission.contact:
        require_path(surface, mission.tip_path[mission.in_phase("slide", "lift")])


def _body_names(model: mujoco.MjModel) -> list[str]:
    return [model.body(i).name for i in range(1, model.nbody)]


def standing_out(surface: Surface, mission: Mission) -> float:
    """How far the surface stands out toward the robot, at most, under the ways on which the pen is lifted.

    A mission lays its path on the nominal surface, a plane through the middle of the path. A pen that goes
    from stroke to stroke must pass over what stands out of that plane, so whoever plans the flight must know
    this one number; no controller knows more.

    Returns:
        m, from the plane along the contact axis; 0 where nothing stands out or nothing is lifted.
    """
    lifted = mission.in_phase("lift")
    if not lifted.any():
        return 0.0
    axis = mission.frame.contact
    gaps = surface.distance_along(mission.tip_path[lifted], axis)
    moved = surface.motion(mission.times)[0] * float(surface.motion_axis @ axis)
    nearest = float(np.nanmin(gaps, initial=0.0)) + min(float(moved.min()), 0.0)
    return max(0.0, -nearest)
