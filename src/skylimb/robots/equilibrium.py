"""Can it be held? The one question about what a robot at rest can carry, and how hard its tip can push.

Joints are given as commanded. Servos are springs, so a joint rests beside its command, at q_j + tau_j / k.
Free are the lean of the body, the thrusts, moves of the vectoring angles, and where the joints come to rest:

    greatest push    maximise t   with the push t d and a margin that is kept
    margin           maximise h   with a given push

where forces and torques balance (`skylimb.base.statics`) and nothing is beyond its limit: each thrust, each
servo's torque, the tilt of the measured link from the vertical, the vectoring angles. The margin is the
torque that is left about any axis while lift and attitude are kept,

    h = min over rotors of min(lambda - lambda_min, lambda_max - lambda) / |row of A^+|,

with A the rows of C for lift and torque: exact for four rotors, for more what least-norm thrusts leave. All
limits give way together by a share e at a price that only a question without an answer pays. So one
nonlinear programme (CasADi, IPOPT) finds what can be held, says which limit ends it, and by how much what
cannot be held is beyond it. What has no answer here no control law holds in that posture. What has one may
still fail in flight, where thrust is needed for more than rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from skylimb.base.interrupts import search
from skylimb.base.rotations import rot_z
from skylimb.robots.equilibrium_program import programme_of
from skylimb.robots.equilibrium_results import LEVEL, USUAL, Held, Limit, NotHeld, Within
from skylimb.robots.loads import loads_function
from skylimb.robots.model import Robot
from skylimb.robots.starts import evenly, vectoring_starts

_LYING = 1.5
"""Tilt, rad, beyond which no rest is sought."""

_LEANS = (0.0, 0.3, -0.3)
"""Leans into the push with which the search begins, rad; with tilted rotors it may rest leaned away."""

_MOVES = (1.0, 2.0, 3.0)
"""Moves of the vectoring angles that are tried before larger ones, rad."""

_STARTS = 12
"""Sets of vectoring angles with which the search begins where they may move."""

_EXACT = 1e-6
"""Share of the weight that may be left over, and of a limit that may be exceeded."""

_BINDS = 1e-5
"""Least gain, for a limit that gives way by its whole size, that a limit needs to count as what ends it."""

_FAR = 1e9


def can_hold(
    robot: Robot,
    joint_angles: np.ndarray,
    vectoring_angles: np.ndarray,
    push: np.ndarray | None = None,
    within: Within = USUAL,
) -> Held | NotHeld:
    """Whether the robot can rest while its tip pushes, and the margin that is left.

    Args:
        robot: any robot with rotors.
        joint_angles: q as commanded, rad, (nq,).
        vectoring_angles: psi, rad, (nv,).
        push: in the level frame whose x axis is the heading, N, (3,); none by default: hover.
        within: what else is kept.
    """
    given = np.zeros(3) if push is None else np.asarray(push, dtype=float)
    size = float(np.linalg.norm(given))
    direction = given / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
    question = _Question(robot, joint_angles, vectoring_angles, direction, within)
    best = steadiest(question.rests(size, size))
    if best and (within.margin <= 0.0 or best.margin >= within.margin):
        return best
    greatest = None
    if size > 0.0:
        less = greatest_push(robot, joint_angles, vectoring_angles, direction, within, size)
        greatest = less.force if less else None
    if best:
        limit = best.limit and replace(best.limit, kept=0.0)
        return NotHeld(limit, 0.0, best.margin, greatest)
    return replace(best, greatest=greatest)


def steadiest(found: Iterable[tuple[Held | NotHeld, float]]) -> Held | NotHeld:
    """Of rests and their margins that with the greatest one; where there is none, what missed by least."""
    missed: list[NotHeld] = []
    best: Held | None = None
    most = -math.inf
    for one, margin in found:
        if isinstance(one, NotHeld):
            missed.append(one)
        elif margin > most:
            best, most = one, margin
    return best or min(missed, key=lambda one: one.excess)


def greatest_push(
    robot: Robot,
    joint_angles: np.ndarray,
    vectoring_angles: np.ndarray,
    direction: np.ndarray,
    within: Within = USUAL,
    most: float = math.inf,
) -> Held | NotHeld:
    """The greatest push along a direction up to `most` N with which the robot can rest, and what ends it.

    It is `most` itself where the search comes that near to it that only rounding is left. Other arguments are
    those of `can_hold`; `direction` is a unit vector in the same frame.
    """
    most = min(most, 1e2 * robot.weight)
    along = np.asarray(direction, dtype=float)
    tried: list[Held | NotHeld] = []
    # What is held with smaller moves is held with larger ones: a search that ends beside it reads no less.
    for moves in (*(one for one in _MOVES if one < within.moves), within.moves):
        question = _Question(robot, joint_angles, vectoring_angles, along, replace(within, moves=moves))
        for found, _ in question.rests(0.0, most):
            if found and found.force >= (1.0 - _EXACT) * most:
                return replace(found, push=most * question.direction)
            tried.append(found)
    # The hardest push; where there is none, what missed by least.
    return max(tried, key=lambda one: (1.0, one.force) if one else (0.0, -one.excess))


def hovers(
    robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray, within: Within
) -> Iterator[Held | NotHeld]:
    """What the searches of `can_hold` without a push lead to, one after another."""
    return (found for found, _ in hovers_and_margins(robot, joint_angles, vectoring_angles, within))


def hovers_and_margins(
    robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray, within: Within
) -> Iterator[tuple[Held | NotHeld, float]]:
    """The same, each with the margin that was maximised."""
    question = _Question(robot, joint_angles, vectoring_angles, np.array([0.0, 0.0, 1.0]), within)
    return question.rests(0.0, 0.0)


class _Question:
    """One posture, one direction, one set of limits."""

    def __init__(
        self,
        robot: Robot,
        joint_angles: np.ndarray,
        vectoring_angles: np.ndarray,
        direction: np.ndarray,
        within: Within,
    ) -> None:
        self.robot, self.within, self.direction = robot, within, direction
        self.q, self.psi = (np.asarray(angles, dtype=float) for angles in (joint_angles, vectoring_angles))
        self.low, self.high = robot.thrust_limits()
        self.tilt = min(max(within.tilt, LEVEL), _LYING)
        lower, upper = robot.vectoring_limits()
        self.free = math.isinf(within.moves) and robot.n_vectoring > 0
        self.lower = np.maximum(np.maximum(lower, self.psi - within.moves), -_FAR)
        self.upper = np.minimum(np.minimum(upper, self.psi + within.moves), _FAR)
        # The given angles themselves are never forbidden.
        self.lower, self.upper = np.minimum(self.lower, self.psi), np.maximum(self.upper, self.psi)
        # Where a margin is asked for, it counts with the levers that come of the angles. Else with those that
        # are given; or, as there are none with free angles, the room of the thrusts counts.
        self.swing = None if self.free and within.margin <= 0.0 else swings(robot, self.q, self.psi)
        self.programme = programme_of(robot, levers=self.swing is not None and within.margin > 0.0)

    def rests(self, least: float, most: float) -> Iterator[tuple[Held | NotHeld, float]]:
        """What each search finds: the farthest push between two sizes, N; where they are one, the margin.

        Beside it is the margin that was maximised: a torque, or a share of thrusts where angles are free.
        """
        robot, within, pushing = self.robot, self.within, most > least
        nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
        share = 0.0 if pushing else 1.0
        spare, kept = self.swing, within.margin if pushing else 0.0
        if spare is None:
            # No room is as large as the range: rotors that do not give all torques keep no margin.
            spare, kept = self.high - self.low, float(kept > 0.0)
        room = np.full(nq, 0.0 if within.stiff else _FAR)
        size, far = math.sin(self.tilt), _LYING
        low = [-far, -far, *np.full(n, -_FAR), *self.lower, *-room, least, kept, 0.0]
        high = [far, far, *np.full(n, _FAR), *self.upper, *room, most, kept if pushing else _FAR, _FAR]
        least_g = [0.0] * 6 + [-np.inf if within.stiff else 0.0] * nq + [-np.inf] * self.programme.limits
        servos = 2 * (nq + nv)
        most_g = [0.0] * 6 + [np.inf if within.stiff else 0.0] * nq + [0.0] * (2 * n)
        most_g += [within.servo] * servos + [0.0]
        given = {"lbx": low, "lbg": least_g, "ubg": most_g}
        given["p"] = [*self.q, *self.direction, size, *spare, 1.0 - share, share]
        for lean, psi in self._starts():
            start = [*lean, *self._first(psi), *psi, *np.zeros(nq), least, kept, 0.0]
            yield self._settled(given, start, high)

    def _settled(
        self, given: dict[str, Any], start: list[float], high: list[float]
    ) -> tuple[Held | NotHeld, float]:
        """What one search finds."""
        programme = self.programme
        # Limits give way only where they have to: that makes the programme harder to solve.
        for gives in (0.0, _FAR):
            found, solved = search(programme.solver, x0=start, ubx=[*high[:-1], gives], **given)
            balanced = found["g"].full().ravel()[: 6 if self.within.stiff else 6 + self.robot.n_joints]
            if solved and np.abs(balanced).max() < _EXACT:
                return self._told(found)
        return NotHeld(None, math.inf), 0.0

    def _told(self, found: dict[str, Any]) -> tuple[Held | NotHeld, float]:
        robot = self.robot
        nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
        x = found["x"].full().ravel()
        lean, thrusts, psi, bend = np.split(x[:-3], np.cumsum([2, n, nv]))
        size, spare, excess = x[-3:]
        limit = self._limit(found)
        if excess > _EXACT:
            return NotHeld(limit, float(excess)), 0.0
        thrusts = np.clip(thrusts, self.low, self.high)
        q = self.q + bend
        push = max(float(size), 0.0) * self.direction
        torques = self.programme.torques(x, self.q, self.direction).full().ravel()
        rooms = np.minimum(thrusts - self.low, self.high - thrusts)
        swing = swings(robot, q, psi)
        held = Held(
            push,
            thrusts,
            np.clip(psi, self.lower, self.upper),
            q,
            torques[:nq],
            math.acos(min(math.cos(lean[0]) * math.cos(lean[1]), 1.0)),
            0.0 if swing is None else max(float(np.min(rooms / swing)), 0.0),
            float(np.min(rooms / (self.high - self.low))),
            limit,
        )
        return held, float(spare)

    def _limit(self, found: dict[str, Any]) -> Limit | None:
        """The limit that would gain most by giving way."""
        robot, within = self.robot, self.within
        nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
        gains = found["lam_g"].full().ravel()[6 + nq :]
        turns = np.abs(found["lam_x"].full().ravel()[2 + n : 2 + n + nv])
        # For its whole way, as for other limits; one that is held is not limited.
        turns *= np.minimum(0.5 * (self.upper - self.lower), math.pi)
        if not max(gains.max(initial=0.0), turns.max(initial=0.0)) > _BINDS:
            return None
        description = robot.description
        if turns.max(initial=0.0) > gains.max(initial=0.0):
            k = int(np.argmax(turns))
            psi = float(found["x"][2 + n + k])
            end = self.upper[k] if abs(self.upper[k] - psi) < abs(psi - self.lower[k]) else self.lower[k]
            return Limit("vectoring angle", description.vectoring_joints[k], float(end), "rad")
        k = int(np.argmax(gains))
        if k < 2 * n:
            rotor = description.rotors[k % n]
            if k < n:
                return Limit("greatest thrust", rotor.name, rotor.thrust_max, "N", within.margin)
            return Limit("least thrust", rotor.name, rotor.thrust_min, "N", within.margin)
        k -= 2 * n
        if k >= 2 * (nq + nv):
            return Limit("tilt", "", self.tilt, "rad")
        joint = k % (nq + nv)
        most = float(description.servos.torque_limit[joint])
        return Limit("servo", description.moving_joints[joint], within.servo * most, "N m")

    def _starts(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Leans with the given vectoring angles; where these may move, upright with others in reach."""
        side = np.array([-self.direction[1], self.direction[0]])
        turned = rot_z(float(loads_function(self.robot)(self.q, self.psi)[5]))[:2, :2] @ side
        for lean in _LEANS if np.any(side) else _LEANS[:1]:
            yield float(np.clip(lean, -0.5 * self.tilt, 0.5 * self.tilt)) * turned, self.psi
        if self.within.moves > 0.0 and self.robot.n_vectoring:
            all_around = vectoring_starts(self.robot, self.psi, _STARTS)[1:]
            for psi in all_around if self.free else evenly(self.lower, self.upper, _STARTS - 1):
                yield np.zeros(2), psi

    def _first(self, psi: np.ndarray) -> np.ndarray:
        """Thrusts that the search begins with: those that carry the weight, as alike as can be."""
        if self.free:
            return self.robot.weight / float(self.high.sum()) * self.high
        matrix = loads_function(self.robot)(self.q, psi)[0].full()[2:]
        thrusts = np.linalg.lstsq(matrix, np.array([self.robot.weight, 0.0, 0.0, 0.0]), rcond=1e-6)[0]
        return np.clip(thrusts, self.low, self.high)


def swings(robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray) -> np.ndarray | None:
    """Thrust of each rotor for the torque of 1 N m about its worst axis, lift kept, 1/m, (n,).

    None where the rotors do not give lift and all torques.
    """
    matrix = loads_function(robot)(joint_angles, vectoring_angles)[0].full()[2:]
    if np.linalg.matrix_rank(matrix, tol=1e-7) < 4:
        return None
    return np.linalg.norm(np.linalg.pinv(matrix)[:, 1:], axis=1)
