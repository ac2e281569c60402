"""Any controller over a recorded flight: measurements and references in, estimates and commands out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.base.errors import ConfigError
from skylimb.base.packing import Layout, pack_rows
from skylimb.base.user_code import described_user_error
from skylimb.control.controller import Controller, TraceableController, is_traceable
from skylimb.control.estimation.records import Measurement
from skylimb.control.loop.loop import Progress
from skylimb.control.missions.clock import entries, reference_between
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference
from skylimb.control.missions.table import window_of
from skylimb.control.needs import needs_of
from skylimb.control.records import Command
from skylimb.control.traced_step import traced_step
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
    references = packed_references(controller, recorded, mission, dt, ahead)
    if is_traceable(controller):
        return _traced(controller, recorded, references, dt, gains, progress)
    return _in_python(controller, recorded, references, Layout(mission.first), dt, progress)


def packed_references(
    controller: Controller, recorded: Recorded, mission: Mission, dt: float, ahead: np.ndarray | None = None
) -> np.ndarray:
    """The reference of every tick with those ahead that the controller wants, (ticks, width).

    Args:
        controller: says how far ahead it looks.
        recorded: where the mission's clock was.
        mission: the references of the flight.
        dt: control period, s.
        ahead: the references ahead that were flown, packed; None to read them from the mission.
    """
    count, last, layout = len(recorded), len(mission.times) - 1, Layout(mission.first)
    here = np.minimum(recorded.clock.ticks.astype(int), last)

    def row(later: int) -> Reference:
        index = np.minimum(here + later, last)
        return Reference(*(entry[index] for entry in entries(mission.reference)))

    def packed(later: int) -> np.ndarray:
        paced = recorded.paced
        shown = reference_between(row(later), row(later + 1), recorded.clock) if paced else row(later)
        return pack_rows(layout, shown, count)

    preview = window_of(needs_of(controller).preview, False, dt).preview
    later = [packed(ticks) for ticks in preview] if ahead is None else [ahead.reshape(count, -1)]
    return np.hstack([packed(0), *later])


def _over_ticks(recorded: Recorded, tick: Callable[[int], Any], progress: Progress | None) -> list[Any]:
    """What every tick gives; one that was held in flight gives the same as the one before."""
    rows: list[Any] = []
    count = len(recorded)
    for k in range(count):
        rows.append(rows[-1] if k and recorded.held[k] else tick(k))
        if progress is not None and ((k + 1) % _REPORTED == 0 or k + 1 == count):
            progress(k + 1, count)
    return rows


def _traced(
    controller: TraceableController,
    recorded: Recorded,
    references: np.ndarray,
    dt: float,
    changing: tuple[np.ndarray, np.ndarray] | None,
    progress: Progress | None,
) -> dict[str, np.ndarray]:
    step = traced_step(WithFlownThrusts(controller), dt, len(controller.needs.preview), "open_loop")
    measured = pack_rows(step.inputs.measurement, recorded.measurement, len(recorded))
    state, measurement, reference, gains = given = [np.zeros(layout.size) for layout in step.inputs]
    new_state, command, signals = (
        np.zeros_like(state),
        np.zeros(step.commands.size),
        np.zeros(step.signals.size),
    )
    bound = BoundFunction(step.function, given, (new_state, command, signals))
    state[:], gains[:] = step.state, step.gains

    def tick(k: int) -> np.ndarray:
        measurement[:], reference[:] = measured[k], references[k]
        if changing is not None:
            gains[changing[0]] = changing[1][k]
        gains[-controller.robot.n_rotors :] = recorded.command.thrusts[k]
        bound.evaluate()
        state[:] = new_state
        return np.concatenate([signals, command])

    table = np.array(_over_ticks(recorded, tick, progress))
    found = _columns(step.signals, table[:, : step.signals.size])
    return found | _named(_columns(step.commands, table[:, step.signals.size :]))


def _columns(layout: Layout[Any], table: np.ndarray) -> dict[str, np.ndarray]:
    return {
        name: table[:, part].reshape(len(table), *layout.shapes[name]) for name, part in layout.slices.items()
    }


def _in_python(
    controller: Controller,
    recorded: Recorded,
    references: np.ndarray,
    entry: Layout[Reference],
    dt: float,
    progress: Progress | None,
) -> dict[str, np.ndarray]:
    """The same for a controller that cannot be traced; what it believes of its thrusts is its own affair."""
    what, gains, state = f"controller '{controller.name}'", controller.gains(), controller.initial_state()
    names: list[str] = []

    def tick(k: int) -> Mapping[str, Any]:
        nonlocal state
        measurement = Measurement(*(part[k].copy() for part in recorded.measurement))
        first, *ahead = (entry.unpack(row) for row in references[k].reshape(-1, entry.size))
        reference = first._replace(ahead=tuple(ahead))
        try:
            state, command, signals = controller.step(gains, state, measurement, reference, dt)
        except Exception as error:
            raise described_user_error(f"{what} at t = {k * dt:.3f} s", error) from error
        row = {**signals, **_named(Command(*command)._asdict())}
        names[:] = names or row
        if odd := sorted(row.keys() ^ set(names)):
            raise ConfigError(f"{what} records other signals than at its first tick: {', '.join(odd)}")
        return row

    rows = _over_ticks(recorded, tick, progress)
    return {name: np.array([np.asarray(row[name], dtype=float).squeeze() for row in rows]) for name in names}


def _named(command: Mapping[str, Any]) -> dict[str, Any]:
    """A command's parts under their names in a log."""
    return {f"{name}_command": part for name, part in command.items()}
