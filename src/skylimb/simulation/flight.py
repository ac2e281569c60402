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


def find_loss(
    signals: np.ndarray, layout: Layout[dict[str, object]], mission: Mission, first: int, last: int
) -> tuple[int, str] | None:
    """The first tick of first..last-1 at which the flight is lost, and why; None while it is not.

    Lost is: a number that is not finite, a tilt above 1 rad, a root more than 2 m from the reference, a root
    on the floor.
    """
    rows = signals[first:last]
    qpos = rows[:, layout.slices["configuration"]]
    finite = np.isfinite(rows[:, watched_columns(layout)]).all(axis=1)
    with np.errstate(invalid="ignore"):
        tilt = np.arccos(np.clip(1.0 - 2.0 * (qpos[:, 4] ** 2 + qpos[:, 5] ** 2), -1.0, 1.0))
        distance = np.linalg.norm(qpos[:, 0:3] - mission.reference.position[first:last], axis=1)
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
    return tick, f"{cause} at t = {mission.times[tick]:.3f} s"


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
    when = f"before t = {mission.times[end - 1]:.3f} s"
    return end - 1, f"diverged: the physics engine warned ({raised}) {when}"
