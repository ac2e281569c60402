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

from skylimb.base.packing import Layout
from skylimb.robots.kinematics import composite
from skylimb.robots.model import Robot
from skylimb.symbolic import cross

_BLOCK = 256


class Mechanics(NamedTuple):
    """The model at one tick, root link's axes.

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


def layout(rotors: int) -> Layout[Mechanics]:
    """Where each part stands in a flat row, for a robot with so many rotors."""
    by_rotor = np.zeros((3, rotors))
    return Layout(Mechanics(np.zeros(3), np.zeros(3), by_rotor, by_rotor, np.zeros((3, 3)), np.zeros(3)))


def root_mass(robot: Robot) -> tuple[float, np.ndarray]:
    """Mass of the root link, kg, and its centre of mass in its own axes, m, (3,)."""
    inertial = robot.description.link(robot.description.root).inertial
    return inertial.mass, inertial.com


@functools.lru_cache(maxsize=8)
def _function(robot: Robot) -> ca.Function:
    """(angles, rates) -> the flat mechanics, over a block of ticks."""
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    angles, rates = ca.vertcat(q, psi), ca.SX.sym("rates", robot.n_joints + robot.n_vectoring)
    here, mass, momentum = robot.posed(q, psi), robot.mass, ca.SX.zeros(3)
    cog, inertia = composite(robot.bodies, here.poses)
    for body, pose, spin in zip(robot.bodies, here.poses, here.turns(ca.SX(3, 1), rates), strict=True):
        centre, R = pose.point(body.com), pose.turned(np.eye(3))
        speed = ca.jacobian(centre, angles) @ rates
        momentum += body.mass * cross(centre - cog, speed) + R @ body.inertia @ R.T @ spin
    by_rotor = robot.wrench_function(q, psi)
    made = Mechanics(
        cog,
        ca.jacobian(cog, angles) @ rates,
        by_rotor[:3, :],
        by_rotor[3:, :],
        (0.5 * ca.trace(inertia) * ca.SX.eye(3) - inertia) / mass,
        momentum / mass,
    )
    flat = ca.densify(layout(robot.n_rotors).pack(made))
    return ca.Function("mechanics", [angles, rates], [flat], {"cse": True}).map(_BLOCK)


def mechanics(robot: Robot, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """The mechanics along a log, a flat row a tick; see `layout`.

    Args:
        robot: as it is described.
        angles: of shape and vectoring joints, rad, (k, nq + nv).
        rates: rad/s, (k, nq + nv).
    """
    function, count = _function(robot), len(angles)
    missing = -count % _BLOCK
    padded = (np.pad(values, ((0, missing), (0, 0))).T for values in (angles, rates))
    blocks = zip(*(np.split(values, (count + missing) // _BLOCK, axis=1) for values in padded), strict=True)
    return np.concatenate([function(*block).full() for block in blocks], axis=1).T[:count]
