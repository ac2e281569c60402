"""What a robot with its angles held can do at rest, by linear programmes over its thrusts (HiGHS)."""

import itertools
import math

import numpy as np
from scipy.optimize import linprog

from skylimb.base.rotations import rot_x, rot_y, rot_z
from skylimb.robots.equilibrium_results import TILT, Held
from skylimb.robots.model import Robot

UP = np.array([0.0, 0.0, 1.0])


def limits(robot: Robot) -> np.ndarray:
    return np.array([[rotor.thrust_min, rotor.thrust_max] for rotor in robot.description.rotors])


def push_at(robot: Robot, q: np.ndarray, psi: np.ndarray, along: np.ndarray, lean: np.ndarray) -> float:
    """The greatest push with a lean given, joints and vectoring angles as they are; -1 without any rest.

    A millionth of the weight may be left over: at a corner of the limits only one lean is exact.
    """
    return Pushes(robot, q, psi, along).at(lean)


class Pushes:
    """Linear programmes of one posture, for any lean."""

    def __init__(self, robot: Robot, q: np.ndarray, psi: np.ndarray, along: np.ndarray) -> None:
        state, self._matrix = robot.at(q, psi), robot.wrench_function(q, psi).full()
        self._along, self._lever = rot_z(state.tip_heading) @ along, state.tip_root - state.cog_root
        self._weight, self._limits, self._over = robot.weight * UP, limits(robot), 1e-6 * robot.weight
        self._duals = np.vstack([np.eye(6), -np.eye(6)])  # to begin with

    def at(self, lean: np.ndarray) -> float:
        """The greatest push with a lean; -1 without any rest."""
        push, given = self._balance(lean)
        n = len(self._limits)
        found = linprog(
            np.concatenate([np.zeros(n), [-1.0], np.zeros(6)]),
            A_eq=np.column_stack([self._matrix, -push, np.eye(6)]),
            b_eq=given,
            bounds=[*self._limits, (0.0, None), *[(-self._over, self._over)] * 6],
        )
        if found.status != 0:
            return -1.0
        made = float(found.x[n])
        assert made <= self.at_most(lean) + self._over
        self._duals = np.vstack([self._duals, found.eqlin.marginals, -found.eqlin.marginals])
        return made

    def at_most(self, lean: np.ndarray) -> float:
        """What no push with a lean is beyond: multipliers of any other programme bound this one as well.

        y (A thrusts + rest - p t) = y b for every y, so t y p <= max of y (A thrusts + rest), less y b.
        """
        push, given = self._balance(lean)
        # Few rotors and the push leave directions in which nothing balances the weight.
        bare = np.linalg.svd(np.column_stack([self._matrix, push]))[0][:, len(self._limits) + 1 :].T
        y = np.vstack([self._duals, bare, -bare])
        of_thrusts = y @ self._matrix
        most = np.maximum(of_thrusts * self._limits[:, 0], of_thrusts * self._limits[:, 1]).sum(axis=1)
        most += self._over * np.abs(y).sum(axis=1) - y @ given
        along = y @ push
        if np.any((along > -1e-12) & (most < 0.0)):
            return -1.0
        return float(np.min(most[along > 0.0] / along[along > 0.0], initial=np.inf))

    def _balance(self, lean: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force and torque of a push of 1 N, and what carries the weight, (6,) each."""
        back = (rot_y(lean[1]) @ rot_x(lean[0])).T
        p = back @ self._along
        return np.concatenate([p, np.cross(self._lever, p)]), np.concatenate(
            [back @ self._weight, np.zeros(3)]
        )


def best_over_leans(
    robot: Robot, q: np.ndarray, psi: np.ndarray, along: np.ndarray, near: np.ndarray
) -> float:
    """The best of linear programmes over a grid of leans, ever finer about the best; from `near` on."""
    pushes = Pushes(robot, q, psi, along)
    best, at = pushes.at(near), near
    for reach in (0.35, 0.1, 0.02, 4e-3):
        around = at
        for lean in itertools.product(np.linspace(-reach, reach, 7), repeat=2):
            tried = around + lean
            if np.prod(np.cos(tried)) >= np.cos(TILT) and pushes.at_most(tried) > best:
                push = pushes.at(tried)
                best, at = (push, tried) if push > best else (best, at)
    return best


def lean_of(robot: Robot, found: Held, q: np.ndarray, psi: np.ndarray) -> np.ndarray:
    """Roll and pitch of a rest, from where its thrusts point."""
    state = robot.at(q, psi)
    force = robot.wrench_function(q, psi).full()[:3] @ found.thrusts
    # R_y(pitch) R_x(roll) force = m g z + p, whose y part is that of the roll alone.
    wanted = robot.weight * UP + rot_z(state.tip_heading) @ found.push
    roll = math.acos(wanted[1] / math.hypot(*force[1:])) - math.atan2(force[2], force[1])
    rolled = rot_x(roll) @ force
    return np.array([roll, math.atan2(wanted[0], wanted[2]) - math.atan2(rolled[0], rolled[2])])


def margin_at(robot: Robot, q: np.ndarray, psi: np.ndarray, lean: np.ndarray) -> float:
    """The torque that is left about any axis in the best hover with a lean given, N m; -1 without a hover.

    A millionth of the weight may be left over, as for a push.
    """
    n, matrix = robot.n_rotors, robot.wrench_function(q, psi).full()
    back = (rot_y(lean[1]) @ rot_x(lean[0])).T
    rows = np.linalg.norm(np.linalg.pinv(matrix[2:])[:, 1:], axis=1)
    low, high = limits(robot).T
    over = 1e-6 * robot.weight
    found = linprog(
        np.concatenate([np.zeros(n), [-1.0], np.zeros(6)]),
        A_eq=np.column_stack([matrix, np.zeros(6), np.eye(6)]),
        b_eq=np.concatenate([back @ (robot.weight * UP), np.zeros(3)]),
        A_ub=np.block(
            [[-np.eye(n), rows[:, None], np.zeros((n, 6))], [np.eye(n), rows[:, None], np.zeros((n, 6))]]
        ),
        b_ub=np.concatenate([-low, high]),
        bounds=[(None, None)] * n + [(0.0, None)] + [(-over, over)] * 6,
    )
    return float(found.x[n]) if found.status == 0 else -1.0
