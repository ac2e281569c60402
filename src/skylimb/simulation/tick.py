"""One control tick of a simulated flight as one compiled function.

    (state, plant outputs, row, references, gains) -> (state, controls, signals)

Sensors, controller, actuators and everything that is recorded are traced once with CasADi's symbols. The row
holds what is known of a tick before the flight: age of the motion capture's frame, noise. The references are
the mission's, from the tick that its own clock shows: a controller may hold that clock back. All of it is
pure, so that a driver in any language gives the same flight; gains are inputs, so that changing one rebuilds
nothing.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import mujoco
import numpy as np

from skylimb.base.errors import DescriptionError
from skylimb.base.packing import Layout, structure
from skylimb.control.controller import TraceableController
from skylimb.control.estimation.records import Measurement
from skylimb.control.loop.flight import MISSION_TIME
from skylimb.control.missions.clock import next_clock, start_of_mission
from skylimb.control.missions.table import Window, window_of
from skylimb.control.needs import PACE, needs_of
from skylimb.control.records import Command
from skylimb.simulation.actuators import actuate
from skylimb.simulation.plant import Plant
from skylimb.simulation.rows import TickRow, reference_layout, row_layout
from skylimb.simulation.sensors import SensorConfig, SensorState, initial_sensor_state, sense


class PlantOutputs(NamedTuple):
    """MuJoCo's state at a tick, and the contact's samples since the last one."""

    qpos: Any
    qvel: Any
    act: Any
    history: Any


def sense_plant(
    plant: Plant, state: SensorState, outputs: PlantOutputs, row: TickRow, dt: float
) -> tuple[SensorState, Measurement]:
    """The measurement of this tick."""
    root = ca.vertcat(outputs.qpos[0:7], outputs.qvel[0:6])
    joints = outputs.qpos[list(plant.joint_qpos)]
    vectoring = outputs.qpos[list(plant.vectoring_qpos)]
    return sense(state, root, joints, vectoring, row.age, row.noise, dt)


def plant_signals(
    plant: Plant, outputs: PlantOutputs, measurement: Measurement, command: Command
) -> dict[str, Any]:
    """What is recorded whatever the controller: truth, measurement and command."""
    contact = plant.reading.average(outputs.history)
    n = len(plant.robot.description.rotors)
    return {
        "configuration": outputs.qpos,
        "configuration_velocity": outputs.qvel,
        "root_position_measured": measurement.position,
        "root_quaternion_measured": measurement.quaternion,
        "root_velocity_measured": measurement.velocity,
        "root_angular_velocity_measured": measurement.angular_velocity,
        "joint_angles_measured": measurement.joint_angles,
        "vectoring_angles_measured": measurement.vectoring_angles,
        "thrusts": outputs.act[:n],
        "thrusts_command": command.thrusts,
        "joint_angles_command": command.joint_angles,
        "vectoring_angles_command": command.vectoring_angles,
        "contact_force": contact.force,
        "contact_duty": contact.duty,
        "contact_point": contact.position,
    }


@dataclass(frozen=True)
class CompiledTick:
    """A controller's tick, ready for a driver.

    Attributes:
        function: (state, qpos, qvel, act, history, row, references, gains) -> (state, controls, signals), all
            flat. `references` holds the rows of the mission that `window` says, one behind the other.
        state: the state before the first tick, flat.
        gains: the controller's gains, flat.
        gains_layout: where each gain stands.
        rows: layout of a row.
        window: which rows of the mission a tick reads.
        clock: where in the state the mission's clock is, or None where it goes with the flight's.
        signals: layout of the signals.
    """

    function: ca.Function
    state: np.ndarray
    gains: np.ndarray
    gains_layout: Layout[Any]
    rows: Layout[TickRow]
    window: Window
    signals: Layout[dict[str, Any]]
    clock: int | None = None


def check_measured_link(plant: Plant) -> None:
    """Raise a `DescriptionError` unless the measured link is the root, whose twist the plant gives."""
    description = plant.robot.description
    if description.measured_link != description.root:
        raise DescriptionError(
            f"robot {description.name}: measured_link = '{description.measured_link}' must be the root link "
            f"'{description.root}'"
        )


def symbolic_outputs(model: mujoco.MjModel) -> PlantOutputs:
    """Symbols in place of the plant's outputs."""
    sizes = (("qpos", model.nq), ("qvel", model.nv), ("act", model.na), ("history", model.nhistory))
    return PlantOutputs(*(ca.SX.sym(name, int(size)) for name, size in sizes))


