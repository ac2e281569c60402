"""The seam between laws that fly pairs of fixed rotors and a robot whose arms turn (`robots.turned_rotors`).

    measurement, reference: without vectoring angles -> laws of the robot of pairs -> thrusts and angles

A robot that is no robot of pairs passes as it is, so laws and supervisor need not ask.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference
from skylimb.control.records import Command
from skylimb.robots.model import Robot

_T = TypeVar("_T", Measurement, Reference)

_NONE = np.zeros(0)
"""No angles; of a single symbol CasADi makes a row where nothing is left."""


def without_angles(robot: Robot, given: _T) -> _T:
    """A measurement or a reference as the robot of pairs has it; those ahead of it as well."""
    if robot.turned is None:
        return given
    bare = given._replace(vectoring_angles=_NONE)
    if isinstance(bare, Reference):
        return bare._replace(ahead=tuple(without_angles(robot, one) for one in bare.ahead))
    return bare


def with_angles(robot: Robot, given: _T, of: _T) -> _T:
    """What the robot of pairs has, with the vectoring angles of another one."""
    return given if robot.turned is None else given._replace(vectoring_angles=of.vectoring_angles)


def as_pairs(robot: Robot, command: Command) -> Command:
    """A command as the robot of pairs has it."""
    if robot.turned is None:
        return command
    pairs = robot.turned.pairs(command.thrusts, command.vectoring_angles)
    return Command(pairs, command.joint_angles, _NONE)


def from_pairs(robot: Robot, command: Command) -> Command:
    """A command of the robot of pairs as thrusts, N, (n,), and vectoring angles, rad, (nv,)."""
    if robot.turned is None:
        return command
    thrusts, angles = robot.turned.command(command.thrusts)
    return Command(thrusts, command.joint_angles, angles)
