"""Whether a robot that servos hold up hovers: numbers at rest do not say whether they turn fast enough."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.apps.robot_import.doubts import Doubt
from skylimb.base.errors import SkylimbError
from skylimb.control.controller import load_controller
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.flying import fly
from skylimb.flight.simulated_run import simulated_run
from skylimb.flight.takeoff import prepare
from skylimb.robots.model import Robot

HOVER = {"posture.waypoints": [], "stop_at": 5.0}
"""Of `free_flight`: what falls does so within one or two seconds."""

_NEAR = 0.25
"""How far from its place a hover may end, m."""


def hover_doubts(robot: Robot) -> Iterator[Doubt]:
    """What a flight says of a robot of two or three rotors that joints turn; of another one nothing."""
    if robot.pairs is robot:
        return
    try:
        takeoff = prepare(load_experiment("free_flight", HOVER), robot, load_controller("following", robot))
        lost = not_hovered(simulated_run(takeoff, fly(takeoff)))
    except SkylimbError as error:
        yield Doubt("hover", f"its flight is refused: {error}", "correct it in the files")
        return
    if lost:
        yield Doubt(
            "hover",
            f"is held at rest, but does not last in a flight: {lost}",
            "vectoring servos that turn faster, or rotors farther from the line through their centres",
            fatal=True,
        )


def not_hovered(run: Run) -> str:
    """What is wrong with a flight that was to hover: lost, or off its place in its last second; else ''."""
    if run.failed:
        return run.cause
    log, last = run.log, run.log.time.values > run.log.time.values[-1] - 1.0
    off = float(np.abs((log.cog_position - log.cog_position_reference).values[last]).max())
    return f"its centre of gravity is {off:.2f} m off in the end" if off > _NEAR else ""
