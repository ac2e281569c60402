"""What a fault did to a flight: how far it threw the robot, how long it went on, and when it was noticed.

A fault is whatever the flight's events are. What it did is counted from the sample before the first of them,
against the mission's reference (of a flight that is broken off, against the last one), until `WINDOW` after
the last has ended; of a flight without events, such as one with a heavier robot, all along. Where the same
flight was flown without its events, what that one moves by itself does not count. A flight that was lost
before the window's end and before `OUTLIVED` has none of these numbers, but how long it went on; one that its
supervisor landed was not lost.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.score import Score, metric
from skylimb.analysis.scores.signals import (
    contact_axis,
    events_of,
    in_contact,
    recorded,
    stretches,
    surface_of,
)

if TYPE_CHECKING:
    import xarray as xr

WINDOW = 1.5
"""Seconds in which a robot shows what a fault does to it."""

OUTLIVED = 5.0
"""Seconds from a fault's beginning after which a flight has outlived it."""

GENTLE, UPRIGHT = 0.6, 0.2
"""Speed (m/s) and tilt (rad) below which a supervised flight that comes to the floor has landed."""

BELIEVED = {"lateness_estimate": 0.0, "thrust_scale_estimate": 1.0}
"""Signals that say what is believed of latency and thrust, and what they are without a fault."""

LEAST = 0.02
"""What they come to by themselves, s or share: less is none."""

MODE, GONE = "supervisor_mode", "surface_gone"
"""Signals: of a supervised flight, 0 while nothing is wrong; of a law, 1 where its surface has gone."""

BROKEN_OFF = 2
"""Number of the first mode in which a flight has no mission any more."""

ROUNDING = 1e-5
"""N, of a thrust in single precision."""

COMMANDS = ("thrusts_command", "joint_angles_command", "vectoring_angles_command")
"""Signals of what is commanded."""


def _worse(meaning: str, unit: str) -> Score:
    return Score(meaning, unit, smaller_is_better=True, ranked=False)


@metric(
    on_demand="faults",
    lost=True,
    keys={
        "lasted": Score("Time that the flight went on after a fault began", "s", False, ranked=False),
        "landed": Score("Whether the supervisor brought it to the floor unharmed", kind="yes or no"),
        "tilt": _worse("Greatest turn of the measured link's axis after a fault", "rad"),
        "sink": _worse("Greatest loss of height after a fault", "m"),
        "sideways": _worse("Greatest horizontal way along the surface after a fault", "m"),
        "tip": _worse("Greatest way of the tip from its course after a fault", "m"),
        "force": _worse("Greatest normal force after a fault", "N"),
        "speed": _worse("Greatest speed of the centre of gravity after a fault", "m/s"),
        "rush": _worse("Greatest speed of the tip along the contact axis after a fault", "m/s"),
        "gone": _worse("Time from a fault until the law knows its surface gone; never: no number", "s"),
        "seen": _worse("Time from a fault until the supervisor acts; never: no number", "s"),
        "believed": _worse(
            "Time from a fault until half of the latency or change of thrust is believed that is in the end; "
            "never: no number",
            "s",
        ),
        "alarms": _worse("Times that the supervisor acted before a fault, or without one", ""),
        "unnamed": _worse("Whether it was lost (1) and no supervisor had broken it off", ""),
        "invalid": _worse("Ticks whose command is no number, or a thrust that no rotor gives", ""),
    },
)
def fault(run: Run) -> dict[str, float]:
    """How far a fault threw the robot, and when it was noticed."""
    log, happened = run.log, events_of(run.log)
    time, planned = log.time.values, log.attrs.get("events", "[]") != "[]"
    onset = happened[0].time if happened else 0.0
    end = max(each.time + each.duration for each in happened) + WINDOW if happened else np.inf
    # A flight that was lost before its fault tells nothing of it.
    lasted = float(time[-1] - onset) if happened or not planned else np.nan
    seen, alarms = _noticed(log, onset if happened else np.inf)
    landed = run.lost and _landed(log)
    lost = run.failed and not (time[-1] >= end or lasted >= OUTLIVED or landed)
    known = {
        "lasted": lasted,
        "landed": landed,
        "seen": seen,
        "believed": _believed(log, onset),
        "alarms": alarms,
        "unnamed": float(run.lost and not _broken_off(log)),
        "invalid": _invalid(log),
    }
    if lost or (run.twin is not None and run.twin.failed):
        return {key: known.get(key, np.nan) for key in fault.keys}
    # What is there from take-off on is counted from the first sample.
    first = max(0, int(np.searchsorted(time, onset - 1e-9)) - 1)
    twin = None if run.twin is None else run.twin.log
    after = slice(first, min(int(np.searchsorted(time, end)), len(time if twin is None else twin.time)))
    off, astray = _departure(log, "cog_position", after), _astray(log, after)
    if twin is not None:
        off, astray = off - _departure(twin, "cog_position", after), astray - _astray(twin, after)
    axis = contact_axis(log)
    aside = (off - np.outer(axis.along(off), axis.vector)) * (1.0, 1.0, 0.0)
    w, x, y, z = recorded(log, "root_quaternion")[after].T
    upright = np.stack([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], axis=1)
    return {
        **known,
        "tilt": float(np.arccos(np.clip(upright @ upright[0], -1.0, 1.0)).max()),
        "sink": float(-off[:, 2].min()),
        "sideways": float(np.linalg.norm(aside, axis=1).max()),
        "tip": float(np.linalg.norm(astray, axis=1).max()),
        "force": float(recorded(log, "contact_force_normal")[after].max()),
        "speed": float(np.linalg.norm(recorded(log, "cog_velocity")[after], axis=1).max()),
        "rush": float(np.gradient(axis.along(recorded(log, "tip_position")[after]), time[after]).max()),
        "gone": _first(log, GONE, onset),
    }


