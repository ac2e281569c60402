"""What really flies in a studio: read from the numbers that its drivers are given, not from what it tells."""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.apps.studio.session import Session
from skylimb.base.packing import Layout
from skylimb.simulation.surface_state import COLUMNS

SETTLED = 0.25
"""Seconds after which every change that has begun is over."""


def flown_gain(session: Session, key: str, flight: int = 0) -> list[float]:
    """What a gain of a flight comes to now, from the rows that are written before its ticks."""
    live = session.live.flights[flight]
    controller = live.takeoff.controller
    layout = Layout(controller.gains())
    where = np.r_[layout.slices[key]]
    driver: Any = live._driver
    packed = driver.gains.copy()
    rows = live.takeoff.timeline(live.takeoff.times).gains
    if rows is not None:
        packed[rows.columns] = rows.values[_settled_tick(live)]
    return packed[where].tolist()


def flown_surface(session: Session) -> dict[str, Any]:
    """What the surface comes to now, from the table that the physics is given."""
    live = session.live.shown
    row = live.surface[_settled_tick(live)]
    found = {name: row[columns].tolist() for name, columns in COLUMNS.items()}
    return {name: numbers if name == "position" else numbers[0] for name, numbers in found.items()}


def flown_push(session: Session) -> list[float] | None:
    """The force of what pushes by hand now, W, N."""
    live = session.live.shown
    wrenches = live.takeoff.timeline(live.takeoff.times).wrenches
    now = [one for one in wrenches if one.begin <= live.ticks < one.end]
    return list(map(float, now[-1].force)) if now else None


def _settled_tick(live: Any) -> int:
    return min(live.ticks + round(SETTLED / live.takeoff.period), len(live.takeoff.times) - 1)
