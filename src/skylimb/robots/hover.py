"""Whether rotors can carry a robot in a posture, whatever the control does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca
import numpy as np

from skylimb.robots.model import Robot

LEVEL = 5e-3
"""Tilt up to which a hover counts as level, rad."""

TILTED = 1.0
"""Greatest tilt of the root link in a hover that is not level, rad."""

_STARTS = 12
_ITERATIONS = 200
_UNLIMITED = 1e9


@dataclass(frozen=True, eq=False)
class Hover:
    """The steadiest hover that was found in one posture.

    Attributes:
        margin: least distance of a thrust to one of its limits, as a share of its range (0 .. 0.5).
        thrusts: (n,), N.
        vectoring_angles: (nv,), within their limits, rad.
        tilt: angle between the net thrust and z of the root link, rad.
    """

    margin: float
    thrusts: np.ndarray
    vectoring_angles: np.ndarray
    tilt: float


def find_hover(robot: Robot, joint_angles: np.ndarray, *, least_thrust: bool = True) -> Hover | None:
    """The hover with the greatest margin of thrust: level where that is possible, tilted where it must be.

    A small nonlinear program over vectoring angles, thrusts and margin, with exact derivatives, from several
    starts that are the same every time:

        maximise h   subject to   torque = 0,  |force| = m g,  tilt <= limit,
        thrust_min + h range <= thrusts <= thrust_max - h range,  psi within the joint limits.

    Args:
        robot: any robot with rotors; fewer than four are allowed.
        joint_angles: (nq,) the posture, rad.
        least_thrust: whether rotors keep thrust_min; else they may stand still.

    Returns:
        None where no start leads to a hover with all thrusts within their limits.
    """
    hovers = find_hovers(robot, joint_angles, least_thrust=least_thrust)
    return max(hovers, key=lambda hover: hover.margin, default=None)


def find_hovers(robot: Robot, joint_angles: np.ndarray, *, least_thrust: bool = True) -> list[Hover]:
    """Every local optimum that the starts of `find_hover` lead to; tilted ones where none is level."""
    program = _Program(robot, joint_angles, least_thrust)
    return list(program.solutions(LEVEL)) or list(program.solutions(TILTED))


def can_hover(robot: Robot, joint_angles: np.ndarray, *, least_thrust: bool = True) -> bool:
    """Whether `find_hover` finds one; the first that it meets will do."""
    program = _Program(robot, joint_angles, least_thrust)
    return any(next(program.solutions(tilt), None) is not None for tilt in (LEVEL, TILTED))


def golden_steps(n: int) -> np.ndarray:
    """Steps (n,) of a low-discrepancy sequence in n dimensions, in turns.

    They are powers of 1 / x for the root of x^(n + 1) = x + 1, which is the golden ratio for n = 1.
    """
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (n + 1))
    return root ** -np.arange(1, n + 1)


def within_limits(robot: Robot, angles: np.ndarray) -> np.ndarray:
    """Vectoring angles (..., nv) in rad, those of limited joints folded into their limits.

    A whole turn is the same angle, so it is taken off first. What still lies outside is reflected at the
    limits.
    """
    lower, upper = robot.vectoring_limits()
    folded = np.array(angles, dtype=float)
    for i in np.flatnonzero(np.isfinite(lower) & np.isfinite(upper)):
        turned = (folded[..., i] + math.pi) % (2.0 * math.pi) - math.pi
        away = (turned - lower[i]) % (2.0 * (upper[i] - lower[i]))
        folded[..., i] = lower[i] + np.minimum(away, 2.0 * (upper[i] - lower[i]) - away)
    return folded


class _Program:
    """The nonlinear program of `find_hover` in one posture."""

    def __init__(self, robot: Robot, joint_angles: np.ndarray, least_thrust: bool) -> None:
        self._robot = robot
        rotors = robot.description.rotors
        n, nv = robot.n_rotors, robot.n_vectoring
        low = np.array([rotor.thrust_min if least_thrust else 0.0 for rotor in rotors])
        high = np.array([rotor.thrust_max for rotor in rotors])
        weight = robot.weight
        psi, thrusts, margin = ca.SX.sym("psi", nv), ca.SX.sym("thrusts", n), ca.SX.sym("margin")
        wrench = robot.wrench_function(ca.DM(joint_angles), psi) @ thrusts / weight
        force, torque = wrench[:3], wrench[3:]
        spare = margin * (high - low)
        self._solver = ca.nlpsol(
            "hover",
            "ipopt",
            {
                "x": ca.vertcat(psi, thrusts, margin),
                "f": -margin,
                "g": ca.vertcat(
                    torque, ca.sumsqr(force), force, (thrusts - spare - low) / high, (thrusts + spare) / high
                ),
            },
            {
                "ipopt.print_level": 0,
                "print_time": False,
                "ipopt.sb": "yes",
                "ipopt.max_iter": _ITERATIONS,
                "ipopt.max_wall_time": 1.0,
            },
        )
        lower, upper = robot.vectoring_limits()
        free_low, free_high = [-_UNLIMITED] * 2, [_UNLIMITED] * 2
        self._bounds = {
            "lbx": [*np.maximum(lower, -_UNLIMITED), *np.zeros(n), -1.0],
            "ubx": [*np.minimum(upper, _UNLIMITED), *high, 0.5],
        }
        self._low = [0.0, 0.0, 0.0, 1.0, *free_low, 0.0, *np.zeros(n), *np.full(n, -np.inf)]
        self._high = [0.0, 0.0, 0.0, 1.0, *free_high, np.inf, *np.full(n, np.inf), *np.ones(n)]
        self._share = weight / max(float(high.sum()), 1e-9) * high

    def solutions(self, tilt: float) -> Iterator[Hover]:
        """Where the starts lead, with at most that tilt (rad)."""
        nv, n = self._robot.n_vectoring, self._robot.n_rotors
        low, high = list(self._low), list(self._high)
        # |force| = 1 already, so one bound on its vertical part holds the tilt.
        low[6], sideways = math.cos(tilt), math.sin(tilt)
        low[4:6], high[4:6] = [-sideways] * 2, [sideways] * 2
        start = self._robot.description.vectoring_start
        starts = start + 2.0 * np.pi * np.outer(np.arange(_STARTS if nv else 1), golden_steps(nv))
        for psi in within_limits(self._robot, starts):
            solution = self._solver(x0=[*psi, *self._share, 0.0], lbg=low, ubg=high, **self._bounds)
            x = solution["x"].full().ravel()
            if self._solver.stats()["success"] and x[-1] > 0.0:
                g = solution["g"].full().ravel()
                leant = float(np.arctan2(np.hypot(g[4], g[5]), g[6]))
                yield Hover(float(x[-1]), x[nv : nv + n], x[:nv], leant)
