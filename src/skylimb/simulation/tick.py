"""One control tick as one compiled function: sensors, controller, actuators and what is recorded.

    (state, plant outputs, row, reference, gains) -> (state, controls, signals)

The row holds what is known of a tick before the flight: age of the motion capture's frame, noise. The
reference is the mission's, at the tick that the mission's own clock shows: a controller may hold that clock
back. All of it is pure, so that a driver in any language gives the same flight; gains are inputs, so that
changing one rebuilds nothing.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import mujoco
import numpy as np

from skylimb.control.cascade import Cascade
from skylimb.control.preset import SLOTS
from skylimb.control.records import Command, Reference, zero_reference
from skylimb.errors import DescriptionError
from skylimb.estimation.delay import require_history
from skylimb.estimation.records import Measurement
from skylimb.packing import Layout, structure
from skylimb.simulation.actuators import actuate
from skylimb.simulation.flight import MISSION_TIME
from skylimb.simulation.plant import Plant
from skylimb.simulation.sensors import SensorConfig, SensorNoise, SensorState, initial_sensor_state, sense
from skylimb.symbolic import floor, where

_FASTEST = 100.0
"""No mission goes faster than this many times its own pace."""


class TickRow(NamedTuple):
    """What is known of a tick before the flight, whatever the mission asks at it."""

    age: Any
    noise: SensorNoise


class Clock(NamedTuple):
    """Where a flight is on the mission's own clock, in ticks, and how fast that goes (1 is its own speed)."""

    ticks: Any
    pace: Any


class PlantOutputs(NamedTuple):
    """MuJoCo's state at a tick, and the contact's samples since the last one."""

    qpos: Any
    qvel: Any
    act: Any
    history: Any


def row_layout(plant: Plant) -> Layout[TickRow]:
    """Layout of a row for this robot."""
    description = plant.robot.description
    z3, nq, nv = np.zeros(3), len(description.shape_joints), len(description.vectoring_joints)
    return Layout(TickRow(0.0, SensorNoise(z3, z3, z3, z3, np.zeros(nq), np.zeros(nv))))


def reference_layout(plant: Plant) -> Layout[Reference]:
    """Layout of what the mission asks of this robot at a tick."""
    return Layout(zero_reference(plant.robot.n_joints, plant.robot.n_vectoring))


def reference_between(here: Reference, there: Reference, clock: Clock) -> Reference:
    """The reference of a clock between two ticks, its rates slowed down as the clock is.

    Args:
        here: at the last whole tick of the mission.
        there: at the next one.
        clock: where the flight is.
    """
    part = clock.ticks - floor(clock.ticks)
    mixed = Reference(*(a + part * (b - a) for a, b in zip(here, there, strict=True)))
    return mixed._replace(
        velocity=mixed.velocity * clock.pace,
        acceleration=mixed.acceleration * clock.pace**2,
        tip_velocity=mixed.tip_velocity * clock.pace,
        tip_acceleration=mixed.tip_acceleration * clock.pace**2,
    )


def next_clock(clock: Clock, pace: Any) -> Clock:
    """The clock a tick later; no pace derails it, be it negative, beyond reason or no number."""
    pace = where(pace > 0.0, where(pace < _FASTEST, pace, _FASTEST), 0.0)
    return Clock(clock.ticks + pace, pace)


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
    """A cascade's tick, ready for a driver.

    Attributes:
        function: (state, qpos, qvel, act, history, row, reference, gains) -> (state, controls, signals), all
            flat. `reference` holds the mission's row, and where the controller sets the pace also the next.
        state: the state before the first tick, flat.
        gains: the preset's gains, flat.
        gains_layout: where each gain stands.
        rows: layout of a row.
        clock: where in the state the mission's clock is, or None where it goes with the flight's.
        signals: layout of the signals.
    """

    function: ca.Function
    state: np.ndarray
    gains: np.ndarray
    gains_layout: Layout[Any]
    rows: Layout[TickRow]
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


def initial_tick_state(controller: Cascade, sensors: SensorConfig, root: np.ndarray, dt: float) -> Any:
    """Sensors, controller and clock before the first tick.

    Args:
        controller: what flies.
        sensors: rate and latency give the depth of the history.
        root: pose and twist of the measured link before take-off, (13,).
        dt: control period, s.
    """
    clock = Clock(0.0, 1.0) if controller.paced else ()
    return initial_sensor_state(sensors, dt, root), controller.initial_state(), clock


