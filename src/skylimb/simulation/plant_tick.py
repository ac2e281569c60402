"""A tick from the plant's side: what it shows, what a command does to it, and what is recorded of both."""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import mujoco
import numpy as np

from skylimb.base.errors import DescriptionError
from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Measurement
from skylimb.control.loop.vehicle import measured_signals
from skylimb.control.records import Command
from skylimb.robots.description import RobotDescription
from skylimb.simulation.actuators import actuate
from skylimb.simulation.air import air_forces
from skylimb.simulation.imu import imu_motion
from skylimb.simulation.plant import Plant
from skylimb.simulation.rotors import RotorNumbers, momentum_forces, rotor_numbers, rotor_tick
from skylimb.simulation.rows import TickRow
from skylimb.simulation.sensors import SensorState, sense
from skylimb.symbolic import where


class PlantOutputs(NamedTuple):
    """MuJoCo's state at a tick, and the contact's samples since the last one."""

    qpos: Any
    qvel: Any
    act: Any
    history: Any


def at_rest(plant: Plant, data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray]:
    """What sensors know before the first tick: pose and twist of the root link, (13,), and all angles."""
    return np.concatenate([data.qpos[0:7], data.qvel[0:6]]), data.qpos[plant.places]


def sense_plant(
    plant: Plant, state: SensorState, outputs: PlantOutputs, row: TickRow, dt: float
) -> tuple[SensorState, Measurement]:
    """The measurement of this tick."""
    root = ca.vertcat(outputs.qpos[0:7], outputs.qvel[0:6])
    joints = outputs.qpos[list(plant.joint_qpos)]
    vectoring = outputs.qpos[list(plant.vectoring_qpos)]
    imu, robot = None, plant.robot
    if state.imu:
        motion = imu_motion(robot, root, joints, vectoring, outputs.qvel[plant.dofs])
        imu = motion, robot.description.gravity, row.imu_age
    return sense(state, root, joints, vectoring, row.age, row.noise, dt, row.failure, imu)


def plant_signals(
    plant: Plant, outputs: PlantOutputs, scales: Any, measurement: Measurement, command: Command
) -> dict[str, Any]:
    """What is recorded whatever the controller: truth, measurement and command."""
    contact = plant.reading.average(outputs.history)
    couple = {} if contact.couple is None else {"contact_couple": contact.couple}
    return {
        "configuration": outputs.qpos,
        "configuration_velocity": outputs.qvel,
        **measured_signals(measurement),
        "thrusts": acting_thrusts(plant, outputs, scales),
        "thrusts_command": command.thrusts,
        "joint_angles_command": command.joint_angles,
        "vectoring_angles_command": command.vectoring_angles,
        "contact_force": contact.force,
        "contact_duty": contact.duty,
        "contact_point": contact.position,
        **couple,
    }


def acting_thrusts(plant: Plant, outputs: PlantOutputs, scales: Any) -> Any:
    """Thrusts that act on the robot, N, (n,).

    Args:
        plant: what flies.
        outputs: its state, with the thrusts that the rotors' lags give.
        scales: thrust that acts over these, (n,).
    """
    return scales * outputs.act[: plant.robot.n_rotors]


def rotor_scales(model: mujoco.MjModel, rotors: int) -> np.ndarray:
    """Thrust that acts over what the lag of each rotor gives, as the engine's model has it, (n,)."""
    return model.actuator_gainprm[:rotors, 0].copy()


class Drive(NamedTuple):
    """What a command does to the plant over a tick.

    Attributes:
        controls: of its actuators, in their order.
        joint_forces: generalised forces besides: the rotors' change of angular momentum, the air's, (nv,).
        signals: of the rotors, for the record.
        rates: of root and joints at this tick, for the next one.
    """

    controls: Any
    joint_forces: Any
    signals: dict[str, Any]
    rates: Any


def drive_plant(
    plant: Plant,
    description: RobotDescription,
    outputs: PlantOutputs,
    command: Command,
    rotors: Any,
    scales: Any,
    held: Any,
    before: Any,
    dt: float,
) -> Drive:
    """Send a command to the plant.

    A rotor that gives another thrust than commanded has another thrust factor: its speed stays, and its drag
    torque goes with its thrust.

    Args:
        plant: what flies.
        description: the limits that the command meets.
        outputs: the plant now.
        command: of this tick.
        rotors: `plant_numbers`, flat.
        scales: thrust that acts over what the lag of each rotor gives, (n,).
        held: 1 where the command does not come: thrusts and set points stay to the bit, and no rotor turns
            the robot by a change of its speed.
        before: rates of root and joints at the tick before, as `initial_rates` begins them.
        dt: control period, s.
    """
    forces, n = ca.SX(plant.model.nv, 1), plant.robot.n_rotors
    now = Command(*ca.vertsplit(outputs.act, [0, n, n + plant.robot.n_joints, plant.model.na]))
    command = Command(*(where(held > 0.5, stays, new) for stays, new in zip(now, command, strict=True)))
    controls = actuate(description, command, outputs.act, dt)
    if plant.air is not None:
        air = Layout(plant.air)
        root, known = ca.vertcat(outputs.qpos[:7], outputs.qvel[:6]), air.unpack(rotors[-air.size :])
        angles, moving = outputs.qpos[plant.places], outputs.qvel[plant.dofs]
        forces[[*range(6), *plant.dofs]] = air_forces(
            plant.robot, known, acting_thrusts(plant, outputs, scales), root, angles, moving
        )
    if not plant.turning:
        return Drive(controls, forces, {}, ())
    numbers = RotorNumbers(*ca.vertsplit(rotors[: len(RotorNumbers._fields) * n], n))
    numbers = numbers._replace(drag=numbers.drag * scales)
    tick = rotor_tick(numbers, outputs.act[:n], command.thrusts, dt)
    turns = [3, 4, 5, *plant.dofs]
    rates = outputs.qvel[turns]
    # As they will be in the middle of the tick: a torque that is held would else feed a precession.
    middle = 1.5 * rates - 0.5 * before
    forces[turns] += momentum_forces(plant.robot, numbers, tick, outputs.qpos[plant.places], middle)
    signals = {"rotor_speeds": tick.speeds, "motor_torques": tick.motor_torques}
    filtered = where(held > 0.5, now.thrusts, tick.controls)
    return Drive(ca.vertcat(filtered, controls[n:]), forces, signals, rates)


def initial_rates(plant: Plant) -> np.ndarray | tuple[()]:
    """Rates before the first tick, at rest; nothing where the rotors have no speed."""
    return np.zeros(3 + plant.robot.n_joints + plant.robot.n_vectoring) if plant.turning else ()


def plant_numbers(plant: Plant, dt: float) -> np.ndarray:
    """Numbers of the plant that a tick takes as data: of its rotors where they turn, and of the air, flat."""
    rotors = rotor_numbers(plant.robot.description, dt) if plant.turning else ()
    air = () if plant.air is None else (Layout(plant.air).pack(plant.air),)
    return np.concatenate([*rotors, *air, np.zeros(0)])


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
