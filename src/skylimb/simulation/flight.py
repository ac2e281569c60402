"""What a driver hands back, and when a flight counts as lost."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from skylimb.packing import Layout
from skylimb.simulation.mission import Mission

CHECK_INTERVAL = 100
"""Ticks between two looks at the flight's health: a lost flight ends within that many ticks of the loss."""

MAX_TILT = 1.0
"""Tilt of a flight that is lost, rad."""

MAX_DISTANCE = 2.0
"""Distance of the root from its reference in a flight that is lost, m."""

MISSION_TIME = "mission_time"
"""Signal of a controller that sets the mission's pace: where the flight is on the mission's clock, s."""

MIN_HEIGHT = 0.05
"""Height of a root on the floor, m."""


@dataclass(frozen=True)
class Flight:
    """The raw record of a flight.

    Attributes:
        signals: one packed row of signals a tick, up to the end or the loss.
        layout: where each signal stands in a row.
        ticks: how many ticks were flown.
        cause: why the flight was lost, or empty.
    """

    signals: np.ndarray
    layout: Layout[dict[str, object]]
    ticks: int
    cause: str

    def signal(self, name: str) -> np.ndarray:
        """The values of one signal over the ticks, (ticks,) or (ticks, width)."""
        values = self.signals[: self.ticks, self.layout.slices[name]]
        return values[:, 0] if self.layout.shapes[name] == () else values


def flown_mission(mission: Mission, flight: Flight) -> Mission:
    """The mission as a flight went through it: its own, but for a controller that set the pace.

    Every entry of it has a row for each of the flight's ticks.
    """
    if MISSION_TIME not in flight.layout.slices:
        return mission
    return mission.along(mission_clock(mission, flight))


def mission_clock(mission: Mission, flight: Flight) -> np.ndarray:
    """Where on the mission's clock each of a flight's ticks was, in ticks, (ticks,)."""
    if MISSION_TIME not in flight.layout.slices:
        return np.arange(float(flight.ticks))
    period = mission.times[1] - mission.times[0]
    return np.nan_to_num(flight.signal(MISSION_TIME)) / period


def unfinished(mission: Mission, flight: Flight) -> Flight:
    """A flight whose every tick is over: lost, if its controller held the mission back all the while."""
    if MISSION_TIME not in flight.layout.slices:
        return flight
    reached = flight.signal(MISSION_TIME)[-1]
    if reached >= mission.times[-1] - 1e-9:
        return flight
    cause = (
        f"not finished: the controller held the mission back, which was at {reached:.3f} s of "
        f"{mission.times[-1]:.3f} s when {mission.patience:g} times its time were over"
    )
    return Flight(flight.signals, flight.layout, flight.ticks, cause)


def find_loss(flight: Flight, mission: Mission, first: int = 0) -> tuple[int, str] | None:
    """The first tick from `first` on at which a flight is lost, and why; None while it is not.

    Lost is: a number that is not finite, a tilt above 1 rad, a root more than 2 m from the reference, a root
    on the floor.

    Args:
        flight: as far as it has come.
        mission: what was to be flown.
        first: where to begin.
    """
    layout, last = flight.layout, flight.ticks
    asked = mission.reference.position[mission_clock(mission, flight)[first:].astype(int)]
    rows = flight.signals[first:last]
    qpos = rows[:, layout.slices["configuration"]]
    finite = np.isfinite(rows[:, watched_columns(layout)]).all(axis=1)
    with np.errstate(invalid="ignore"):
        tilt = np.arccos(np.clip(1.0 - 2.0 * (qpos[:, 4] ** 2 + qpos[:, 5] ** 2), -1.0, 1.0))
        distance = np.linalg.norm(qpos[:, 0:3] - asked, axis=1)
        checks = (
            (~finite, "diverged: a signal is no longer a finite number"),
            (tilt > MAX_TILT, f"lost attitude: tilt above {MAX_TILT:g} rad"),
            (distance > MAX_DISTANCE, f"lost position: more than {MAX_DISTANCE:g} m from the reference"),
            (qpos[:, 2] < MIN_HEIGHT, f"hit the floor: below {MIN_HEIGHT:g} m"),
        )
    found = [(int(np.argmax(bad)), cause) for bad, cause in checks if bad.any()]
    if not found:
        return None
    index, cause = min(found, key=lambda item: item[0])
    tick = first + index
    return tick, f"{cause} at t = {tick * (mission.times[1] - mission.times[0]):.3f} s"


@functools.lru_cache(maxsize=16)
def watched_columns(layout: Layout[dict[str, object]]) -> np.ndarray:
    """Columns that every driver fills; a user's controller may leave its inner signals open."""
    names = (
        "configuration",
        "configuration_velocity",
        "thrusts_command",
        "joint_angles_command",
        "contact_force",
    )
    return np.concatenate([np.arange(layout.size)[layout.slices[name]] for name in names])


def engine_loss(mission: Mission, end: int, warnings: Sequence[int]) -> tuple[int, str] | None:
    """The loss that the engine's own warnings make of a flight, found after `end` ticks; None without any.

    A warning means a state that cannot be trusted. `warnings` counts each kind.
    """
    raised = ", ".join(mujoco.mjtWarning(i).name for i, number in enumerate(warnings) if number > 0)
    if not raised:
        return None
    when = f"before t = {(end - 1) * (mission.times[1] - mission.times[0]):.3f} s"
    return end - 1, f"diverged: the physics engine warned ({raised}) {when}"
