"""Whether a robot hovers in a flight: numbers at rest say nothing of servos and rotors that are too slow."""

from __future__ import annotations

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.base.errors import DescriptionError, SkylimbError
from skylimb.control.controller import load_controller
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.flying import fly
from skylimb.flight.simulated_run import simulated_run
from skylimb.flight.takeoff import prepare
from skylimb.robots.model import Robot

HOVER = {"posture.waypoints": [], "stop_at": 5.0}
"""Of `free_flight`: what falls does so within one or two seconds."""

FIRST = ("hybrid", "following")
"""Controllers for first flights: the one that flies by default, and the one for a touch, the most robust."""

_NEAR = 0.25
"""How far from its place a hover may end, m."""


def require_hover(robot: Robot) -> None:
    """Refuse a robot that does not last in a hover in free flight under `following`.

    Raises:
        SkylimbError: saying what became of it, or why it is not flown.
    """
    lost = hover_lost(robot, "following")
    if lost:
        raise DescriptionError(f"is held at rest, but does not last in a flight: {lost}")


def hover_lost(robot: Robot, controller: str) -> str:
    """What is wrong with a hover of 5 s in free flight under a controller that ships; empty where nothing."""
    takeoff = prepare(load_experiment("free_flight", HOVER), robot, load_controller(controller, robot))
    return not_hovered(simulated_run(takeoff, fly(takeoff)))


def who_hovers(robot: Robot) -> tuple[str, dict[str, str]]:
    """The first controller that hovers, of those that are proposed for first flights, and why others do not.

    All are flown: who touches first is not who hovers first. The name is empty where none hovers.
    """
    lost: dict[str, str] = {}
    for controller in FIRST:
        try:
            why = hover_lost(robot, controller)
        except SkylimbError as error:
            why = str(error)
        if why:
            lost[controller] = why
    return next((controller for controller in FIRST if controller not in lost), ""), lost


def not_hovered(run: Run) -> str:
    """What is wrong with a flight that was to hover: lost, or off its place in its last second; else ''."""
    if run.failed:
        return run.cause
    log, last = run.log, run.log.time.values > run.log.time.values[-1] - 1.0
    off = float(np.abs((log.cog_position - log.cog_position_reference).values[last]).max())
    return f"its centre of gravity is {off:.2f} m off in the end" if off > _NEAR else ""
