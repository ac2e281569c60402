"""The simulated plant as a vehicle: sensors, actuators and physics around any controller."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import mujoco
import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Measurement, zero_measurement
from skylimb.control.records import Command
from skylimb.simulation.engine_warnings import raised_warnings
from skylimb.simulation.plant import Plant
from skylimb.simulation.plant_tick import (
    PlantOutputs,
    at_rest,
    check_measured_link,
    drive_plant,
    initial_rates,
    plant_numbers,
    plant_signals,
    sense_plant,
    symbolic_outputs,
)
from skylimb.simulation.rows import row_layout
from skylimb.simulation.sensors import SensorConfig, initial_sensor_state

Advance = Callable[[mujoco.MjModel, mujoco.MjData, int], None]
"""Advances the physics by a number of steps: the engine itself, or a user's plant (`PlantSteps`)."""


class SimulatedVehicle:
    """The plant behind the sensors and actuators of the compiled tick.

    Args:
        plant: what flies.
        data: its state; it is advanced.
        rows: a packed `TickRow` for every tick; a longer flight has them again from the first one on.
        sensors: rate and latency.
        dt: control period, s.
        scales: thrust that acts over what the lag of each rotor gives, (k, n): a row a tick; the last one
            stays.
        acts: what acts on the plant before a tick's physics.
        faster: makes a function faster that is evaluated at every tick.
        advance: advances the physics.
        added: what events add to the rows, a row a tick; the last one stays.
    """

    def __init__(
        self,
        plant: Plant,
        data: mujoco.MjData,
        rows: np.ndarray,
        sensors: SensorConfig,
        dt: float,
        scales: np.ndarray,
        acts: Sequence[Callable[[int], None]] = (),
        faster: Callable[[ca.Function], ca.Function] = lambda function: function,
        advance: Advance = mujoco.mj_step,
        added: np.ndarray | None = None,
    ) -> None:
        check_measured_link(plant)
        self._plant, self._data, self._rows, self._added = plant, data, rows, added
        self._acts, self._advance, self._tick = tuple(acts), advance, 0
        robot = plant.robot
        layout = Layout(zero_measurement(robot.n_joints, robot.n_vectoring, sensors.imu.on))
        self._unpack = layout.unpack
        self._measured, self._row = np.zeros(layout.size), np.zeros(rows.shape[1])
        self._taken: Command | None = None
        self._command = [np.zeros(size) for size in _command_sizes(plant)]
        outputs = (data.qpos, data.qvel, data.act, data.history)
        # State and next state change places at every tick, so that nothing is copied.
        sense, state = _sensors(plant, sensors, data, dt)
        sense, states = faster(sense), (state, state.copy())
        self._sense = [
            BoundFunction(sense, (states[i], *outputs, self._row), (states[1 - i], self._measured))
            for i in (0, 1)
        ]
        record, self._layout = _recorder(plant, layout, dt)
        self._signals, rotors = np.zeros(self._layout.size), plant_numbers(plant, dt)
        self._scales, self._scaled = scales, scales[0].copy()
        held = self._row[row_layout(robot).slices["held"]]
        self._rates = np.array(initial_rates(plant))
        self._next_rates = self._rates.copy()
        driven = *outputs, rotors, self._scaled, held
        self._record = BoundFunction(
            faster(record), (*driven, self._measured, *self._command), (self._signals,)
        )
        self._actuate = BoundFunction(
            faster(actuator_function(plant, dt)),
            (*driven, self._rates, *self._command),
            (data.ctrl, data.qfrc_applied, self._next_rates),
        )

    @property
    def layout(self) -> Layout[dict[str, Any]]:
        """Where each signal stands in what `record` returns."""
        return self._layout

    def measure(self) -> Measurement:
        """What the sensors say at this tick."""
        self._row[:] = self._rows[self._tick % len(self._rows)]
        if self._added is not None:
            self._row += self._added[min(self._tick, len(self._added) - 1)]
        self._scaled[:] = self._scales[min(self._tick, len(self._scales) - 1)]
        self._sense[self._tick & 1].evaluate()
        # A copy, as a controller may keep what it has seen.
        return self._unpack(self._measured.copy())

    def record(self, measurement: Measurement, command: Command) -> np.ndarray:
        """Truth, measurement and command of this tick, flat; overwritten at the next one."""
        self._take(command)
        self._record.evaluate()
        return self._signals

    def apply(self, command: Command) -> None:
        """Command the actuators and advance the physics by a control period."""
        self._take(command)
        self._actuate.evaluate()
        self._rates[:] = self._next_rates
        for act in self._acts:
            act(self._tick)
        self._advance(self._plant.model, self._data, self._plant.substeps)
        self._tick += 1

    def _take(self, command: Command) -> None:
        if command is self._taken:
            return
        self._taken = command
        for place, part in zip(self._command, command, strict=True):
            place[:] = part

    def fault(self) -> str:
        """What the physics engine has warned of; empty while it has not."""
        return raised_warnings(self._data.warning.number.tolist())


