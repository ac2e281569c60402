"""How far a task with a tool came: a valve to its stop, a peg to the floor of its hole, a foot flat.

The truth of such a task is a signal of its own in the log. What was commanded is in the surface's parameters.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.score import TASK, Tolerance, metric
from skylimb.analysis.scores.signals import in_contact, in_phase, recorded

if TYPE_CHECKING:
    import xarray as xr

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


@metric(
    unit="rad",
    smaller_is_better=True,
    group=TASK,
    row="turn that the valve lacks of its stop in the end",
    ranked=False,
    tolerance=Tolerance("valve", "the valve is {value} from its stop in the end, {bound} allowed"),
)
def valve_left(run: Run) -> float:
    """Turn that the valve lacks of its stop in the end."""
    turned = float(recorded(run.log, VALVE.signal)[-1])
    return VALVE.commanded(run.log) - turned


@metric(
    unit="m",
    smaller_is_better=True,
    group=TASK,
    row=f"peg's end from the floor, greatest over the last {AT_THE_END:g} s",
    ranked=False,
    tolerance=Tolerance("peg", "the peg is {value} from the floor, {bound} allowed"),
    meaning=f"Greatest distance of the peg's end from the floor over the last {AT_THE_END:g} s of sliding",
)
def peg_left(run: Run) -> float:
    """Greatest distance of the peg's end from the floor of its hole in the end."""
    depths = recorded(run.log, PEG.signal)[_in_the_end(run.log)]
    return PEG.commanded(run.log) - float(depths.min())


@metric(
    unit="rad",
    smaller_is_better=True,
    group=TASK,
    row=f"foot from lying flat, mean over the last {AT_THE_END:g} s",
    ranked=False,
    tolerance=Tolerance(
        "foot",
        "the foot is {value} from lying flat, {bound} allowed",
        required=lambda run: FOOT.signal in run.log,
    ),
    meaning=f"Mean angle between foot and surface over the last {AT_THE_END:g} s of sliding",
)
def foot_angle_mean(run: Run) -> float:
    """Mean angle between foot and surface in the end while it touches; no number where it never does."""
    last = _in_the_end(run.log)
    angles = recorded(run.log, FOOT.signal)[last[in_contact(run.log)[last]]]
    return float(np.mean(angles)) if len(angles) else np.nan


def _in_the_end(log: xr.Dataset) -> np.ndarray:
    """The samples of the last `AT_THE_END` of the sliding period, (k,)."""
    time, sliding = log.time.values, np.flatnonzero(in_phase(log, "slide"))
    return sliding[time[sliding] > time[sliding[-1]] - AT_THE_END]
