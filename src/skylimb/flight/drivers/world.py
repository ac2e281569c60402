"""The plant of one flight with everything that acts on it: what every simulated flight begins from."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np

from skylimb.flight.drivers.hooks import Hook, hooks, written_plant
from skylimb.flight.events import Timeline
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.plant import Plant
from skylimb.simulation.plant_steps import PlantSteps
from skylimb.simulation.vehicle import Advance


class World(NamedTuple):
    """The plant of one flight, and all that acts on it.

    Attributes:
        plant: with a model of its own where something is written into it.
        data: its state; it is advanced.
        hooks: what acts on it before a tick's physics.
        events: what happens at every tick.
        advance: advances the physics.
    """

    plant: Plant
    data: mujoco.MjData
    hooks: tuple[Hook, ...]
    events: Timeline
    advance: Advance = mujoco.mj_step


def world(takeoff: Takeoff, times: np.ndarray | None = None) -> World:
    """The plant of a flight at its first tick, with its events bound to it.

    Args:
        takeoff: what is flown.
        times: of every tick that it may have, s; by default those of its mission.
    """
    times = takeoff.times if times is None else times
    events = takeoff.timeline(times)
    plant, data = written_plant(takeoff.plant, events), takeoff.data()
    advance = mujoco.mj_step if takeoff.own_plant is None else PlantSteps(plant, data, takeoff.own_plant)
    return World(plant, data, hooks(plant, data, times, events), events, advance)
