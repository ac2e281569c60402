"""What air does to rotors besides thrust and drag torque: drag across their axes, and a wall beside them.

A rotor that moves across its axis is held back, by the drag of its blades and as they flap. Both are linear
in that velocity and in the rotor's speed, so one coefficient stands for both (Mahony, Kumar and Corke 2012;
Faessler, Franchi and Scaramuzza 2018):

    f = -d sqrt(m / (n g)) sqrt(T) v_across

with the root of the thrust T in place of the speed. In hover n upright rotors give -d m v.

A rotor near a wall loses some of its thrust, and is drawn toward the wall:

    f = (R / D)^2 T (pull w - loss z)

with its axis z, the wall's normal w into it, the disc's radius R and the distance D of its hub. The square is
how an image of the rotor behind a plane dies away (Cheeseman and Bennett 1955).

All of it is worked out at the beginning of a control tick, with the thrusts that the motors make there, and
is held over the tick. Off, none of it is in the tick.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.rotations import rotation_from_quaternion
from skylimb.robots.model import Robot
from skylimb.simulation.plant_config import PlantConfig
from skylimb.simulation.surfaces import Surface
from skylimb.symbolic import Array


class AirNumbers(NamedTuple):
    """Numbers of the air in a flight: data of a traced tick.

    Attributes:
        drag: force over speed across the axis and root of thrust, N^0.5 s/m.
        loss: share of its thrust that a rotor loses, its radius away from the wall.
        pull: share of its thrust by which it is drawn toward the wall there.
        radii: of the discs, m, (n,).
        into: unit vector into the wall, W, (3,).
        at: where the wall is along that, m.
    """

    drag: float | Array
    loss: float | Array
    pull: float | Array
    radii: Array
    into: Array
    at: float | Array


def air_numbers(robot: Robot, surface: Surface, config: PlantConfig) -> AirNumbers | None:
    """Numbers of the air; None where it does nothing.

    Args:
        robot: that really flies.
        surface: the wall, as the plane of its place.
        config: what of the air there is (`skylimb.simulation.plant_config.require_air`).
    """
    if not (config.rotor_drag or config.wall_loss or config.wall_pull):
        return None
    into = surface.R_WS[:, 0]
    return AirNumbers(
        config.rotor_drag * math.sqrt(robot.mass / (robot.n_rotors * robot.description.gravity)),
        config.wall_loss,
        config.wall_pull,
        np.array([rotor.radius or 0.0 for rotor in robot.description.rotors]),
        into,
        float(into @ np.array(surface.position)),
    )


def air_forces(
    robot: Robot, numbers: AirNumbers, thrusts: Array, root: Array, joint_angles: Array, rates: Array
) -> Array:
    """Generalised forces of the air on a flying robot.

    Args:
        robot: that really flies.
        numbers: of the air.
        thrusts: of the rotors, N, (n,).
        root: pose and twist of the root link, (13,); twist as (v in W, omega in the link).
        joint_angles: of shape joints, then of vectoring joints, (nq + nv,) rad.
        rates: of these joints, rad/s.

    Returns:
        (6 + nq + nv,): force on the root in W, N, torque on it in its axes, then on the joints, N m.
    """
    angles = ca.SX.sym("angles", len(robot.description.moving_joints))
    here = robot.posed(*ca.vertsplit(angles, [0, robot.n_joints, angles.numel()]))
    R_WB, omega = rotation_from_quaternion(root[3:7]), root[10:13]
    speed, into = R_WB.T @ root[7:10], R_WB.T @ numbers.into
    force, torque, joints = ca.SX(3, 1), ca.SX(3, 1), ca.SX(angles.numel(), 1)
    for index, (axis, hub) in enumerate(zip(*here.thrust_lines(ca.SX(3, 1)), strict=True)):
        thrust = ca.fmax(thrusts[index], 0.0)
        velocity = speed + ca.cross(omega, hub) + ca.jtimes(hub, angles, rates)
        across = velocity - ca.dot(axis, velocity) * axis
        away = numbers.at - ca.dot(numbers.into, root[0:3]) - ca.dot(into, hub)
        # A disc is not nearer than it is wide: what would be behind the wall is beside it.
        near = (numbers.radii[index] / ca.fmax(away, ca.fmax(numbers.radii[index], _NOTHING))) ** 2
        pushed = near * thrust * (numbers.pull * into - numbers.loss * axis)
        pushed -= numbers.drag * ca.sqrt(thrust) * across
        force += pushed
        torque += ca.cross(hub, pushed)
        joints += ca.jtimes(hub, angles, pushed, True)
    found = ca.vertcat(R_WB @ force, torque, joints)
    return ca.substitute(found, angles, joint_angles)


_NOTHING = 1e-9
"""Stands for a radius of zero where something is divided by it, m."""