def _command_sizes(plant: Plant) -> tuple[int, int, int]:
    return plant.robot.n_rotors, plant.robot.n_joints, plant.robot.n_vectoring


def actuator_function(plant: Plant, dt: float) -> ca.Function:
    """(outputs, rotors, scales, held, rates before, command) -> controls, forces, rates: `drive_plant`."""
    outputs, rotors, scales, held, rates, command = _driven(plant, dt)
    drive = drive_plant(plant, plant.robot.description, outputs, command, rotors, scales, held, rates, dt)
    results = [ca.densify(ca.vertcat(part)) for part in (drive.controls, drive.joint_forces, drive.rates)]
    return ca.Function("actuate", [*outputs, rotors, scales, held, rates, *command], results, {"cse": True})


def _driven(plant: Plant, dt: float) -> tuple[PlantOutputs, ca.SX, ca.SX, ca.SX, ca.SX, Command]:
    """Symbols of all that a plant is driven by."""
    rotors = ca.SX.sym("rotors", plant_numbers(plant, dt).size)
    scales, held = ca.SX.sym("scales", plant.robot.n_rotors), ca.SX.sym("held")
    rates = ca.SX.sym("rates", len(initial_rates(plant)))
    command = Command(*map(ca.SX.sym, Command._fields, _command_sizes(plant)))
    return symbolic_outputs(plant.model), rotors, scales, held, rates, command


def _sensors(
    plant: Plant, config: SensorConfig, data: mujoco.MjData, dt: float
) -> tuple[ca.Function, np.ndarray]:
    """The sensors alone as a function, and their state before the first tick."""
    initial = initial_sensor_state(config, dt, *at_rest(plant, data))
    states, rows = Layout(initial), row_layout(plant.robot)
    x, row, outputs = (
        ca.SX.sym("state", states.size),
        ca.SX.sym("row", rows.size),
        symbolic_outputs(plant.model),
    )
    state, measurement = sense_plant(plant, states.unpack(x), outputs, rows.unpack(row), dt)
    packed = Layout(measurement).pack(measurement)
    results = [ca.densify(states.pack(state)), ca.densify(packed)]
    return ca.Function("sense", [x, *outputs, row], results, {"cse": True}), states.pack(initial)


def _recorder(plant: Plant, measurements: Layout[Measurement], dt: float) -> tuple[ca.Function, Layout[Any]]:
    """What is recorded whatever the controller, as a function of plant, measurement and command."""
    outputs, rotors, scales, held, rates, command = _driven(plant, dt)
    measured = ca.SX.sym("measured", measurements.size)
    recorded = plant_signals(plant, outputs, scales, measurements.unpack(measured), command)
    limits = plant.robot.description
    recorded |= drive_plant(plant, limits, outputs, command, rotors, scales, held, rates, dt).signals
    layout = Layout(recorded)
    function = ca.Function(
        "record", [*outputs, rotors, scales, held, measured, *command], [ca.densify(layout.pack(recorded))]
    )
    return function, layout
