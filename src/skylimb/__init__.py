"""skylimb: simulate, control, measure and fly multi-link aerial robots in contact.

    import skylimb

    run = skylimb.run("paper", controller="hybrid", set={"surface.friction": 0.3})
    run.status, run.metrics, run.log["cog_position"]

The names below are loaded when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skylimb.control.controller import Controller, load_controller
    from skylimb.control.records import Command
    from skylimb.errors import SkylimbError
    from skylimb.estimation.records import Measurement
    from skylimb.experiments.experiment import Experiment, load_experiment
    from skylimb.experiments.listing import list_controllers, list_experiments
    from skylimb.flights.public import begin, compare, run
    from skylimb.missions.reference import Reference
    from skylimb.recording.run import Run
    from skylimb.robots.loader import list_robots, load_robot
    from skylimb.robots.model import Robot

__version__ = "0.1.0"

_HOME = {
    "Command": "skylimb.control.records",
    "Controller": "skylimb.control.controller",
    "Experiment": "skylimb.experiments.experiment",
    "Measurement": "skylimb.estimation.records",
    "Reference": "skylimb.missions.reference",
    "Robot": "skylimb.robots.model",
    "Run": "skylimb.recording.run",
    "SkylimbError": "skylimb.errors",
    "begin": "skylimb.flights.public",
    "compare": "skylimb.flights.public",
    "list_controllers": "skylimb.experiments.listing",
    "list_experiments": "skylimb.experiments.listing",
    "list_robots": "skylimb.robots.loader",
    "load_controller": "skylimb.control.controller",
    "load_experiment": "skylimb.experiments.experiment",
    "load_robot": "skylimb.robots.loader",
    "run": "skylimb.flights.public",
}

__all__ = [
    "Command",
    "Controller",
    "Experiment",
    "Measurement",
    "Reference",
    "Robot",
    "Run",
    "SkylimbError",
    "begin",
    "compare",
    "list_controllers",
    "list_experiments",
    "list_robots",
    "load_controller",
    "load_experiment",
    "load_robot",
    "run",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'skylimb' has no attribute '{name}'")
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
