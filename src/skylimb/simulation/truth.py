"""What really happened, computed from the plant's recorded configuration after the flight.

The loop records only the physics' own state. Everything that follows from it exactly (centre of gravity, tip,
attitude, reach, slip, gap) is computed here for the whole flight at once, from the model of the robot that
really flew.
"""

from __future__ import annotations

import functools
from contextlib import suppress
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.base.c_code import c_source
from skylimb.base.errors import CompileError
from skylimb.base.packing import Layout
from skylimb.base.rotations import rotation_from_quaternion, rpy_from_rotation
from skylimb.control.loop.flight import Flight
from skylimb.control.missions.mission import Mission
from skylimb.robots.model import Robot
from skylimb.simulation.compiling import built_library
from skylimb.simulation.plant import Plant
from skylimb.simulation.surfaces.contact_record import contact_gaps, record_contact
from skylimb.simulation.surfaces.touched import Touched
from skylimb.symbolic import cross

_BLOCK = 256
"""Ticks that are evaluated by one call: flights of any length share one function."""


class Kinematics(NamedTuple):
    """Exact kinematics of one configuration; the contact axis is given in W.

    Attributes:
        cog_position: W, m.
        cog_velocity: W, m/s, with the arm's own motion.
        attitude: roll, pitch, yaw of C, rad.
        tilt: angle between C's z axis and W's, rad.
        tip_position: W, m.
        tip_velocity: W, m/s.
        reach: from the centre of gravity to the tip along the contact axis, m.
        skeleton: points along the chain, W, m, (nodes, 3).
    """

    cog_position: Any
    cog_velocity: Any
    attitude: Any
    tilt: Any
    tip_position: Any
    tip_velocity: Any
    reach: Any
    skeleton: Any


@functools.lru_cache(maxsize=16)
def _kinematics_function(
    robot: Robot,
    joint_qpos: tuple[int, ...],
    vectoring_qpos: tuple[int, ...],
    nq: int,
    nv: int,
    built: bool,
) -> tuple[ca.Function, ca.Function, Layout[Kinematics]]:
    """The kinematics of a tick and of `_BLOCK` ticks; these `built` as machine code, where that can be."""
    qpos, qvel, axis = ca.SX.sym("qpos", nq), ca.SX.sym("qvel", nv), ca.SX.sym("axis", 3)
    q, psi = qpos[list(joint_qpos)], qpos[list(vectoring_qpos)]
    # A free joint has seven positions and six velocities.
    rates = ca.vertcat(qvel[[i - 1 for i in joint_qpos]], qvel[[i - 1 for i in vectoring_qpos]])
    model = robot.model(q, psi)
    R, omega = rotation_from_quaternion(qpos[3:7]), qvel[3:6]
    cog = qpos[0:3] + R @ model.cog_root
    cog_velocity = qvel[0:3] + R @ (cross(omega, model.cog_root) + model.cog_jacobian @ rates)
    tip = qpos[0:3] + R @ model.tip_root
    tip_velocity = qvel[0:3] + R @ (
        cross(omega, model.tip_root) + model.tip_jacobian @ rates[: len(joint_qpos), :]
    )
    R_WC = R @ model.R_root_C
    points = robot.skeleton(q, psi)
    nodes = ca.horzcat(*(qpos[0:3] + R @ points[i, :].T for i in range(points.shape[0]))).T
    tilt = ca.atan2(ca.sqrt(R_WC[0, 2] ** 2 + R_WC[1, 2] ** 2), R_WC[2, 2])
    record = Kinematics(
        cog, cog_velocity, rpy_from_rotation(R_WC), tilt, tip, tip_velocity, ca.dot(tip - cog, axis), nodes
    )
    layout = Layout(record)
    packed = ca.densify(layout.pack(record))
    # Equal subexpressions are shared: they give the same numbers, once.
    function = ca.Function("kinematics", [qpos, qvel, axis], [packed], {"cse": True})
    block = function.map(_BLOCK)
    if built:
        with suppress(CompileError):
            library = built_library("native", "kinematics", c_source(block))
            return function, ca.external(block.name(), str(library)), layout
    return function, block, layout


