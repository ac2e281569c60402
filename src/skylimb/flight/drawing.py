"""The call that draws: the path of an experiment replaced by a drawing or by words, and flown."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.base.errors import ConfigError
from skylimb.control.controller import Controller
from skylimb.control.missions.configuration import ApproachConfig
from skylimb.flight.experiments.experiment import (
    Experiment,
    experiment_from_mapping,
    experiment_tables,
    put,
    require_contact,
)
from skylimb.flight.flyable import points_of
from skylimb.flight.loading import load_flight
from skylimb.flight.plan import FlightPlan
from skylimb.flight.public import Keep, Progress, run
from skylimb.flight.takeoff import Takeoff, start_points
from skylimb.simulation.surfaces import way_clear

_log = logging.getLogger(__name__)

_ACCELERATION = 0.05
"""Of the pen, m/s^2: where a stroke begins faster, friction holds the pen back, then lets it go at once."""

_STANDOFF = "approach.standoff"
_FARTHEST = 2.0
"""Largest standoff that an experiment may have, m."""

_OPTIONS: dict[str, Any] = {"font": "futural", "width": 0.60, "height": 0.0, "order": "given", "speed": 0.05}
"""What a drawing is where nobody says otherwise."""


def draw(
    file: str | Path = "",
    text: str = "",
    surface: str = "paper",
    controller: str | Controller = "drawing",
    *,
    font: str | None = None,
    width: float | None = None,
    height: float | None = None,
    speed: float | None = None,
    order: Literal["given", "nearest"] | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    keep: Keep | None = None,
) -> Run:
    """Draw an SVG file, or words, on a surface.

    The flight starts farther off than the experiment says where the surface stands out too far at the
    drawing's beginning, unless `set` has an approach.standoff.

    Args:
        file: an SVG file; or `text`.
        text: words to draw, on one line.
        surface: the experiment, or its TOML file, on whose surface to draw.
        controller: as of `skylimb.run`.
        font: of the words, a Hershey font; by default "futural".
        width: of the box that the drawing fills, its proportions kept, m; 0: no limit; by default 0.6.
        height: of that box, m; 0, the default: no limit.
        speed: of the pen on smooth lines, m/s; by default 0.05.
        order: of the strokes: the file's, the default, or for short ways between them.
        seed: of the sensors' noise; the experiment's own when None.
        set: dotted keys of the experiment and of the controller with new values.
        progress: called with how far the flight is.
        keep: as of `skylimb.run`.

    Returns:
        The run; `pen_line_rms` and `line_frechet` are among its metrics.

    Raises:
        SkylimbError: when it cannot be drawn; nothing has flown then.
    """
    if bool(file) == bool(text):
        raise ConfigError("draw needs either a file or a text" + (", not both" if file else ""))
    tables = experiment_tables(surface)
    on = Path(surface).stem if surface.endswith(".toml") else surface
    tables["name"] = f"{Path(file).stem if file else text} on {on}"
    source = f"The file {Path(file).name}" if file else f"The words {text!r}"
    tables["description"] = f"{source} drawn by the pen"
    given = {"file": str(file) or None, "text": text or None, "font": font, "width": width}
    given |= {"height": height, "order": order, "speed": speed}
    given = {key: value for key, value in given.items() if value is not None}
    tables["trajectory"] = {
        "shape": "drawing",
        **_OPTIONS,
        **given,
        "acceleration": _ACCELERATION,
        "feedforward": "full",
    }
    tables.pop("controller", None)
    gains = {}
    for key, value in (set or {}).items():
        _require_undisputed(key, value, given)
        if key.startswith("controller."):
            gains[key] = value
        else:
            put(tables, key, value)
    experiment = experiment_from_mapping(tables, f"experiment {on}")
    require_contact(experiment, f"experiment {on}", "draw on")
    if _STANDOFF not in (set or {}):
        experiment = _started_clear(load_flight(experiment, controller, seed, gains))
    return run(experiment, controller, seed, gains, progress, keep=keep)


def _require_undisputed(key: str, value: Any, given: Mapping[str, Any]) -> None:
    """Refuse a key that says otherwise what the call says already, or that asks for another path."""
    name = key.removeprefix("trajectory.")
    if key == "trajectory.shape" and value != "drawing":
        raise ConfigError(f"{key} = {value!r} is no drawing: `skylimb run` flies other paths")
    if name != key and name in given and given[name] != value:
        raise ConfigError(f"{name} = {given[name]!r} and {key} = {value!r} both say it: leave out one")


def _started_clear(plan: FlightPlan) -> Experiment:
    """The experiment of a plan, its start farther off where the robot would stand in the surface.

    The robot must be clear of it as it is planned, and as its servos give way before take-off.
    """
    experiment, robot, mission = plan.experiment, plan.robot, plan.mission
    standing = start_points(Takeoff(experiment, robot, plan.controller))
    points = np.vstack([points_of(robot, mission.first), standing])
    radius = robot.description.tip.radius
    here = experiment.surface, points, radius, mission.frame.contact
    if way_clear(*here) == 0.0:
        return experiment
    # As far from the surface as a flight starts that begins amid it.
    way = way_clear(*here, ApproachConfig.standoff)
    before, standoff = experiment.approach, math.ceil(1e3 * (experiment.approach.standoff + way)) / 1e3
    if standoff > _FARTHEST:
        return experiment  # which is refused, with what is needed
    _log.warning(
        "%s",
        f"the surface stands out where the drawing begins: {_STANDOFF} = {standoff:g} m in place of "
        f"{before.standoff:g} m",
    )
    return replace(experiment, approach=replace(before, standoff=standoff))
