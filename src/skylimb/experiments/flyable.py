"""What must hold between robot, surface and path before anything flies."""

from __future__ import annotations

import mujoco
import numpy as np

from skylimb.control.records import Reference
from skylimb.simulation.mission import PHASES, Mission
from skylimb.simulation.plant import Plant, initial_data
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.surfaces import require_clear, require_fits, require_path


def first_row(mission: Mission) -> Reference:
    """What the mission asks for before take-off."""
    return Reference(*(entry[0] for entry in mission.reference))


def require_flyable(plant: Plant, mission: Mission) -> None:
    """Raise a `ConfigError` unless the tip fits the surface, the robot starts clear and the path stays on."""
    surface, tip = plant.surface, plant.robot.description.tip
    require_fits(surface, tip.radius)
    data = initial_data(plant, first_row(mission))
    bodies = data.xpos[1:][[not name.startswith("surface") for name in _body_names(plant.model)]]
    points = np.vstack([bodies, data.site(TIP_SITE).xpos])
    require_clear(surface, points, tip.radius, plant.robot.name)
    sliding = mission.phase == PHASES.index("slide")
    if mission.contact:
        require_path(surface, mission.tip_path[sliding])


def _body_names(model: mujoco.MjModel) -> list[str]:
    return [model.body(i).name for i in range(1, model.nbody)]