def _over_ticks(block: ca.Function, *columns: np.ndarray) -> np.ndarray:
    """A function of vectors at every tick, (ticks, outputs), on the arrays' own memory.

    Args:
        block: the function mapped over `_BLOCK` ticks.
        columns: its arguments, (ticks, size) each.
    """
    count = len(columns[0])
    padded = -(-count // _BLOCK) * _BLOCK
    # CasADi stores by columns, so that a row for each tick is its column for each tick.
    arguments = [np.zeros((padded, column.shape[1])) for column in columns]
    for argument, column in zip(arguments, columns, strict=True):
        argument[:count] = column
    table = np.empty((padded, block.size1_out(0)))
    bound = BoundFunction(block, (), ())
    for start in range(0, padded, _BLOCK):
        bound.bind(
            [argument[start : start + _BLOCK] for argument in arguments], [table[start : start + _BLOCK]]
        )
        bound.evaluate()
    return table[:count]


def _kinematics(plant: Plant) -> tuple[ca.Function, ca.Function, Layout[Kinematics]]:
    model = plant.model
    # Every other robot would be built for one flight alone, which takes longer than it saves.
    built = plant.as_described
    return _kinematics_function(
        plant.robot, plant.joint_qpos, plant.vectoring_qpos, int(model.nq), int(model.nv), built
    )


def kinematics_at(plant: Plant, qpos: np.ndarray, qvel: np.ndarray, axis: np.ndarray) -> Kinematics:
    """Exact kinematics of one moment.

    Args:
        plant: what flies.
        qpos: positions of the scene's joints.
        qvel: their velocities.
        axis: of the contact, W.
    """
    function, _, layout = _kinematics(plant)
    row = np.asarray(function(qpos, qvel, axis)).ravel()
    return Kinematics(*(row[layout.slices[name]].reshape(layout.shapes[name]) for name in Kinematics._fields))


def flight_kinematics(plant: Plant, flight: Flight, mission: Mission) -> Kinematics:
    """Exact kinematics at every tick of a flight; every entry has the ticks as first dimension."""
    _, function, layout = _kinematics(plant)
    qpos, qvel = flight.signal("configuration"), flight.signal("configuration_velocity")
    axes = mission.reference.contact_axis[: flight.ticks]
    table = _over_ticks(function, qpos, qvel, axes)

    def column(name: str) -> np.ndarray:
        values, shape = table[:, layout.slices[name]], layout.shapes[name]
        return values.reshape(len(table), *shape)

    return Kinematics(*(column(name) for name in Kinematics._fields))


def contact_truth(
    plant: Plant, flight: Flight, mission: Mission, moved: Kinematics, surface: Touched
) -> tuple[dict[str, np.ndarray], list[list[float]]]:
    """What the contact was at every tick on the surface where it then is; start and duration (s) of gaps.

    A logged force is the mean since the tick before, so a tick's slip, work and trace are those of the tick
    that ends there.
    """
    times = mission.times[: flight.ticks]
    force, duty = flight.signal("contact_force"), flight.signal("contact_duty")
    record = record_contact(
        surface, times[:-1], force[1:], duty[1:], moved.tip_position[:-1], moved.tip_velocity[:-1]
    )
    lever = flight.signal("contact_point") - moved.cog_position
    # A tick without force has no point, and no torque.
    torque = np.where(np.isnan(lever), 0.0, np.cross(lever, force))
    if "contact_couple" in flight.layout.slices:  # of a tool that touches in several places
        torque = torque + flight.signal("contact_couple")
    radius = plant.robot.description.tip.radius
    return {
        "contact_normal": surface.normal(moved.tip_position, times),
        "contact_force_normal": _from_second_tick(record["normal_force"], 0.0),
        "contact_force_tangential": _from_second_tick(record["tangential_force"], 0.0),
        "contact_torque": torque,
        "contact": (duty > 0.0).astype(float),
        "contact_trace": _from_second_tick(record["trace"], np.nan),
        "friction_work": _from_second_tick(record["friction_work"], 0.0),
        "slip_speed": _from_second_tick(np.linalg.norm(record["slip_velocity"], axis=1), 0.0),
        "surface_gap": surface.signed_distance(moved.tip_position, times) - radius,
    }, contact_gaps(times[:-1], duty[1:] > 0.0, mission.period)


def _from_second_tick(values: np.ndarray, first: float) -> np.ndarray:
    """Values of the ticks after the first, with one for the first, at which nothing has passed yet."""
    return np.concatenate([np.full((1, *values.shape[1:]), first), values])
