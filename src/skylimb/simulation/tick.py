"""One control tick of a simulated flight as one compiled function.

    (state, plant outputs, row, references, gains, rotors) -> (state, controls, signals, joint forces)

Sensors, controller, actuators and everything that is recorded are traced once with CasADi's symbols. The row
holds what is known of a tick before the flight: age of the motion capture's frame, noise. The references are
the mission's, from the tick that its own clock shows: a controller may hold that clock back. All of it is
pure, so that a driver in any language gives the same flight; gains and the numbers of the plant's rotors are
inputs, so that changing one rebuilds nothing.
"""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.packing import Layout, structure
from skylimb.base.split_function import PythonCall, split_function
from skylimb.control.controller import TraceableController
from skylimb.control.loop.flight import MISSION_TIME
from skylimb.control.missions.clock import next_clock, start_of_mission
from skylimb.control.missions.table import Window, window_of
from skylimb.control.needs import PACE, needs_of
from skylimb.control.supervisor.supervised import Supervised
from skylimb.simulation.plant import Plant
from skylimb.simulation.plant_tick import (
    check_measured_link,
    drive_plant,
    initial_rates,
    plant_numbers,
    plant_signals,
    sense_plant,
    symbolic_outputs,
)
from skylimb.simulation.rows import TickRow, reference_layout, row_layout
from skylimb.simulation.sensors import SensorConfig, initial_sensor_state
from skylimb.symbolic import where


@dataclass(frozen=True)
class CompiledTick:
    """A controller's tick, ready for a driver.

    Attributes:
        function: (state, qpos, qvel, act, history, row, references, gains, rotors) -> (state, controls,
            signals, joint_forces), all flat. `references` holds the rows of the mission that `window` says,
            one behind the other.
        state: the state before the first tick, flat.
        gains: the controller's gains, flat.
        gains_layout: where each gain stands.
        rows: layout of a row.
        window: which rows of the mission a tick reads.
        clock: where in the state the mission's clock is, or None where it goes with the flight's.
        signals: layout of the signals.
        rotors: `plant_numbers`.
        calls: laws in plain Python in the middle of the function.
    """

    function: ca.Function
    state: np.ndarray
    gains: np.ndarray
    gains_layout: Layout[Any]
    rows: Layout[TickRow]
    window: Window
    signals: Layout[dict[str, Any]]
    rotors: np.ndarray
    clock: int | None = None
    calls: tuple[PythonCall, ...] = ()


def initial_tick_state(
    controller: TraceableController,
    plant: Plant,
    sensors: SensorConfig,
    rest: tuple[np.ndarray, np.ndarray],
    dt: float,
) -> Any:
    """Sensors, controller, mission clock and the robot's rates before the first tick.

    Args:
        controller: what flies.
        plant: what it flies.
        sensors: rate and latency give the depth of the history.
        rest: `plant_tick.at_rest` before take-off.
        dt: control period, s.
    """
    clock = start_of_mission() if needs_of(controller).paced else ()
    return initial_sensor_state(sensors, dt, *rest), controller.initial_state(), clock, initial_rates(plant)


_traced: OrderedDict[tuple[Any, ...], CompiledTick] = OrderedDict()
_MOST_TRACED = 64


def compile_tick(
    controller: TraceableController,
    plant: Plant,
    sensors: SensorConfig,
    rest: tuple[np.ndarray, np.ndarray],
    dt: float,
) -> CompiledTick:
    """Trace the whole tick with symbols and make one function of it.

    A tick of the same structure is traced once in a process: gains, seeds, noise and the plant's own numbers
    are data, so that thousands of flights that differ in those share a function.

    Args:
        controller: one that can be traced.
        plant: what it flies; only addresses and limits are taken from it.
        sensors: rate and latency give the depth of the history.
        rest: `plant_tick.at_rest` before take-off.
        dt: control period, s.
    """
    check_measured_link(plant)
    controller.require(dt)
    needs = needs_of(controller)
    window = window_of(needs.preview, needs.paced, dt)
    initial = initial_tick_state(controller, plant, sensors, rest, dt)
    key = _structure(controller, plant, initial, window, dt)
    if key not in _traced:
        _traced[key] = _trace(controller, plant, initial, window, dt)
        while len(_traced) > _MOST_TRACED:
            _traced.popitem(last=False)
    layout = _traced[key].gains_layout
    return dataclasses.replace(
        _traced[key],
        state=Layout(initial).pack(initial),
        gains=layout.pack(controller.gains()),
        rotors=plant_numbers(plant, dt),
    )