_traced: OrderedDict[tuple[Any, ...], _Traced] = OrderedDict()
_MOST_TRACED = 64


def forget_ticks() -> None:
    """Trace every tick anew from now on, as after a change of code in a running process."""
    _traced.clear()


def compile_tick(
    controller: Cascade, plant: Plant, sensors: SensorConfig, root: np.ndarray, dt: float
) -> CompiledTick:
    """Trace the whole tick with symbols and make one function of it.

    A tick of the same structure is traced once in a process: gains, seeds, noise and the plant's own numbers
    are data, so that thousands of flights that differ in those share a function.

    Args:
        controller: a cascade of laws that can be traced.
        plant: what it flies; only addresses and limits are taken from it.
        sensors: rate and latency give the depth of the history.
        root: pose and twist of the measured link before take-off, (13,).
        dt: control period, s.
    """
    check_measured_link(plant)
    require_history(controller.preset.delay, dt)
    initial = initial_tick_state(controller, sensors, root, dt)
    gains = controller.gains()
    key = _structure(controller, plant, initial, gains, dt)
    traced = _traced.get(key)
    if traced is None:
        traced = _traced[key] = _trace(controller, plant, initial, gains, dt)
        while len(_traced) > _MOST_TRACED:
            _traced.popitem(last=False)
    return CompiledTick(
        traced.function,
        Layout(initial).pack(initial),
        traced.gains_layout.pack(gains),
        traced.gains_layout,
        traced.rows,
        traced.signals,
        traced.clock,
    )


def _structure(controller: Cascade, plant: Plant, initial: Any, gains: Any, dt: float) -> tuple[Any, ...]:
    """Everything that ends up in a traced function rather than in its arguments."""
    preset, family, table, model = controller.preset, controller.family, controller.vectoring, plant.model
    reading = plant.reading
    # Functions are compared by identity, so that a law that was loaded anew is traced anew.
    laws = tuple(getattr(preset, slot).law.step for slot in SLOTS)
    return (
        type(controller),
        controller.robot,
        laws,
        preset.tare,
        structure(gains),
        structure(initial),
        (family.theta_min, family.theta_max, family.theta_nominal, family.described, family.coefficients),
        (table.theta_min, table.theta_max, table.digest, np.asarray(table.coefficients).tobytes()),
        (plant.joint_qpos, plant.vectoring_qpos, len(plant.robot.description.rotors)),
        tuple(int(size) for size in (model.nq, model.nv, model.na, model.nhistory)),
        tuple(part.tobytes() for part in (reading.found, reading.force, reading.position)),
        dt,
    )


def _trace(controller: Cascade, plant: Plant, initial: Any, gains: Any, dt: float) -> _Traced:
    states, gain_layout, rows = Layout(initial), Layout(gains), row_layout(plant)

    references, paced = reference_layout(plant), controller.paced
    x, row, given, p = (
        ca.SX.sym(name, size)
        for name, size in (
            ("state", states.size),
            ("row", rows.size),
            ("reference", references.size * (2 if paced else 1)),
            ("gains", gain_layout.size),
        )
    )
    outputs = symbolic_outputs(plant.model)
    sensor_state, controller_state, clock = states.unpack(x)
    known, reference = rows.unpack(row), references.unpack(given[: references.size])
    if paced:
        reference = reference_between(reference, references.unpack(given[references.size :]), clock)
    sensor_state, measurement = sense_plant(plant, sensor_state, outputs, known, dt)
    controller_state, command, inner = controller.step(
        gain_layout.unpack(p), controller_state, measurement, reference, dt
    )
    controls = actuate(controller.robot.description, command, outputs.act, dt)
    recorded = plant_signals(plant, outputs, measurement, command) | inner
    if paced:
        recorded[MISSION_TIME] = clock.ticks * dt
        clock = next_clock(clock, inner["pace"])
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
        ["state", "qpos", "qvel", "act", "history", "row", "reference", "gains"],
        ["next_state", "controls", "signals"],
        {"cse": True},
    )
    return _Traced(function, gain_layout, rows, signals, states.slices["2.ticks"].start if paced else None)
