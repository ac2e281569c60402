"""The references of a flight whose configuration is not known, from what its log holds of them."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr

from skylimb.base.rotations import rotation_from_quaternion, rpy_from_rotation
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.mission import PHASES, Mission
from skylimb.control.missions.reference import Reference
from skylimb.control.planning.posture import posture_family
from skylimb.flight.replay.recorded import Recorded
from skylimb.flight.replay.whole_reference import mission_of_rows
from skylimb.robots.model import Robot

_TOUCHING, _WAITING = ("approach", "settle", "slide"), ("settle", "slide")


def mission_of_log(
    log: xr.Dataset, recorded: Recorded, robot: Robot, period: float
) -> tuple[Mission, tuple[str, ...]]:
    """A mission with one row for every tick of a log, and what had to be made up for it.

    Args:
        log: its rows are ticks.
        recorded: what it holds of measurements and commands.
        robot: that flew.
        period: control period, s.
    """
    count, said = len(recorded), list[str]()
    axis = log.attrs.get("contact_axis", [1.0, 0.0, 0.0])
    axis = np.asarray(json.loads(axis) if isinstance(axis, str) else axis, dtype=float)
    frame = contact_frame(tuple(axis))
    position, heading = _where_it_is(recorded, robot)
    reference = _signal(log, "cog_position_reference", count)
    if reference is None:
        said.append("no cog_position_reference: it is taken to be where the robot is, at its own heading")
    else:
        position, heading = reference, np.full(count, frame.heading)
        said.append("headings of the reference are not in a log: that of the contact axis")
    phase = _signal(log, "phase", count)
    if phase is None:
        said.append("no phase: the force estimate is not tared, and the arm is held")
        phase = np.zeros(count)
    numbers = {name: index for index, name in enumerate(PHASES)}

    def is_in(*names: str) -> Any:
        return np.isin(phase, [numbers[name] for name in names]).astype(float)

    tip = _signal(log, "tip_position_reference", count)
    zeros = np.zeros((count, 3))
    reach = _signal(log, "reach_reference", count)
    made = Reference(
        position=position,
        velocity=_or(_signal(log, "cog_velocity_reference", count), zeros),
        acceleration=_or(_signal(log, "cog_acceleration_reference", count), zeros),
        heading=heading,
        reach=_or(reach, np.full(count, float(posture_family(robot).reach_nominal))),
        joint_angles=recorded.command.joint_angles,
        vectoring_angles=recorded.command.vectoring_angles,
        contact_axis=np.tile(axis, (count, 1)),
        tare=is_in("tare"),
        align=np.zeros(count),
        adapt=is_in(*_TOUCHING),
        tip_position=_or(tip, position),
        tip_velocity=zeros,
        tip_acceleration=zeros,
        touch=is_in(*_TOUCHING),
        wait=is_in(*_WAITING),
        sliding_axis=np.tile(frame.sliding_u, (count, 1)),
        force=np.zeros(count),
        clearance=np.zeros(count),
        fine=np.zeros(count),
    )
    return mission_of_rows(made, phase.astype(int), period), tuple(said)


def _where_it_is(recorded: Recorded, robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Centre of gravity, W, m, (k, 3), and heading, rad, (k,), in the first posture."""
    measured = recorded.measurement
    model = robot.at(measured.joint_angles[0], measured.vectoring_angles[0])
    turns = np.array([rotation_from_quaternion(q) for q in measured.quaternion])
    yaw = np.array([rpy_from_rotation(R @ model.R_root_C)[2] for R in turns])
    return measured.position + turns @ model.cog_root, yaw + model.tip_heading


def _signal(log: xr.Dataset, name: str, count: int) -> np.ndarray | None:
    if name not in log.variables:
        return None
    values = np.asarray(log[name].values, dtype=float)
    return values if len(values) == count and np.isfinite(values).all() else None


def _or(values: np.ndarray | None, usual: np.ndarray) -> np.ndarray:
    return usual if values is None else values
