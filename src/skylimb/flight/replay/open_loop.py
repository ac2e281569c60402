"""Any controller over a recorded flight: measurements and references in, estimates and commands out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.base.errors import ConfigError
from skylimb.base.packing import Layout, pack_rows
from skylimb.base.user_code import described_user_error
from skylimb.control.controller import Controller, TraceableController, is_traceable
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.clock import Clock
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import zero_reference
from skylimb.control.missions.table import Window, reference_table, window_of
from skylimb.control.needs import needs_of
from skylimb.control.records import Command
from skylimb.flight.replay.as_flown import as_flown
from skylimb.flight.replay.recorded import Recorded

Progress = Callable[[int, int], None]
"""Called now and then with (ticks done, ticks in all)."""

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
    if is_traceable(controller):
        return _traced(controller, recorded, mission, dt, gains, progress, ahead)
    return _in_python(controller, recorded, mission, dt, progress, ahead)


def _traced(
    controller: TraceableController,
    recorded: Recorded,
    mission: Mission,
    dt: float,
    changing: tuple[np.ndarray, np.ndarray] | None,
    progress: Progress | None,
    ahead: np.ndarray | None,
) -> dict[str, np.ndarray]:
    controller.require(dt)
    robot, count = controller.robot, len(recorded)
    window = Window(window_of(controller.needs.preview, False, dt).preview, recorded.paced)
    references = Layout(zero_reference(robot.n_joints, robot.n_vectoring))
    table = reference_table(mission, references, window)
    measurements = Layout(_first(recorded.measurement))
    measured = pack_rows(measurements, recorded.measurement, count)
    initial, gains = controller.initial_state(), controller.gains()
    states, gains_layout = Layout(initial), Layout(gains)
    sizes = {
        "state": states.size,
        "measurement": measurements.size,
        "references": references.size * window.rows,
        "clock": 2,
        "gains": gains_layout.size,
        "flown": robot.n_rotors,
    }
    x, m, r, c, p, flown = symbols = [ca.SX.sym(name, size) for name, size in sizes.items()]
    new, command, inner = as_flown(controller, flown).step(
        gains_layout.unpack(p),
        states.unpack(x),
        measurements.unpack(m),
        window.read(references, r, Clock(c[0], c[1])),
        dt,
    )
    made = {**dict(inner), **_named(command)}
    signals = Layout(made)
    outputs = [ca.densify(states.pack(new)), ca.densify(signals.pack(made))]
    function = ca.Function("open_loop", symbols, outputs, [*sizes], ["next_state", "signals"], {"cse": True})

    given = [np.zeros(size) for size in sizes.values()]
    after, row = np.zeros(states.size), np.zeros(signals.size)
    bound = BoundFunction(function, given, (after, row))
    given[0][:], given[4][:] = states.pack(initial), gains_layout.pack(gains)
    log, last = np.empty((count, signals.size)), len(mission.times) - 1
    for k in range(count):
        if k and recorded.held[k]:
            log[k] = log[k - 1]
            continue
        at = min(int(recorded.clock.ticks[k]), last)
        given[1][:] = measured[k]
        rows = table[at : at + window.rows]
        if ahead is not None:
            rows = rows.copy()
            rows[list(window.preview)] = ahead[k]
        given[2][:] = rows.ravel()
        given[3][:] = recorded.clock.ticks[k], recorded.clock.pace[k]
        if changing is not None:
            given[4][changing[0]] = changing[1][k]
        given[5][:] = recorded.command.thrusts[k]
        bound.evaluate()
        log[k], given[0][:] = row, after
        _report(progress, k, count)
    return {name: log[:, part].reshape(count, *signals.shapes[name]) for name, part in signals.slices.items()}


def _in_python(
    controller: Controller,
    recorded: Recorded,
    mission: Mission,
    dt: float,
    progress: Progress | None,
    ahead: np.ndarray | None,
) -> dict[str, np.ndarray]:
    """The same for a controller that cannot be traced; what it believes of its thrusts is its own affair."""
    what, preview = f"controller '{controller.name}'", window_of(needs_of(controller).preview, False, dt)
    gains, state, rows = controller.gains(), controller.initial_state(), list[Mapping[str, Any]]()
    last = len(mission.times) - 1
    layout = Layout(mission.first)
    for k in range(len(recorded)):
        if k and recorded.held[k]:
            rows.append(rows[-1])
            continue
        measurement = Measurement(*(entry[k].copy() for entry in recorded.measurement))
        clock = Clock(min(float(recorded.clock.ticks[k]), float(last)), float(recorded.clock.pace[k]))
        reference = mission.at(clock, preview.preview)
        if ahead is not None:
            reference = reference._replace(ahead=tuple(layout.unpack(row) for row in ahead[k]))
        try:
            state, command, own = controller.step(gains, state, measurement, reference, dt)
        except Exception as error:
            raise described_user_error(f"{what} at t = {k * dt:.3f} s", error) from error
        rows.append({**own, **_named(command)})
        if rows[-1].keys() != rows[0].keys():
            odd = sorted(rows[-1].keys() ^ rows[0].keys())
            raise ConfigError(f"{what} records other signals than at its first tick: {', '.join(odd)}")
        _report(progress, k, len(recorded))
    return {
        name: np.array([np.asarray(row[name], dtype=float).squeeze() for row in rows]) for name in rows[0]
    }


def _named(command: Command) -> dict[str, Any]:
    return {f"{name}_command": part for name, part in command._asdict().items()}


def _first(measurement: Measurement) -> Measurement:
    return Measurement(*(entry[0] for entry in measurement))


def _report(progress: Progress | None, k: int, count: int) -> None:
    if progress is not None and ((k + 1) % _REPORTED == 0 or k + 1 == count):
        progress(k + 1, count)