def _structure(
    controller: TraceableController, plant: Plant, initial: Any, window: Window, dt: float
) -> tuple[Any, ...]:
    """Everything that ends up in a traced function rather than in its arguments."""
    model, reading = plant.model, plant.reading
    return (
        controller.structure(),
        structure((initial[0], *initial[2:])),
        (plant.joint_qpos, plant.vectoring_qpos, plant.robot.n_rotors),
        plant.robot.description.digest if plant.turning or plant.air or initial[0].imu else None,
        plant.air is not None,
        tuple(int(size) for size in (model.nq, model.nv, model.na, model.nhistory)),
        tuple(part.tobytes() for part in vars(reading).values() if part is not None),
        window,
        dt,
    )


def _trace(
    controller: TraceableController, plant: Plant, initial: Any, window: Window, dt: float
) -> CompiledTick:
    """The tick of a structure, with the numbers of the flight that was met first."""
    gains, numbers = controller.gains(), plant_numbers(plant, dt)
    states, gain_layout = Layout(initial), Layout(gains)
    rows, references = row_layout(plant.robot), reference_layout(plant.robot)
    x, row, given, p, rotors = (
        ca.SX.sym(name, size)
        for name, size in (
            ("state", states.size),
            ("row", rows.size),
            ("references", references.size * window.rows),
            ("gains", gain_layout.size),
            ("rotors", numbers.size),
        )
    )
    outputs = symbolic_outputs(plant.model)
    sensor_state, controller_state, clock, rates = states.unpack(x)
    known, reference = rows.unpack(row), window.read(references, given, clock)
    last_age = sensor_state.age
    sensor_state, measurement = sense_plant(plant, sensor_state, outputs, known, dt)
    traced, asked = controller.opened()
    before: Any = controller_state
    if isinstance(traced, Supervised):
        # What came decides whether a pose is new, whatever its stamp says.
        fresh = where(sensor_state.age < last_age + 0.5 * dt, 1.0, 0.0)
        before = traced.flagged(controller_state, known.late, fresh)
    controller_state, command, inner = traced.step(gain_layout.unpack(p), before, measurement, reference, dt)
    scales = known.thrust_scales
    limits = controller.robot.description
    drive = drive_plant(plant, limits, outputs, command, rotors, scales, known.held, rates, dt)
    shown = plant_signals(plant, outputs, scales, measurement, command)
    recorded = {**shown, **drive.signals, **inner}
    if window.paced:
        recorded[MISSION_TIME] = clock.ticks * dt
        clock = next_clock(clock, inner[PACE])
    signals = Layout(recorded)
    new = states.pack((sensor_state, controller_state, clock, drive.rates))
    function, calls = split_function(
        "tick",
        [x, *outputs, row, given, p, rotors],
        [new, drive.controls, signals.pack(recorded), drive.joint_forces],
        (
            ("state", "qpos", "qvel", "act", "history", "row", "references", "gains", "rotors"),
            ("next_state", "controls", "signals", "joint_forces"),
        ),
        asked,
    )
    clock_at = states.slices["2.ticks"].start if window.paced else None
    own = states.pack(initial), gain_layout.pack(gains), gain_layout
    return CompiledTick(function, *own, rows, window, signals, numbers, clock_at, calls)
