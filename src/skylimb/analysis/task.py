"""How far a task with a tool came: a valve to its stop, a peg to the floor of its hole, a foot flat.

The truth of such a task is a signal of its own in the log. What was commanded is in the surface's parameters.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from skylimb.analysis.signals import in_contact, in_phase

AT_THE_END = 5.0
"""Seconds at the end of the sliding period over which a peg has to stay in and a foot to lie flat."""


class Tool(NamedTuple):
    """What is moved in a task with a tool.

    Attributes:
        signal: its truth in the log.
        parameter: of the surface that says how far it has to get; empty for 0.
        title: a few words.
        unit: of the signal.
    """

    signal: str
    parameter: str
    title: str
    unit: str

    def commanded(self, log: xr.Dataset) -> float:
        """How far it has to get, in the signal's unit."""
        if not self.parameter:
            return 0.0
        return float(json.loads(log.attrs["surface"])["parameters"][self.parameter])


VALVE = Tool("valve_angle", "travel", "Turn of the valve", "rad")
PEG = Tool("peg_depth", "depth", "Depth of the peg's end", "m")
FOOT = Tool("foot_angle", "", "Angle of foot and surface", "rad")
TOOLS = (VALVE, PEG, FOOT)
"""Every tool that a task can have."""


def tools_of(log: xr.Dataset) -> Iterator[Tool]:
    """The tools of a flight."""
    return (tool for tool in TOOLS if tool.signal in log)


def task_scores(log: xr.Dataset) -> dict[str, float]:
    """Scores of the tasks that a flight had; a plain contact flight has none of them.

    Args:
        log: of a run that came to its end.

    Returns:
        `valve_left`: turn that the valve lacks of its second stop at the flight's end, rad. `peg_left`:
        greatest distance of the peg's end from the floor over the last `AT_THE_END` of the sliding period,
        m. `foot_angle_mean`: mean angle between foot and surface while it touches in that time, rad; NaN
        where it does not touch.
    """
    scores: dict[str, float] = {}
    if VALVE.signal in log:
        scores["valve_left"] = VALVE.commanded(log) - float(log.valve_angle[-1])
    sliding = np.flatnonzero(in_phase(log, "slide"))
    if not len(sliding):
        return scores
    time = log.time.values
    last = sliding[time[sliding] > time[sliding[-1]] - AT_THE_END]
    if PEG.signal in log:
        scores["peg_left"] = PEG.commanded(log) - float(log.peg_depth.values[last].min())
    if FOOT.signal in log:
        touching = last[in_contact(log)[last]]
        angles = log.foot_angle.values[touching]
        scores["foot_angle_mean"] = float(np.mean(angles)) if len(angles) else float("nan")
    return scores


class Part(NamedTuple):
    """A part of a task that has a tolerance.

    Attributes:
        tolerance: its name.
        score: what is held to it.
        kept: whether it is.
        words: what was missed, by how much.
    """

    tolerance: str
    score: float
    kept: bool
    words: str


def task_parts(tolerances: Mapping[str, float], scores: Mapping[str, Any]) -> Iterator[Part]:
    """The parts of a task that a flight had, held to their tolerances; a log of before may have none."""
    left = scores.get("valve_left")
    if left is not None and "valve" in tolerances:
        most = tolerances["valve"]
        words = f"the valve is {_degrees(left)} from its stop in the end, {_degrees(most)} allowed"
        yield Part("valve", left, left <= most, words)
    left = scores.get("peg_left")
    if left is not None and "peg" in tolerances:
        most = tolerances["peg"]
        words = f"the peg is {1e3 * left:.1f} mm from the floor, {1e3 * most:g} mm allowed"
        yield Part("peg", left, left <= most, words)
    angle = scores.get("foot_angle_mean")
    if angle is not None and "foot" in tolerances:
        most = tolerances["foot"]
        words = f"the foot is {_degrees(angle)} from lying flat, {_degrees(most)} allowed"
        yield Part("foot", angle, angle <= most, words)


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.1f}\N{DEGREE SIGN}"
