"""What a configuration says of a path in the sliding plane."""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration, refused
from skylimb.base.sources import Source, read_source
from skylimb.base.user_modules import load_module, sources_of_module
from skylimb.control.planning.drawing import LARGEST
from skylimb.control.planning.user_path import USER

TURN = 2.0 * math.pi


@configuration
class TrajectoryConfig:
    """Which path, how large and how fast; a key that begins with names of shapes counts for those only."""

    shape: Annotated[
        Literal["hold", "line", "circle", "lemniscate", "lawnmower", "waypoints", "drawing", "own"],
        Key(
            "",
            "path: hold rests in the middle, lemniscate is a figure eight, lawnmower draws parallel strokes, "
            "drawing an SVG file or words, own a Python function (file.py:function for short)",
        ),
    ] = "circle"
    radius: Annotated[float, Key("m", "circle, lemniscate: half the width", low=0.01, high=5.0)] = 0.30
    period: Annotated[float, Key("s", "circle, lemniscate: time of one lap", low=1.0, high=3600.0)] = 14.0
    direction: Annotated[
        Literal[1, -1], Key("", "1 turns from u toward v, or flies in the order given; -1 the other way")
    ] = 1
    start_angle: Annotated[
        float,
        Key(
            "rad",
            "circle, lemniscate: phase at the start; -pi/2 is the bottom of the circle and the left end of "
            "the lemniscate",
            low=-TURN,
            high=TURN,
        ),
    ] = -math.pi / 2
    laps: Annotated[float, Key("", "circle, lemniscate: how many", low=0.01, high=1000.0)] = 1.0
    ramp: Annotated[
        float,
        Key(
            "s",
            "circle, lemniscate: time to get up to speed, and as long to stop; 0 starts at full speed",
            low=0.0,
            high=3600.0,
        ),
    ] = 0.0
    length: Annotated[float, Key("m", "line, lawnmower: length of a stroke", low=0.01, high=10.0)] = 0.60
    spacing: Annotated[float, Key("m", "lawnmower: distance between strokes", low=0.005, high=5.0)] = 0.10
    strokes: Annotated[int, Key("", "lawnmower: how many strokes", low=1, high=1000)] = 4
    angle: Annotated[
        float, Key("rad", "line, lawnmower: direction of the strokes, from u toward v", low=-TURN, high=TURN)
    ] = 0.0
    waypoints: Annotated[
        tuple[tuple[float, float], ...],
        Key(
            "m",
            "waypoints: (u, v) of each; corners are rounded, the first and the last are met exactly",
            low=-10.0,
            high=10.0,
        ),
    ] = ()
    file: Annotated[str, Key("", "drawing: an SVG file; own: a Python file", file=True)] = ""
    function: Annotated[
        str, Key("", "own: the function in that file; it takes times in s and returns u and v in m")
    ] = ""
    text: Annotated[str, Key("", "drawing: words, in place of a file")] = ""
    font: Annotated[
        str,
        Key("", "drawing: Hershey font of the words; futural, rowmans and scripts have single strokes"),
    ] = "futural"
    width: Annotated[
        float,
        Key(
            "m",
            "drawing: width of the box that it fills, its proportions kept; 0 for no limit",
            low=0.0,
            high=LARGEST,
        ),
    ] = 0.60
    height: Annotated[
        float, Key("m", "drawing: height of that box; 0 for no limit", low=0.0, high=LARGEST)
    ] = 0.0
    center: Annotated[
        tuple[float, float] | None,
        Key("m", "drawing: where the middle of that box is, (u, v); by default (0, 0)", low=-10.0, high=10.0),
    ] = None
    order: Annotated[
        Literal["given", "nearest"],
        Key("", "drawing: order of its strokes; nearest makes the ways between them short"),
    ] = "given"
    lift_time: Annotated[
        float,
        Key(
            "s",
            "drawing: time to lift the pen from the surface, and as long to put it back",
            low=0.1,
            high=60.0,
        ),
    ] = 2.0
    speed: Annotated[
        float,
        Key(
            "m/s",
            "line, lawnmower, waypoints, drawing: along the straight parts; own: the largest allowed",
            low=0.001,
            high=5.0,
        ),
    ] = 0.10
    acceleration: Annotated[
        float,
        Key(
            "m/s^2",
            "line, lawnmower, waypoints, drawing, own: largest, at ends and corners; more of it makes the "
            "corners of waypoints sharper, and a drawing faster",
            low=0.001,
            high=20.0,
        ),
    ] = 0.30
    duration: Annotated[float, Key("s", "hold, own: how long", low=0.0, high=36000.0)] = 10.0
    force: Annotated[
        tuple[float, float] | None,
        Key(
            "N",
            "wanted normal force along the path: of the thinnest and the widest strokes of a drawing (by the "
            "stroke widths of its file; words are thin upward and wide downward), at the beginning and the "
            "end of another path; by default what the controller's own gain says",
            low=0.1,
            high=20.0,
        ),
    ] = None
    brush: Annotated[
        float | None,
        Key(
            "m/N",
            "drawing: width of the line over the force, as of a soft pen; with it the drawn area is scored",
            above=0.0,
            high=0.1,
        ),
    ] = None
    feedforward: Annotated[
        Literal["none", "velocity", "full"],
        Key(
            "",
            "what the controller gets besides positions; full is velocity and acceleration, the paper's y "
            "errors appear only with none",
        ),
    ] = "none"

    @cached_property
    def sources(self) -> tuple[Source, ...]:
        """The file as it was read, where there is one; with what a Python file imports beside it."""
        if self.shape == USER and self.file:
            return sources_of_module(load_module(Path(self.file), (self.function,)))
        return (read_source(self.file),) if self.file else ()

    def check(self) -> None:
        """Refuse keys that do not go together."""
        if self.shape == "waypoints":
            if len(self.waypoints) < 2:
                raise ConfigError(
                    f"trajectory.waypoints has {len(self.waypoints)} points; it needs at least 2"
                )
            for index, (here, there) in enumerate(zip(self.waypoints, self.waypoints[1:], strict=False)):
                if math.dist(here, there) < 1e-6:
                    raise ConfigError(
                        f"trajectory.waypoints: point {index + 2} repeats the one before, {here}"
                    )
        if self.shape == "drawing" and bool(self.file) == bool(self.text):
            raise ConfigError(
                "trajectory.shape = 'drawing' needs either trajectory.file or trajectory.text, and not both"
            )
        if self.shape == USER and not (self.file and self.function and self.duration > 0.0):
            raise ConfigError(
                "trajectory.shape = 'own' needs trajectory.file, trajectory.function and trajectory.duration"
            )
        if self.brush and (self.shape != "drawing" or self.force is None):
            raise refused(self, "brush", "needs trajectory.shape = 'drawing' and trajectory.force")
        if self.shape == "drawing" and not self.width and not self.height:
            raise ConfigError("a drawing needs trajectory.width or trajectory.height, in m")
        laps_time = self.laps * self.period
        if self.ramp > laps_time:
            raise refused(self, "ramp", f"is longer than the laps take, {laps_time:g} s")
