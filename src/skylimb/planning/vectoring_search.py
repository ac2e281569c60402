"""Search for vectoring angles psi(theta): most guaranteed control torque, no hover tilt, one smooth branch.

Optimising psi anew at every theta jumps between branches (near theta = 0.3 for the paper's robot, with slopes
of 8 rad/rad). So psi(theta) is one low-degree polynomial for each joint, and a single program finds all
coefficients:

    maximise   mean over theta of FCTmin  -  SMOOTHING * mean of |dpsi/dtheta|^2
    subject to |hover tilt| <= TILT, |dpsi_i/dtheta| <= SLOPE, thrust_min <= hover thrusts <= thrust_max
               at nodes spread over theta.

The program has many local optima. It starts from the optima of single postures, first with few coefficients,
and the best few of those are refined with all of them. Every start is fixed, so the result is always the
same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.polynomial import chebyshev

from skylimb.errors import AllocationError
from skylimb.planning.control_torque import face_distances
from skylimb.robots import Robot
from skylimb.robots.flight_check import golden_steps

DEGREE = 7
"""Degree of the polynomial of each joint."""

SMOOTHING = 0.03
"""Guaranteed torque given up for a smoother path, N m per (rad/rad)^2."""

SLOPE = 1.95
"""Greatest slope at the nodes, rad/rad."""

TILT = 5e-4
"""Greatest hover tilt in roll and in pitch at the nodes, rad."""

VERSION = 1
"""Counts up when the search changes, so that tables found by an older one are not used."""

_ROUNDING = 1e-4
_COARSE_DEGREE = 3
_REFINED = 3
_TRIES = 16
_SAME = 0.1


@dataclass(frozen=True)
class _Posture:
    """What a posture theta with vectoring angles psi gives: face distances, hover tilt (2), hover thrusts."""

    function: ca.Function
    n_faces: int
    thrust_min: np.ndarray
    thrust_max: np.ndarray


def search_vectoring(robot: Robot) -> np.ndarray:
    """Chebyshev coefficients (n_vectoring, DEGREE + 1) of psi over the described range of theta, rad.

    Raises:
        AllocationError: no continuous path of vectoring angles hovers without tilt over the range.
    """
    if robot.n_vectoring == 0:
        return np.zeros((0, DEGREE + 1))
    posture = _posture_function(robot)
    coarse = _PathProgram(robot, posture, _COARSE_DEGREE, 9, 80)
    paths = [coarse.solve(start) for start in _starts(robot, posture)]
    ranked = sorted((path for path in paths if path is not None), key=lambda path: path[0], reverse=True)
    distinct: list[tuple[float, np.ndarray]] = []
    for path in ranked:
        if all(np.max(np.abs(_wrap(path[1][:, 0] - other[1][:, 0]))) > _SAME for other in distinct):
            distinct.append(path)
    fine = _PathProgram(robot, posture, DEGREE, 24, 150)
    refined = [fine.solve(coefficients) for _, coefficients in distinct[:_REFINED]]
    best = max((path for path in refined if path is not None), key=lambda path: path[0], default=None)
    if best is None:
        raise AllocationError(
            f"no continuous vectoring angles of '{robot.name}' hover without tilt from theta = "
            f"{robot.description.posture.theta_min:g} to {robot.description.posture.theta_max:g} rad"
        )
    return _near_zero(robot, best[1])


def evaluate(coefficients: np.ndarray, low: float, high: float, theta: Any, order: int = 0) -> np.ndarray:
    """The polynomials (or a derivative by theta of some order) at an array of theta: (..., nv)."""
    x = (2.0 * np.asarray(theta, dtype=float) - (low + high)) / (high - low)
    series = chebyshev.chebder(coefficients, order, axis=1) * (2.0 / (high - low)) ** order
    return np.moveaxis(chebyshev.chebval(x, series.T), 0, -1)


def _wrap(angle: np.ndarray) -> np.ndarray:
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def _near_zero(robot: Robot, coefficients: np.ndarray) -> np.ndarray:
    """The same path, whole turns away: at the nominal posture each joint is within half a turn of zero."""
    posture = robot.description.posture
    nominal = evaluate(coefficients, posture.theta_min, posture.theta_max, posture.theta_nominal)
    moved = coefficients.copy()
    moved[:, 0] += _wrap(nominal) - nominal
    return moved


def _posture_function(robot: Robot) -> _Posture:
    family, rotors = robot.description.posture, robot.description.rotors
    theta = ca.SX.sym("theta")
    psi = ca.SX.sym("psi", robot.n_vectoring)
    state = robot.model(ca.DM(family.offset) + ca.DM(family.slope) * theta, psi)
    thrust_max = [rotor.thrust_max for rotor in rotors]
    faces = face_distances(state.allocation_C[3:, :], thrust_max, _ROUNDING)
    function = ca.Function("posture", [theta, psi], [faces, state.R_root_C[:2, 2], state.hover_thrusts])
    thrust_min = np.array([rotor.thrust_min for rotor in rotors])
    return _Posture(function, faces.shape[0], thrust_min, np.array(thrust_max))


def _bounds(posture: _Posture) -> tuple[list[float], list[float]]:
    """Of the constraints at one posture: faces - t, tilt, thrusts."""
    low = [0.0] * posture.n_faces + [-TILT] * 2 + posture.thrust_min.tolist()
    high = [np.inf] * posture.n_faces + [TILT] * 2 + posture.thrust_max.tolist()
    return low, high


def _solver(problem: dict[str, Any], iterations: int) -> ca.Function:
    quiet = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.max_iter": iterations}
    return ca.nlpsol("vectoring", "ipopt", problem, quiet)


def _starts(robot: Robot, posture: _Posture) -> list[np.ndarray]:
    """Distinct local optima of psi at single postures, best first at each."""
    family, n = robot.description.posture, robot.n_vectoring
    psi, t, theta = ca.SX.sym("psi", n), ca.SX.sym("t"), ca.SX.sym("theta")
    faces, tilt, thrusts = posture.function(theta, psi)
    problem = {"x": ca.vertcat(psi, t), "p": theta, "f": -t, "g": ca.vertcat(faces - t, tilt, thrusts)}
    solver = _solver(problem, 100)
    low, high = _bounds(posture)
    steps = np.outer(np.arange(_TRIES), golden_steps(n))
    tries = robot.description.vectoring_start + 2.0 * np.pi * steps
    found: list[np.ndarray] = []
    for angle in np.linspace(family.theta_min, family.theta_max, 4):
        optima = []
        for start in tries:
            solution = solver(x0=[*start, 1.0], p=angle, lbg=low, ubg=high)
            if solver.stats()["success"]:
                x = solution["x"].full().ravel()
                optima.append((float(x[n]), _wrap(x[:n])))
        for _, candidate in sorted(optima, key=lambda optimum: optimum[0], reverse=True):
            if all(np.max(np.abs(_wrap(candidate - other))) > _SAME for other in found):
                found.append(candidate)
    return found


class _PathProgram:
    """The program for whole paths psi(theta) of one degree, at Chebyshev nodes and both ends."""

    def __init__(self, robot: Robot, posture: _Posture, degree: int, nodes: int, iterations: int) -> None:
        family = robot.description.posture
        self.degree, self.n = degree, robot.n_vectoring
        low, high = family.theta_min, family.theta_max
        x = np.concatenate([[-1.0], chebyshev.chebpts1(nodes), [1.0]])
        self.nodes = len(x)
        half = 0.5 * (high - low)
        values = chebyshev.chebvander(x, degree)
        slopes = chebyshev.chebval(x, chebyshev.chebder(np.eye(degree + 1))).T / half
        coefficients = ca.SX.sym("c", self.n, degree + 1)
        t = ca.SX.sym("t", self.nodes)
        psi, slope = coefficients @ ca.DM(values.T), coefficients @ ca.DM(slopes.T)
        constraints, self._low, self._high = [], [], []
        at_low, at_high = _bounds(posture)
        for k in range(self.nodes):
            faces, tilt, thrusts = posture.function(low + half * (1.0 + x[k]), psi[:, k])
            constraints += [faces - t[k], tilt, thrusts, slope[:, k]]
            self._low += at_low + [-SLOPE] * self.n
            self._high += at_high + [SLOPE] * self.n
        gain = ca.sum1(t) - SMOOTHING * ca.sumsqr(slope)
        problem = {
            "x": ca.vertcat(ca.vec(coefficients), t),
            "f": -gain / self.nodes,
            "g": ca.vertcat(*constraints),
        }
        self._solver = _solver(problem, iterations)

    def solve(self, start: Sequence[float] | np.ndarray) -> tuple[float, np.ndarray] | None:
        """Gain and coefficients (n, degree + 1) from a start, (n,) or (n, fewer); None without success."""
        start = np.asarray(start, dtype=float).reshape(self.n, -1)
        first = np.zeros((self.n, self.degree + 1))
        first[:, : start.shape[1]] = start
        x0 = np.concatenate([first.ravel(order="F"), np.full(self.nodes, 1.0)])
        solution = self._solver(x0=x0, lbg=self._low, ubg=self._high)
        if not self._solver.stats()["success"]:
            return None
        size = self.n * (self.degree + 1)
        found = solution["x"].full().ravel()[:size].reshape(self.n, -1, order="F")
        return -float(solution["f"]), found
