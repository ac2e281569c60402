"""The robot's mechanics along a log: all that follows from the encoders alone, as numbers at every tick.

In axes of the root link, with c the described centre of gravity:

- c and its rate c',
- the force of each rotor per newton of thrust, u_i, and its torque about c, t_i,
- the second moments S of the whole robot about c, and of the root link's own place in it,
- h, the angular momentum about c of the joints' own motion.

The true robot's centre of gravity lies d beside c because the root link's mass does, as in
`simulation.plant`. Then, with m the mass, m_r the root link's and r its centre seen from c,

    t_i - d x u_i,    S + m (r d^T + d r^T) + (m^2 / m_r - m) d d^T,    h - m d x c'.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.rotations import cross
from skylimb.robots.description import RobotDescription
from skylimb.robots.kinematics import body_poses, composite
from skylimb.robots.model import Robot

_BLOCK = 256


class Mechanics(NamedTuple):
    """The model at every tick, root link's axes; the first dimension is time, or it is missing.

    Attributes:
        cog: c, m, (3,).
        cog_rate: c', m/s, (3,).
        forces: u_i, (3, n), a row an axis.
        torques: t_i, m, (3, n).
        moments: S / m, m^2, (3, 3).
        momentum: h / m, m^2/s, (3,).
    """

    cog: Any
    cog_rate: Any
    forces: Any
    torques: Any
    moments: Any
    momentum: Any


SIZES = {"cog": (3,), "cog_rate": (3,), "moments": (3, 3), "momentum": (3,)}


def shapes(rotors: int) -> dict[str, tuple[int, ...]]:
    """Shape of each entry of `Mechanics` for a robot with so many rotors."""
    return {**SIZES, "forces": (3, rotors), "torques": (3, rotors)}


def root_mass(robot: Robot) -> tuple[float, np.ndarray]:
    """Mass of the root link, kg, and its centre of mass in its own axes, m, (3,)."""
    description: RobotDescription = robot.description
    (link,) = [link for link in description.links if link.name == description.root]
    return link.inertial.mass, np.asarray(link.inertial.com, dtype=float)


@functools.lru_cache(maxsize=8)
def _function(robot: Robot) -> ca.Function:
    """(angles, rates) -> the flat mechanics, over a block of ticks."""
    description = robot.description
    names = [*description.shape_joints, *description.vectoring_joints]
    angles, rates = ca.SX.sym("angles", len(names)), ca.SX.sym("rates", len(names))
    poses = body_poses(robot.bodies, {name: angles[i] for i, name in enumerate(names)})
    cog, inertia = composite(robot.bodies, poses)
    mass = robot.mass
    momentum = ca.SX.zeros(3)
    for body, pose in zip(robot.bodies, poses, strict=True):
        centre, R = pose.point(body.com), ca.densify(ca.SX(pose.turned(np.eye(3))))
        speed = ca.jacobian(centre, angles) @ rates
        R_rate = ca.reshape(ca.jacobian(ca.vec(R), angles) @ rates, 3, 3)
        W = R_rate @ R.T
        spin = ca.vertcat(W[2, 1], W[0, 2], W[1, 0])
        own = R @ body.inertia @ R.T
        momentum += body.mass * cross(centre - cog, speed) + own @ spin
    forces, torques = [], []
    for rotor in description.rotors:
        place = robot.placements[rotor.link]
        pose = poses[place.body]
        point = pose.point(place.xyz + place.R @ rotor.xyz)
        axis = pose.turned(place.R @ rotor.R[:, 2])
        forces.append(axis)
        torques.append(cross(point - cog, axis) + rotor.drag_torque_coefficient * axis)
    made = Mechanics(
        cog,
        ca.jacobian(cog, angles) @ rates,
        ca.horzcat(*forces),
        ca.horzcat(*torques),
        (0.5 * ca.trace(inertia) * ca.SX.eye(3) - inertia) / mass,
        momentum / mass,
    )
    # Row by row, as NumPy has it.
    flat = ca.densify(ca.vertcat(*(ca.vec(ca.SX(part).T) for part in made)))
    return ca.Function("mechanics", [angles, rates], [flat], {"cse": True}).map(_BLOCK)


def mechanics(robot: Robot, angles: np.ndarray, rates: np.ndarray) -> Mechanics:
    """The mechanics along a log.

    Args:
        robot: as it is described.
        angles: of shape and vectoring joints, rad, (k, nq + nv).
        rates: rad/s, (k, nq + nv).
    """
    function, count = _function(robot), len(angles)
    padded = -(-count // _BLOCK) * _BLOCK

    def block(values: np.ndarray, start: int) -> np.ndarray:
        rows = values[start : start + _BLOCK]
        return np.concatenate([rows, np.zeros((_BLOCK - len(rows), rows.shape[1]))]).T

    columns = [
        function(block(angles, start), block(rates, start)).full() for start in range(0, padded, _BLOCK)
    ]
    flat = np.concatenate(columns, axis=1).T[:count]
    return unpacked(flat, robot.n_rotors)


def unpacked(flat: np.ndarray, rotors: int) -> Mechanics:
    """Rows (k, size) as the named arrays."""
    sizes = shapes(rotors)
    ends = np.cumsum([int(np.prod(sizes[name])) for name in Mechanics._fields])
    parts = np.split(flat, ends[:-1], axis=1)
    return Mechanics(
        *(part.reshape(len(flat), *sizes[name]) for name, part in zip(Mechanics._fields, parts, strict=True))
    )


def packed(made: Mechanics) -> np.ndarray:
    """The named arrays as rows, (k, size)."""
    return np.concatenate([np.asarray(part).reshape(len(part), -1) for part in made], axis=1)