class _Traced(NamedTuple):
    """What a tick's structure alone decides."""

    function: ca.Function
    gains_layout: Layout[Any]
    rows: Layout[TickRow]
    signals: Layout[dict[str, Any]]
    clock: int | None


def initial_tick_state(
    controller: TraceableController, sensors: SensorConfig, root: np.ndarray, dt: float
) -> Any:
    """Sensors, controller and mission clock before the first tick.

    Args:
        controller: what flies.
        sensors: rate and latency give the depth of the history.
        root: pose and twist of the measured link before take-off, (13,).
        dt: control period, s.
    """
    clock = start_of_mission() if needs_of(controller).paced else ()
    return initial_sensor_state(sensors, dt, root), controller.initial_state(), clock


_traced: OrderedDict[tuple[Any, ...], _Traced] = OrderedDict()
_MOST_TRACED = 64


def compile_tick(
    controller: TraceableController, plant: Plant, sensors: SensorConfig, root: np.ndarray, dt: float
) -> CompiledTick:
    """Trace the whole tick with symbols and make one function of it.

    A tick of the same structure is traced once in a process: gains, seeds, noise and the plant's own numbers
    are data, so that thousands of flights that differ in those share a function.

    Args:
        controller: one that can be traced.
        plant: what it flies; only addresses and limits are taken from it.
        sensors: rate and latency give the depth of the history.
        root: pose and twist of the measured link before take-off, (13,).
        dt: control period, s.
    """
    check_measured_link(plant)
    controller.require(dt)
    needs = needs_of(controller)
    window = window_of(needs.preview, needs.paced, dt)
    initial = initial_tick_state(controller, sensors, root, dt)
    gains = controller.gains()
    key = _structure(controller, plant, initial, window, dt)
    traced = _traced.get(key)
    if traced is None:
        traced = _traced[key] = _trace(controller, plant, initial, gains, window, dt)
        while len(_traced) > _MOST_TRACED:
            _traced.popitem(last=False)
    return CompiledTick(
        traced.function,
        Layout(initial).pack(initial),
        traced.gains_layout.pack(gains),
        traced.gains_layout,
        traced.rows,
        window,
        traced.signals,
        traced.clock,
    )


def _structure(
    controller: TraceableController, plant: Plant, initial: Any, window: Window, dt: float
) -> tuple[Any, ...]:
    """Everything that ends up in a traced function rather than in its arguments."""
    model, reading = plant.model, plant.reading
    return (
        controller.structure(),
        structure((initial[0], initial[2])),
        (plant.joint_qpos, plant.vectoring_qpos, len(plant.robot.description.rotors)),
        tuple(int(size) for size in (model.nq, model.nv, model.na, model.nhistory)),
        tuple(part.tobytes() for part in (reading.found, reading.force, reading.position)),
        window,
        dt,
    )


def _trace(
    controller: TraceableController, plant: Plant, initial: Any, gains: Any, window: Window, dt: float
) -> _Traced:
    states, gain_layout = Layout(initial), Layout(gains)
    rows, references = row_layout(plant.robot), reference_layout(plant.robot)
    x, row, given, p = (
        ca.SX.sym(name, size)
        for name, size in (
            ("state", states.size),
            ("row", rows.size),
            ("references", references.size * window.rows),
            ("gains", gain_layout.size),
        )
    )
    outputs = symbolic_outputs(plant.model)
    sensor_state, controller_state, clock = states.unpack(x)
    known, reference = rows.unpack(row), window.read(references, given, clock)
    sensor_state, measurement = sense_plant(plant, sensor_state, outputs, known, dt)
    controller_state, command, inner = controller.step(
        gain_layout.unpack(p), controller_state, measurement, reference, dt
    )
    controls = actuate(controller.robot.description, command, outputs.act, dt)
    recorded = {**plant_signals(plant, outputs, measurement, command), **inner}
    if window.paced:
        recorded[MISSION_TIME] = clock.ticks * dt
        clock = next_clock(clock, inner[PACE])
    signals = Layout(recorded)
    function = ca.Function(
        "tick",
        [x, *outputs, row, given, p],
        [
            ca.densify(out)
            for out in (
                states.pack((sensor_state, controller_state, clock)),
                controls,
                signals.pack(recorded),
            )
        ],
        ["state", "qpos", "qvel", "act", "history", "row", "references", "gains"],
        ["next_state", "controls", "signals"],
        {"cse": True},
    )
    clock_at = states.slices["2.ticks"].start if window.paced else None
    return _Traced(function, gain_layout, rows, signals, clock_at)
