"""The raw record of a flight, and the mission as the flight went through it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.base.packing import Layout
from skylimb.control.missions.clock import Clock, limited_pace
from skylimb.control.missions.mission import Mission
from skylimb.control.needs import PACE

MISSION_TIME = "mission_time"
"""Signal of a controller that sets the mission's pace: where the flight is on the mission's clock, s."""

CONFIGURATION = "configuration"
"""Signal of a simulated vehicle: positions of the scene's joints; the root's pose comes first."""

_SAME_TICK = 1e-6
"""Ticks within which a clock read back from a signal in seconds stands on a whole tick."""


@dataclass(frozen=True)
class Flight:
    """The raw record of a flight.

    Attributes:
        signals: one packed row of signals a tick, up to the end or the loss.
        layout: where each signal stands in a row.
        ticks: how many ticks were flown.
        cause: why the flight was lost, or empty.
        notes: what its driver has to say of it, one line each.
    """

    signals: np.ndarray
    layout: Layout[dict[str, object]]
    ticks: int
    cause: str
    notes: tuple[str, ...] = ()

    def has(self, name: str) -> bool:
        """Whether a signal was recorded."""
        return name in self.layout.slices

    def signal(self, name: str) -> np.ndarray:
        """The values of one signal over the ticks, (ticks,) or (ticks, width)."""
        values = self.signals[: self.ticks, self.layout.slices[name]]
        return values[:, 0] if self.layout.shapes[name] == () else values


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, or the end that the system asks for, in the middle of a flight.

    Attributes:
        flight: what had been flown, with that as its cause.
    """

    def __init__(self, flight: Flight) -> None:
        super().__init__(flight.cause)
        self.flight = flight


def mission_clock(mission: Mission, flight: Flight) -> Clock:
    """Where on the mission's clock each of a flight's ticks was, and the pace there, each (k,)."""
    ticks = mission_ticks(mission, flight)
    if not flight.has(MISSION_TIME):
        return Clock(ticks, np.ones(flight.ticks))
    # A tick's signal sets the pace of the next one; the first one goes at the mission's own pace.
    pace = np.concatenate([np.ones(1), limited_pace(np.nan_to_num(flight.signal(PACE)[:-1]))])
    return Clock(ticks, pace[: len(ticks)])


def mission_ticks(mission: Mission, flight: Flight, first: int = 0) -> np.ndarray:
    """Where on the mission's clock each tick of a flight from `first` on was, in ticks, (k,)."""
    if not flight.has(MISSION_TIME):
        return np.arange(float(first), float(flight.ticks))
    ticks = np.nan_to_num(flight.signal(MISSION_TIME)[first:]) / mission.period
    whole = np.round(ticks)
    return np.where(abs(ticks - whole) < _SAME_TICK, whole, ticks)


def flown_mission(mission: Mission, flight: Flight) -> Mission:
    """The mission as a flight went through it; every entry has a row for each of the flight's ticks."""
    if not flight.has(MISSION_TIME):
        return mission
    return mission.along(mission_clock(mission, flight))


def mission_signals(mission: Mission, ticks: int) -> dict[str, np.ndarray]:
    """What a mission, as it was flown, asked for in its first ticks, by the names of the log.

    A mission that leaves the force to the controller has no `contact_force_commanded`.
    """
    reference = mission.reference
    force = reference.force[:ticks]
    pressed = {"contact_force_commanded": np.where(force > 0.0, force, np.nan)}
    return {
        "cog_position_reference": reference.position[:ticks],
        "cog_velocity_reference": reference.velocity[:ticks],
        "cog_acceleration_reference": reference.acceleration[:ticks],
        "reach_reference": reference.reach[:ticks],
        "tip_position_reference": reference.tip_position[:ticks],
        "phase": mission.phase[:ticks].astype(np.int8),
        **(pressed if reference.force.any() else {}),
    }


def unfinished(mission: Mission, flight: Flight) -> Flight:
    """A flight whose every tick is over: lost, if that is before its mission's end.

    Either it was stopped there (`stop_at`), or its controller held the mission back all the while.
    """
    paced = flight.has(MISSION_TIME)
    at = flight.signal(MISSION_TIME)[-1] if paced else (flight.ticks - 1) * mission.period
    if at >= mission.times[-1] - 1e-9:
        return flight
    if flight.ticks < len(mission.flight_times(paced)):
        cause = stopped_cause(flight.ticks, mission)
    else:
        cause = held_back_cause(at, mission)
    return Flight(flight.signals, flight.layout, flight.ticks, cause)


def stopped_cause(ticks: int, mission: Mission) -> str:
    """The cause of a flight that was stopped after `ticks` ticks, before its mission's end."""
    return f"stopped from outside at t = {ticks * mission.period:.3f} s, before the mission's end"


def held_back_cause(at: float, mission: Mission) -> str:
    """The cause of a flight whose mission came no further than `at`, s, in all the time that it has."""
    return (
        f"the controller held the mission back, which was at {at:.3f} s of "
        f"{mission.times[-1]:.3f} s when {mission.patience:g} times its time were over"
    )
