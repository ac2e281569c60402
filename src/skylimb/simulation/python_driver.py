"""The loop around a controller that is any Python object: slower than the compiled tick, else its equal."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import mujoco
import numpy as np

from skylimb.control.controller import Controller
from skylimb.control.records import Command
from skylimb.errors import ConfigError
from skylimb.estimation.records import Measurement
from skylimb.packing import Layout
from skylimb.simulation.actuators import actuate
from skylimb.simulation.clock import without_clock
from skylimb.simulation.drivers import FlightRows, Progress, lost_flight
from skylimb.simulation.flight import CHECK_INTERVAL, MISSION_TIME, Flight, unfinished
from skylimb.simulation.mission import Mission
from skylimb.simulation.plant import Plant
from skylimb.simulation.sensors import SensorConfig, initial_sensor_state
from skylimb.simulation.tick import (
    Clock,
    check_measured_link,
    next_clock,
    plant_signals,
    reference_between,
    reference_layout,
    row_layout,
    sense_plant,
    symbolic_outputs,
)
from skylimb.symbolic import is_symbolic


@without_clock()
def fly_python(
    controller: Controller,
    plant: Plant,
    data: mujoco.MjData,
    mission: Mission,
    rows: FlightRows,
    sensors: SensorConfig,
    dt: float,
    outside: Sequence[Callable[[int], None]] = (),
    progress: Progress | None = None,
) -> Flight:
    """Fly any controller from `data`; sensors, actuators and what is recorded are those of the compiled tick.

    Raises:
        ConfigError: when the controller's command does not fit the robot.
    """
    check_measured_link(plant)
    count, layout = len(rows), reference_layout(plant)
    paced = bool(getattr(controller, "paced", False))
    clock = Clock(0.0, 1.0)
    measurements = Layout(_measurement_template(plant))
    sense, sensor_state = _sensors(plant, sensors, data, dt)
    record, public = _recorder(plant, measurements)
    gains, state = controller.gains(), controller.initial_state()
    signals, inner_signals, log = public, Layout({}), np.zeros((0, 0))
    for start in range(0, count, CHECK_INTERVAL):
        end = min(start + CHECK_INTERVAL, count)
        for k in range(start, end):
            outputs = (data.qpos, data.qvel, data.act, data.history)
            sensor_state, measured = (_flat(value) for value in sense(sensor_state, *outputs, rows.ticks[k]))
            at = int(clock.ticks)
            reference = layout.unpack(rows.references[at])
            if paced:
                reference = reference_between(reference, layout.unpack(rows.references[at + 1]), clock)
            try:
                state, command, inner = controller.step(
                    gains, state, measurements.unpack(measured), reference, dt
                )
            except Exception as error:
                raise _failed_step(controller.name, k * dt, error) from error
            command = _checked(controller.name, command, plant)
            inner = {name: _number(value) for name, value in inner.items()}
            if paced:
                if "pace" not in inner:
                    raise ConfigError(
                        f"controller '{controller.name}' sets the mission's pace, and tells no signal 'pace'"
                    )
                inner[MISSION_TIME] = clock.ticks * dt
            if k == 0:
                # Only now is it known which inner signals this controller tells of.
                inner_signals = Layout(inner)
                signals = Layout(_zeros(public) | _zeros(inner_signals))
                log = np.full((count, signals.size), np.nan)
            log[k, : public.size] = _flat(record(*outputs, measured, *command))
            log[k, public.size :] = inner_signals.pack(inner)
            data.ctrl[:] = actuate(plant.robot.description, command, data.act, dt)
            for act in outside:
                act(k)
            mujoco.mj_step(plant.model, data, plant.substeps)
            clock = next_clock(clock, inner["pace"] if paced else 1.0)
            if clock.ticks >= rows.last + 1:
                end = k + 1
                break
        flown = Flight(log, signals, end, "")
        lost = lost_flight(flown, mission, start, data)
        if progress is not None:
            progress(int(clock.ticks), rows.last + 1)
        if lost is not None:
            return Flight(log, signals, lost[0] + 1, lost[1])
        if clock.ticks >= rows.last + 1:
            return flown
    return unfinished(mission, Flight(log, signals, count, ""))


def _flat(value: Any) -> np.ndarray:
    return np.asarray(value, dtype=float).ravel()


def _number(value: Any) -> Any:
    """A float or an array, also from CasADi's numbers, whose vectors are columns."""
    array = np.asarray(value, dtype=float)
    array = array.squeeze() if is_symbolic(value) else array
    return float(array) if array.ndim == 0 else array


def _zeros(layout: Layout[Any]) -> dict[str, Any]:
    return {name: np.zeros(shape) if shape else 0.0 for name, shape in layout.shapes.items()}


def _measurement_template(plant: Plant) -> Measurement:
    description = plant.robot.description
    z3 = np.zeros(3)
    n_joints, n_vectoring = len(description.shape_joints), len(description.vectoring_joints)
    return Measurement(z3, np.zeros(4), z3, z3, np.zeros(n_joints), np.zeros(n_vectoring))


def _sensors(
    plant: Plant, config: SensorConfig, data: mujoco.MjData, dt: float
) -> tuple[ca.Function, np.ndarray]:
    """The sensors alone as a function, and their state before the first tick."""
    initial = initial_sensor_state(config, dt, np.concatenate([data.qpos[0:7], data.qvel[0:6]]))
    states, rows = Layout(initial), row_layout(plant)
    x, row, outputs = (
        ca.SX.sym("state", states.size),
        ca.SX.sym("row", rows.size),
        symbolic_outputs(plant.model),
    )
    state, measurement = sense_plant(plant, states.unpack(x), outputs, rows.unpack(row), dt)
    packed = Layout(measurement).pack(measurement)
    return ca.Function("sense", [x, *outputs, row], [states.pack(state), packed]), states.pack(initial)


def _recorder(plant: Plant, measurements: Layout[Measurement]) -> tuple[ca.Function, Layout[Any]]:
    """What is recorded whatever the controller, as a function of plant, measurement and command."""
    description, outputs = plant.robot.description, symbolic_outputs(plant.model)
    measured = ca.SX.sym("measured", measurements.size)
    command = Command(
        ca.SX.sym("thrusts", len(description.rotors)),
        ca.SX.sym("joints", len(description.shape_joints)),
        ca.SX.sym("vectoring", len(description.vectoring_joints)),
    )
    recorded = plant_signals(plant, outputs, measurements.unpack(measured), command)
    layout = Layout(recorded)
    function = ca.Function("record", [*outputs, measured, *command], [ca.densify(layout.pack(recorded))])
    return function, layout


def _failed_step(name: str, time: float, error: Exception) -> ConfigError:
    """What to tell of an error in a user's own code: where it happened, in one line."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    place = f"{Path(last.filename).name}, line {last.lineno}"
    return ConfigError(
        f"controller '{name}' fails at t = {time:.3f} s: {type(error).__name__}: {error} ({place})"
    )


def _checked(name: str, command: Any, plant: Plant) -> Command:
    description = plant.robot.description
    wanted = {
        "thrusts": len(description.rotors),
        "joint_angles": len(description.shape_joints),
        "vectoring_angles": len(description.vectoring_joints),
    }
    values = []
    for field, length in wanted.items():
        value = _flat(getattr(command, field, np.zeros(0)))
        if len(value) != length:
            raise ConfigError(
                f"controller '{name}' gave {len(value)} {field}; {description.name} takes {length}"
            )
        values.append(value)
    return Command(*values)
