"""Rotors that change their speed, as the allocation knows them: the torque by it, and what motors can follow.

A rotor that gains thrust gains speed and turns its body the other way (`robots.reaction`). Thrusts T that
close on their wanted ones T_w at a rate r give the wrench

    Q T_w + r G (T_w - T),    G_i = -spin_i J_i / (2 k_i Omega_i) (0, z_i),

and the wanted ones are chosen for it. A servo that turns a rotor turns its whole angular momentum: the side
of a pair (`robots.turned_rotors`) has twice that gain, at the speed of its rotor. Thrusts of pairs are chosen
for that alone: sides that answer the motors' reaction, and thrusts that answer the sides', end in zeros that
are hardly damped (at 14 to 18 rad/s, docs/reports/robots.md), and flights are lost. Where lift and torque
have a slow unstable zero all of this would run away, so such a robot is refused before take-off
(`flight.feasible`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.control.estimation.records import BodyState
from skylimb.robots.description import Rotor
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, clip, diagonal, sqrt, vector

_LEAST = 0.5
"""Stands for the thrust of a rotor that hardly turns, N: its reaction per thrust has no limit."""

_TORQUE_ROWS = np.vstack([np.zeros((3, 3)), np.eye(3)])


class Reaction(NamedTuple):
    """The wrench of thrusts by how fast they close on their wanted ones.

    Attributes:
        matrix: r G in {C}, (6, n); torque rows in m.
        thrusts: T now, N, (n,).
    """

    matrix: Array
    thrusts: Array


def reaction(robot: Robot, body: BodyState, thrusts: Array, rate: Any) -> Reaction:
    """What rotors do by their reaction, of pairs their sides; nothing where the robot's files say no inertia.

    Args:
        robot: with the rotors.
        body: at the measured angles.
        thrusts: now, N, (n,).
        rate: at which they close on their wanted ones, 1/s; one for all, or one for each.
    """
    motors = all(rotor.side is None for rotor in robot.description.rotors)
    gains: list[Any] = []
    for index, (rotor, inertia, factor) in enumerate(_turning(robot)):
        if motors:
            gains.append(
                -rotor.spin * rate * inertia / (2.0 * factor * _speed(thrusts[index], rotor, factor))
            )
        elif rotor.side is None:
            gains.append(0.0)
        else:
            speed = _speed(thrusts[rotor.side.of], rotor, factor)
            gains.append(-rotor.spin * rate[index] * inertia / (factor * speed))
    axes = body.model.allocation_C[0:3, :]
    return Reaction(_TORQUE_ROWS @ (axes @ diagonal(vector(*gains))), thrusts)


def reaction_torque(robot: Robot, body: BodyState, before: Array, after: Array, dt: float) -> Array:
    """Mean torque over a tick by rotors that change their speed, -sum spin J dOmega/dt z, C, N m, (3,).

    Args:
        robot: with the rotors.
        body: at the measured angles.
        before: thrusts at the beginning of the tick, N, (n,).
        after: thrusts at its end, N, (n,).
        dt: its length, s.
    """
    torques = []
    for index, (rotor, inertia, factor) in enumerate(_turning(robot)):
        if rotor.side is None:
            change = _speed(after[index], rotor, factor) - _speed(before[index], rotor, factor)
        else:
            speed = _speed(before[rotor.side.of], rotor, factor)
            change = (after[index] - before[index]) / (factor * speed)
        torques.append(-rotor.spin * inertia * change * (1.0 / dt))
    return body.model.allocation_C[0:3, :] @ vector(*torques)


def motor_limits(robot: Robot, thrusts: Array, time_constant: Any) -> tuple[Array, Array]:
    """Least and greatest command that the motors' torque can follow now, N, (n,) each.

    A command Omega_c takes J (Omega_c - Omega) / tau beside the drag |kappa| T.

    Args:
        robot: with the rotors.
        thrusts: now, N, (n,).
        time_constant: tau of the lag, s.
    """
    least, most = [], []
    for index, (rotor, inertia, factor) in enumerate(_turning(robot)):
        speed, drag = _speed(thrusts[index], rotor, factor), abs(rotor.drag_torque_coefficient)
        most_speed = (rotor.thrust_max / factor) ** 0.5
        for kept, sign in ((least, -1.0), (most, 1.0)):
            if not inertia or not np.isfinite(rotor.torque_max):
                kept.append(rotor.thrust_min if sign < 0.0 else rotor.thrust_max)
                continue
            change = (sign * rotor.torque_max - drag * thrusts[index]) * time_constant / inertia
            command = factor * clip(speed + change, 0.0, most_speed) ** 2
            kept.append(clip(command, rotor.thrust_min, rotor.thrust_max))
    return vector(*least), vector(*most)


def _turning(robot: Robot) -> list[tuple[Rotor, float, float]]:
    """The rotors with inertia (kg m^2) and thrust factor (N s^2); no inertia where the files say none."""
    return [
        (rotor, (rotor.inertia or 0.0) if rotor.thrust_factor else 0.0, rotor.thrust_factor or 1.0)
        for rotor in robot.description.rotors
    ]


def _speed(thrust: Any, rotor: Rotor, factor: float) -> Any:
    return sqrt(clip(thrust, _LEAST, rotor.thrust_max) * (1.0 / factor))
