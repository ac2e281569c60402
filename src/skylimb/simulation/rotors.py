"""Rotors that have a speed and an inertia: what their motors can follow, and how they turn the robot.

Thrust is that of the rotor's speed, T = k Omega^2, and the speed follows its command with the rotor's lag, as
far as the motor's torque

    J dOmega/dt + |kappa| T

allows, in both directions: a motor brakes as hard as it drives. The body that carries the rotor feels the
change of the rotor's angular momentum, -d(spin J Omega z)/dt: the reaction to its acceleration about the axis
z, and across it the gyroscopic torque -omega x spin J Omega z. The drag's own torque is the actuator's
(eq:allocation for torque).

All of it is worked out at the beginning of a control tick, from then on exactly for the tick's mean
acceleration; the torques are held over the tick.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from skylimb.robots.description import RobotDescription
from skylimb.robots.kinematics import joint_axis
from skylimb.robots.model import Robot
from skylimb.symbolic import Array


class RotorNumbers(NamedTuple):
    """Numbers of the rotors in a flight, (n,) each: data of a traced tick.

    Attributes:
        decay: what is left of a difference of speeds after a control period.
        thrust_factor: k, N s^2.
        inertia: J about the axis, kg m^2.
        torque: greatest torque of the motor, N m.
        drag: |kappa|, m.
        speed: that of the greatest thrust, rad/s.
    """

    decay: Array
    thrust_factor: Array
    inertia: Array
    torque: Array
    drag: Array
    speed: Array


class RotorTick(NamedTuple):
    """What the rotors do in a control tick, (n,) each.

    Attributes:
        controls: of the engine's first-order filters, N, with which their thrusts end where the speeds do.
        speeds: at its beginning, rad/s.
        accelerations: their mean, rad/s^2.
        mean_speeds: rad/s.
        motor_torques: their mean, N m.
    """

    controls: Array
    speeds: Array
    accelerations: Array
    mean_speeds: Array
    motor_torques: Array


def rotor_numbers(description: RobotDescription, dt: float) -> RotorNumbers:
    """The rotors of a description as numbers of a flight with control period `dt` (s).

    The description says inertia and thrust factor of each (`skylimb.simulation.plant_config.require_plant`).
    """
    columns = [
        (
            np.exp(-dt / rotor.lag) if rotor.lag > 0.0 else 0.0,
            rotor.thrust_factor,
            rotor.inertia,
            rotor.torque_max,
            abs(rotor.drag_torque_coefficient),
            np.sqrt(rotor.thrust_max / rotor.thrust_factor),
        )
        for rotor in description.rotors
        if rotor.thrust_factor is not None
    ]
    return RotorNumbers(*np.array(columns, dtype=float).T)


def rotor_tick(numbers: RotorNumbers, thrusts: Array, commanded: Array, dt: float) -> RotorTick:
    """A control tick of the rotors.

    Args:
        numbers: of the rotors.
        thrusts: now, (n,) N.
        commanded: (n,) N.
        dt: control period, s.
    """
    k, inertia = numbers.thrust_factor, ca.fmax(numbers.inertia, _NO_INERTIA)
    speeds = ca.sqrt(ca.fmax(thrusts, 0.0) / k)
    wanted = ca.fmin(ca.sqrt(ca.fmax(commanded, 0.0) / k), numbers.speed)
    free = (wanted - speeds) * (1.0 - numbers.decay) * (1.0 / dt)

    def within(speed: Array) -> Array:
        """The acceleration that the motor can give where drag is that of this speed."""
        drag = numbers.drag * k * speed**2
        return ca.fmin(ca.fmax(free, (-numbers.torque - drag) / inertia), (numbers.torque - drag) / inertia)

    # The drag in the middle of the tick, so that the error is of second order in its length.
    middle = speeds + 0.5 * dt * within(speeds)
    ends = ca.fmax(speeds + dt * within(middle), 0.0)
    accelerations = (ends - speeds) * (1.0 / dt)
    drags = numbers.drag * k * (speeds**2 + speeds * ends + ends**2) * (1.0 / 3.0)
    return RotorTick(
        controls=(k * ends**2 - thrusts * numbers.decay) / (1.0 - numbers.decay),
        speeds=speeds,
        accelerations=accelerations,
        mean_speeds=0.5 * (speeds + ends),
        motor_torques=numbers.inertia * accelerations + drags,
    )


_NO_INERTIA = 1e-12
"""Stands for an inertia of zero where something is divided by it, kg m^2."""


def momentum_forces(
    robot: Robot, numbers: RotorNumbers, tick: RotorTick, joint_angles: Array, rates: Array
) -> Array:
    """Generalised forces by the change of the rotors' angular momentum: -d(spin J Omega z)/dt of each.

    Args:
        robot: where the rotors sit.
        numbers: of the rotors.
        tick: what they do.
        joint_angles: of shape joints, then of vectoring joints, (nq + nv,) rad.
        rates: angular velocity of the root in its axes, then of these joints, (3 + nq + nv,) rad/s.

    Returns:
        (3 + nq + nv,): torque on the root in its axes, then on the joints, N m.
    """
    names = robot.description.moving_joints
    here = robot.posed(*ca.vertsplit(joint_angles, [0, robot.n_joints, len(names)]))
    poses, turns = here.poses, here.turns(rates[:3], rates[3:])
    at = {index: names.index(body.joint.name) for index, body in enumerate(robot.bodies) if body.joint}
    torques = [ca.SX(3, 1) for _ in robot.bodies]
    for index, rotor in enumerate(robot.description.rotors):
        place = robot.placements[rotor.link]
        axis = poses[place.body].turned(place.R @ rotor.R[:, 2])
        across = ca.cross(turns[place.body], axis)
        change = tick.accelerations[index] * axis + tick.mean_speeds[index] * across
        torques[place.body] -= rotor.spin * numbers.inertia[index] * change
    # From the ends of the tree on, each body hands its torque to the one that carries it.
    joints = ca.SX(len(names), 1)
    for index in range(len(robot.bodies) - 1, 0, -1):
        joints[at[index]] = ca.dot(joint_axis(robot.bodies[index], poses[index]), torques[index])
        torques[robot.bodies[index].parent] += torques[index]
    return ca.vertcat(torques[0], joints)
