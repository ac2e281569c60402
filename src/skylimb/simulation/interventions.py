"""What acts on the plant from outside before a tick's physics: a moving surface, its changes, a push."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from skylimb.simulation.disturbance import Push, pusher
from skylimb.simulation.plant import Plant
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.surface_changes import SurfaceWriter, surface_act
from skylimb.simulation.surfaces import PairFriction


def interventions(
    plant: Plant,
    data: mujoco.MjData,
    times: np.ndarray,
    pushes: Sequence[Push],
    surface: np.ndarray | None = None,
) -> list[Callable[[int], None]]:
    """Functions of the tick that act on the plant before the tick's physics.

    Args:
        plant: what is flown; with a surface that changes, its model belongs to this flight alone.
        data: its state.
        times: of every tick that the flight may have, s.
        pushes: on the robot.
        surface: what the surface is at every tick (`surface_table`); None where it does not change.
    """
    found: list[Callable[[int], None]] = []
    if surface is not None:
        found.append(surface_act(SurfaceWriter(plant), surface))
    if plant.wall_joint is not None:
        position, velocity = plant.surface.motion(times)
        at, dof = plant.wall_joint

        def move_wall(k: int) -> None:
            data.qpos[at], data.qvel[dof] = position[k], velocity[k]

        found.append(move_wall)
    if plant.surface.friction_varies:
        found.append(friction_writer(plant, data, times, plant.model))
    push = pusher(pushes, plant.model, data)
    if push is not None:
        found.append(push)
    return found


def friction_writer(
    plant: Plant, data: mujoco.MjData, times: np.ndarray, model: mujoco.MjModel
) -> Callable[[int], None]:
    """Writes into `model` the friction of the place and the slip speed that the tip has at a tick."""
    friction = PairFriction(model, plant.surface)
    site = model.site(TIP_SITE).id
    position, velocity = data.site_xpos[site], np.zeros(6)
    displacement, wall_speed = plant.surface.motion(times)

    def write(k: int) -> None:
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
        friction.update(position, velocity[3:], float(displacement[k]), float(wall_speed[k]))

    return write