def _course(log: xr.Dataset, place: str, after: slice) -> np.ndarray:
    """The reference of a place, W, m: a flight that is broken off has no mission, and keeps its last one."""
    course = recorded(log, f"{place}_reference")[after]
    if MODE not in log:
        return course
    broken = np.flatnonzero(log[MODE].values[after] >= BROKEN_OFF)
    return course[np.minimum(np.arange(len(course)), broken[0])] if len(broken) else course


def _departure(log: xr.Dataset, place: str, after: slice) -> np.ndarray:
    """How far a place has come from its reference since the first of some samples, W, m."""
    off = recorded(log, place)[after] - _course(log, place, after)
    return off - off[0]


def _astray(log: xr.Dataset, after: slice) -> np.ndarray:
    """How far the tip has come from its course since the first of some samples, W, m.

    In contact it is to stay on the surface, whose lean the mission's reference does not know.
    """
    off, surface, axis = _departure(log, "tip_position", after), surface_of(log), contact_axis(log).vector
    if surface is None or not in_contact(log)[after][0]:
        return off
    course = _course(log, "tip_position", after)
    normal = np.array(surface["normal"])
    return off + np.outer((course - course[0]) @ normal / (normal @ axis), axis)


def _broken_off(log: xr.Dataset) -> bool:
    """Whether the supervisor had broken the flight off by its end."""
    return MODE in log and float(log[MODE][-1]) >= BROKEN_OFF


def _invalid(log: xr.Dataset) -> float:
    """Ticks with a command that is no number, or a thrust that no rotor gives; NaN of a foreign log."""
    if COMMANDS[0] not in log or "thrust_limits" not in log.attrs:
        return np.nan
    low, high = np.asarray(json.loads(log.attrs["thrust_limits"]), dtype=float)
    thrusts = log[COMMANDS[0]].values
    wrong = ((thrusts < low - ROUNDING) | (thrusts > high + ROUNDING)).any(axis=1)
    for name in COMMANDS:
        if name in log:
            wrong |= ~np.isfinite(log[name].values).all(axis=1)
    return float(wrong.sum())


def _landed(log: xr.Dataset) -> bool:
    """Whether a flight that ended early ended on its feet."""
    last = log.isel(time=-1)
    acting = MODE in log and float(last[MODE]) > 0.0
    return acting and float(np.linalg.norm(last.cog_velocity)) < GENTLE and float(last.tilt) < UPRIGHT


def _first(log: xr.Dataset, signal: str, onset: float) -> float:
    """Time from an onset until a signal is more likely than not, s."""
    if signal not in log:
        return np.nan
    sure = log.time.values[(log[signal].values > 0.5) & (log.time.values >= onset - 1e-9)]
    return float(sure[0] - onset) if len(sure) else np.nan


def _believed(log: xr.Dataset, onset: float) -> float:
    """Time from an onset until half of what is believed in the end is, of latency or thrust, s."""
    time, found = log.time.values, [np.inf]
    for signal, plain in BELIEVED.items():
        if signal in log:
            off = np.abs(log[signal].values - plain)
            half = time[(off >= 0.5 * off[-1]) & (time >= onset - 1e-9)]
            found += [float(half[0] - onset)] if off[-1] > LEAST and len(half) else []
    return min(found) if np.isfinite(min(found)) else np.nan


def _noticed(log: xr.Dataset, onset: float) -> tuple[float, float]:
    """Time from an onset until the supervisor acts, s, and how often it acted before."""
    if MODE not in log:
        return np.nan, np.nan
    begins = np.array([begin for begin, _ in stretches(log[MODE].values > 0)], dtype=int)
    times = log.time.values[begins]
    after = times[times >= onset - 1e-9]
    return float(after[0] - onset) if len(after) else np.nan, float(len(times) - len(after))
