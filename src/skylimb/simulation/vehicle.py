"""The simulated plant as a vehicle: sensors, actuators and physics around any controller."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import mujoco
import numpy as np

from skylimb.control.records import Command
from skylimb.estimation.records import Measurement
from skylimb.packing import Layout
from skylimb.simulation.actuators import actuate
from skylimb.simulation.engine_warnings import raised_warnings
from skylimb.simulation.plant import Plant
from skylimb.simulation.rows import row_layout
from skylimb.simulation.sensors import SensorConfig, initial_sensor_state
from skylimb.simulation.tick import check_measured_link, plant_signals, sense_plant, symbolic_outputs


class SimulatedVehicle:
    """MuJoCo's plant behind the sensors and actuators of the compiled tick.

    Args:
        plant: what flies.
        data: its state; it is advanced.
        rows: one packed `TickRow` for every tick that the flight may have.
        sensors: rate and latency.
        dt: control period, s.
        interventions: what acts on the plant from outside before a tick's physics.
    """

    def __init__(
        self,
        plant: Plant,
        data: mujoco.MjData,
        rows: np.ndarray,
        sensors: SensorConfig,
        dt: float,
        interventions: Sequence[Callable[[int], None]] = (),
    ) -> None:
        check_measured_link(plant)
        self._plant, self._data, self._rows, self._dt = plant, data, rows, dt
        self._interventions, self._tick = tuple(interventions), 0
        self._measurements = Layout(_measurement_template(plant))
        self._sense, self._state = _sensors(plant, sensors, data, dt)
        self._record, self._layout = _recorder(plant, self._measurements)
        self._measured = np.zeros(self._measurements.size)

    @property
    def layout(self) -> Layout[dict[str, Any]]:
        """Where each signal stands in what `record` returns."""
        return self._layout

    def measure(self) -> Measurement:
        """What the sensors say at this tick."""
        state, measured = self._sense(self._state, *self._outputs(), self._rows[self._tick])
        self._state, self._measured = _flat(state), _flat(measured)
        return self._measurements.unpack(self._measured)

    def record(self, measurement: Measurement, command: Command) -> np.ndarray:
        """Truth, measurement and command of this tick, flat."""
        return _flat(self._record(*self._outputs(), self._measured, *command))

    def apply(self, command: Command) -> None:
        """Command the actuators and advance the physics by a control period."""
        data = self._data
        data.ctrl[:] = actuate(self._plant.robot.description, command, data.act, self._dt)
        for act in self._interventions:
            act(self._tick)
        mujoco.mj_step(self._plant.model, data, self._plant.substeps)
        self._tick += 1

    def fault(self) -> str:
        """What the physics engine has warned of; empty while it has not."""
        return raised_warnings(self._data.warning.number.tolist())

    def _outputs(self) -> tuple[np.ndarray, ...]:
        return self._data.qpos, self._data.qvel, self._data.act, self._data.history


def _flat(value: Any) -> np.ndarray:
    return np.asarray(value, dtype=float).ravel()


def _measurement_template(plant: Plant) -> Measurement:
    z3, robot = np.zeros(3), plant.robot
    return Measurement(z3, np.zeros(4), z3, z3, np.zeros(robot.n_joints), np.zeros(robot.n_vectoring))


def _sensors(
    plant: Plant, config: SensorConfig, data: mujoco.MjData, dt: float
) -> tuple[ca.Function, np.ndarray]:
    """The sensors alone as a function, and their state before the first tick."""
    initial = initial_sensor_state(config, dt, np.concatenate([data.qpos[0:7], data.qvel[0:6]]))
    states, rows = Layout(initial), row_layout(plant.robot)
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
    robot, outputs = plant.robot, symbolic_outputs(plant.model)
    measured = ca.SX.sym("measured", measurements.size)
    command = Command(
        ca.SX.sym("thrusts", robot.n_rotors),
        ca.SX.sym("joints", robot.n_joints),
        ca.SX.sym("vectoring", robot.n_vectoring),
    )
    recorded = plant_signals(plant, outputs, measurements.unpack(measured), command)
    layout = Layout(recorded)
    function = ca.Function("record", [*outputs, measured, *command], [ca.densify(layout.pack(recorded))])
    return function, layout
