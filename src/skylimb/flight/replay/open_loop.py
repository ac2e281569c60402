"""Any controller over a recorded flight: measurements and references in, estimates and commands out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.packing import Layout, number
from skylimb.base.user_code import described_user_error
from skylimb.control.controller import Controller, is_traceable
from skylimb.control.loop.loop import Progress
from skylimb.control.missions.clock import Clock
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.table import window_of
from skylimb.control.needs import needs_of
from skylimb.control.records import Command
from skylimb.flight.realtime.compiled_controller import CompiledController
from skylimb.flight.replay.as_flown import WithFlownThrusts
from skylimb.flight.replay.recorded import Recorded

_REPORTED = 200
"""Ticks between two calls of a `Progress`."""


def open_loop(
    controller: Controller,
    recorded: Recorded,
    mission: Mission,
    dt: float,
    gains: tuple[np.ndarray, np.ndarray] | None = None,
    progress: Progress | None = None,
    ahead: np.ndarray | None = None,
) -> dict[str, np.ndarray]:
    """Every signal that a controller records and its command, at every tick of a recorded flight.

    At a tick whose command was held in flight the controller is not asked, as it was not then.

    Args:
        controller: what is to work on it.
        recorded: what was measured, what was commanded, and where the mission's clock was.
        mission: the references of the flight.
        dt: control period, s.
        gains: those that change in flight: where they stand in the flat gains, and one row a tick.
        progress: called with how far it is.
        ahead: the references ahead that were flown, packed, (ticks, preview, width), of a mission with one
            row a tick; None to read them from the mission.

    Returns:
        By name, the ticks first; commands under the names of a log.
    """
    entry, clock = Layout(mission.first), recorded.clock
    preview = window_of(needs_of(controller).preview, False, dt).preview if ahead is None else ()
    traced = controller if is_traceable(controller) else None
    flying: Any = controller if traced is None else CompiledController(WithFlownThrusts(traced), dt)
    what, given, state = f"controller '{controller.name}'", flying.gains(), flying.initial_state()
    names: list[str] = []

    def tick(k: int) -> Mapping[str, Any]:
        nonlocal state
        if traced is not None:  # what another one believes of its thrusts is its own affair
            given[-traced.robot.n_rotors :] = recorded.command.thrusts[k]
        if traced is not None and gains is not None:
            given[gains[0]] = gains[1][k]
        measurement = recorded.measured_at(k)
        reference = mission.at(Clock(clock.ticks[k], clock.pace[k]), preview)
        if ahead is not None:
            reference = reference._replace(ahead=tuple(map(entry.unpack, ahead[k])))
        try:
            state, command, signals = flying.step(given, state, measurement, reference, dt)
        except Exception as error:
            raise described_user_error(f"{what} at t = {k * dt:.3f} s", error) from error
        commanded = {f"{name}_command": part for name, part in Command(*command)._asdict().items()}
        row = {**signals, **commanded}
        names[:] = names or row
        if odd := sorted(row.keys() ^ set(names)):
            raise ConfigError(f"{what} records other signals than at its first tick: {', '.join(odd)}")
        return {name: number(value) for name, value in row.items()}

    rows = _over_ticks(recorded, tick, progress)
    return {name: np.array([row[name] for row in rows]) for name in names}


def _over_ticks(recorded: Recorded, tick: Callable[[int], Any], progress: Progress | None) -> list[Any]:
    """What every tick gives; one that was held in flight gives the same as the one before."""
    rows: list[Any] = []
    count = len(recorded)
    for k in range(count):
        rows.append(rows[-1] if k and recorded.held[k] else tick(k))
        if progress is not None and ((k + 1) % _REPORTED == 0 or k + 1 == count):
            progress(k + 1, count)
    return rows
