"""The engine's activations of a flight: thrusts and servos' set points, which no record holds."""

from typing import Any

import numpy as np

from skylimb.control.loop.loop import Loop
from skylimb.flight.drivers.world import world
from skylimb.flight.flying import simulated_driver
from skylimb.flight.takeoff import take_off


def watched(seconds: float, set: dict[str, Any]) -> tuple[Loop, np.ndarray]:
    """A hybrid flight of the paper's experiment over some seconds, and its activations before each tick."""
    (takeoff,) = take_off("paper", ("hybrid",), set=set)
    here, found = world(takeoff), list[np.ndarray]()
    loop = Loop(
        simulated_driver(takeoff, here), takeoff.mission, takeoff.experiment.terminations, takeoff.count
    )
    while loop.time < seconds:
        found.append(here.data.act.copy())
        loop.tick()
    return loop, np.array(found)
