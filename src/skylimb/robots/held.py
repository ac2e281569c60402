"""Can it be held? The one question about what a robot at rest can carry, and how hard its tip can push.

Joints are given as commanded. Servos are springs, so a joint rests beside its command, at q_j + tau_j / k.
Free are the lean of the body, the thrusts, moves of the vectoring angles, and where the joints come to rest:

    greatest push    maximise t   with the push t d and a margin that is kept
    margin           maximise h   with a given push

where forces and torques balance (`skylimb.statics`) and nothing is beyond its limit: each thrust, each
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

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np

from skylimb.robots.loads import loads_function
from skylimb.robots.model import Robot
from skylimb.robots.starts import golden_steps, within_limits
from skylimb.spatial import rot_z
from skylimb.statics import rest_function
from skylimb.symbolic import right_inverse

LEVEL = 1e-3
"""Tilt that stands for none, rad; four rotors hold a wrench of six only with some."""

TILT = 0.35
"""Tilt to which a robot may lean into a push unless another is given, rad (20 degrees)."""

_LYING = 1.5
"""Tilt, rad, beyond which no rest is sought."""

_LEANS = (0.0, 0.3, -0.3)
"""Leans into the push with which the search begins, rad; with tilted rotors it may rest leaned away."""

_STARTS = 12
"""Sets of vectoring angles with which the search begins where they are free."""

_PRICE = 1e3
"""Of limits that give way by their whole size; 1 is a push of the weight, or 1 N m of margin."""

_EXACT = 1e-6
"""Share of the weight that may be left over, and of a limit that may be exceeded."""

_BINDS = 1e-5
"""Least gain, for a limit that gives way by its whole size, that a limit needs to count as what ends it."""

_COARSE = 0.05
"""A limit on tilt gives way by a share of no less than this, as the sine of the tilt."""

_FAR = 1e9


@dataclass(frozen=True)
class Within:
    """What has to be kept beside the limits of rotors and servos.

    Attributes:
        tilt: of the measured link from the vertical, the greatest, rad; less than `LEVEL` counts as that.
        moves: how far each vectoring angle may move from the given one, rad; infinite for all of its travel.
        margin: torque that has to be left about any axis, N m.
        servo: share of its torque that a servo may give.
        stiff: whether the joint angles are measured ones, so that no joint gives way.
    """

    tilt: float = TILT
    moves: float = 0.0
    margin: float = 0.0
    servo: float = 1.0
    stiff: bool = False


USUAL = Within()


@dataclass(frozen=True)
class Limit:
    """What ends it.

    Attributes:
        kind: "greatest thrust", "least thrust", "servo", "tilt", "vectoring angle" or "margin".
        name: of the rotor or joint; else empty.
        value: the limit, in `unit`.
        unit: N, N m or rad.
        kept: margin that is kept from it, N m; of thrusts.
    """

    kind: str
    name: str
    value: float
    unit: str
    kept: float = 0.0

    def __str__(self) -> str:
        whose = f" of '{self.name}'" if self.name else ""
        kept = f", with {self.kept:.3g} N m kept" if self.kept > 0.0 else ""
        return f"the {self.kind}{whose} ({self.value:.4g} {self.unit}{kept})"


@dataclass(frozen=True, eq=False)
class Held:
    """A robot that rests.

    Attributes:
        push: of the tip on its surroundings, in the level frame whose x axis is the tip link's, N, (3,).
        thrusts: N, (n,).
        vectoring_angles: rad, (nv,).
        joint_angles: where the servos hold the joints, rad, (nq,).
        joint_torques: of rotors, weight and push on each shape joint, N m, (nq,).
        tilt: of the measured link from the vertical, rad.
        margin: torque that is left about any axis, N m; 0 where the rotors do not give lift and all torques.
        room: least distance of a thrust to one of its limits, as a share of its range.
        limit: what ends it, or what the margin runs into first; None where nothing did.
    """

    push: np.ndarray
    thrusts: np.ndarray
    vectoring_angles: np.ndarray
    joint_angles: np.ndarray
    joint_torques: np.ndarray
    tilt: float
    margin: float
    room: float
    limit: Limit | None

    def __bool__(self) -> Literal[True]:
        return True

    @property
    def force(self) -> float:
        """Size of the push, N."""
        return float(np.linalg.norm(self.push))


@dataclass(frozen=True, eq=False)
class NotHeld:
    """A robot that cannot rest so.

    Attributes:
        limit: the limit in the way; None where the search came to no end.
        excess: by which share all limits together would have to give way.
        margin: what is left, where it is only less than what was asked for, N m.
        greatest: the greatest push the same way that can be held, N; None where not even none can.
    """

    limit: Limit | None
    excess: float
    margin: float | None = None
    greatest: float | None = None

    def __bool__(self) -> Literal[False]:
        return False

    def __str__(self) -> str:
        if self.limit is None:
            return "the search for thrusts and angles that hold it came to no end"
        if self.margin is not None:
            return f"{self.limit} leaves a margin of {self.margin:.3g} N m"
        return f"{self.limit} is in the way"


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
        push: in the level frame whose x axis is the tip link's, N, (3,); none by default: hover.
        within: what else is kept.
    """
    given = np.zeros(3) if push is None else np.asarray(push, dtype=float)
    size = float(np.linalg.norm(given))
    direction = given / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
    question = _Question(robot, joint_angles, vectoring_angles, direction, within)
    missed: list[NotHeld] = []
    best: Held | None = None
    most = -math.inf
    for found, margin in question.rests(size, size):
        if isinstance(found, NotHeld):
            missed.append(found)
        elif margin > most:
            best, most = found, margin
    if best is not None and (within.margin <= 0.0 or best.margin >= within.margin):
        return best
    greatest = None
    if size > 0.0:
        less = greatest_push(robot, joint_angles, vectoring_angles, direction, within, size)
        greatest = less.force if less else None
    if best is not None:
        limit = best.limit and replace(best.limit, kept=0.0)
        return NotHeld(limit, 0.0, best.margin, greatest)
    return replace(min(missed, key=lambda one: one.excess), greatest=greatest)


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
    question = _Question(robot, joint_angles, vectoring_angles, np.asarray(direction, dtype=float), within)
    tried: list[Held | NotHeld] = []
    for found, _ in question.rests(0.0, most):
        if found and found.force >= (1.0 - _EXACT) * most:
            return replace(found, push=most * question.direction)
        tried.append(found)
    # The hardest push; where there is none, what missed by least.
    return max(tried, key=lambda one: (1.0, one.force) if one else (0.0, -one.excess))


def hovers(
    robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray, within: Within
) -> Iterator[Held]:
    """What the searches of `can_hold` without a push lead to, one after another."""
    question = _Question(robot, joint_angles, vectoring_angles, np.array([0.0, 0.0, 1.0]), within)
    return (found for found, _ in question.rests(0.0, 0.0) if found)


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
        rotors = robot.description.rotors
        self.low = np.array([rotor.thrust_min for rotor in rotors])
        self.high = np.array([rotor.thrust_max for rotor in rotors])
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
        self.programme = _programme(robot, levers=self.swing is not None and within.margin > 0.0)

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
            found = programme.solver(x0=start, ubx=[*high[:-1], gives], **given)
            balanced = found["g"].full().ravel()[: 6 if self.within.stiff else 6 + self.robot.n_joints]
            if programme.solver.stats()["success"] and np.abs(balanced).max() < _EXACT:
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
        servo = description.shape_servo if joint < nq else description.vectoring_servo
        names = [*description.shape_joints, *description.vectoring_joints]
        return Limit("servo", names[joint], within.servo * servo.torque_limit, "N m")

    def _starts(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Leans with the given vectoring angles; where these are free, upright with others."""
        side = np.array([-self.direction[1], self.direction[0]])
        turned = rot_z(float(self._heading(self.psi)))[:2, :2] @ side
        for lean in _LEANS if np.any(side) else _LEANS[:1]:
            yield float(np.clip(lean, -0.5 * self.tilt, 0.5 * self.tilt)) * turned, self.psi
        if self.free:
            steps = np.outer(np.arange(1, _STARTS), golden_steps(self.robot.n_vectoring))
            for psi in within_limits(self.robot, self.psi + 2.0 * np.pi * steps):
                yield np.zeros(2), psi

    def _heading(self, psi: np.ndarray) -> float:
        return float(loads_function(self.robot)(self.q, psi)[5])

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


class _Programme(NamedTuple):
    """The programme of a robot.

    Attributes:
        solver: x is lean, thrusts, psi, bends of the joints, t, h, e; p is q, d, the sine of the greatest
            tilt, thrusts for 1 of h, and what t (of the weight) and h are worth.
        torques: (x, q, d) -> torques on shape and vectoring joints, N m.
        limits: how many rows of g are limits: thrusts, servos, tilt.
    """

    solver: ca.Function
    torques: ca.Function
    limits: int


@functools.lru_cache(maxsize=16)
def _programme(robot: Robot, *, levers: bool) -> _Programme:
    """The programme; with `levers` thrusts for 1 of h are those of the angles, not those that p gives."""
    nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
    description, weight = robot.description, robot.weight
    low = np.array([rotor.thrust_min for rotor in description.rotors])
    high = np.array([rotor.thrust_max for rotor in description.rotors])
    servo = description.shape_servo
    most = np.array([servo.torque_limit] * nq + [description.vectoring_servo.torque_limit] * nv)
    lean, thrusts, psi = ca.SX.sym("lean", 2), ca.SX.sym("thrusts", n), ca.SX.sym("psi", nv)
    bend, t, h, e = ca.SX.sym("bend", nq), ca.SX.sym("t"), ca.SX.sym("h"), ca.SX.sym("e")
    q, d, size = ca.SX.sym("q", nq), ca.SX.sym("d", 3), ca.SX.sym("size")
    spare, worth = ca.SX.sym("spare", n), ca.SX.sym("worth", 2)
    left, torques = rests(robot, q + bend, psi, lean, thrusts, t * d)
    given = torques / most
    if levers:
        torque = right_inverse(loads_function(robot)(q + bend, psi)[0][2:, :])[:, 1:]
        needed = ca.sqrt(ca.sum2(torque * torque))
    else:
        needed = spare
    # (sine of the angle from the vertical)^2
    leant = ca.sin(lean[0]) ** 2 + (ca.cos(lean[0]) * ca.sin(lean[1])) ** 2
    rows = [
        (thrusts - high + h * needed) / (high - low) - e,
        (low - thrusts + h * needed) / (high - low) - e,
        given - e,
        -given - e,
        (leant - size**2) / ca.fmax(size, _COARSE) ** 2 - e,
    ]
    x = ca.vertcat(lean, thrusts, psi, bend, t, h, e)
    bent = (servo.stiffness * bend - torques[:nq]) / servo.torque_limit
    limits = ca.vertcat(*rows)
    problem = {
        "x": x,
        "p": ca.vertcat(q, d, size, spare, worth),
        "f": _PRICE * e - worth[0] * t / weight - worth[1] * h,
        "g": ca.vertcat(left / weight, bent, limits),
    }
    options = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "error_on_fail": False}
    options |= {"ipopt.max_iter": 200}
    return _Programme(
        ca.nlpsol("held", "ipopt", problem, options),
        ca.Function("torques", [x, q, d], [torques], {"cse": True}),
        int(limits.shape[0]),
    )


def rests(robot: Robot, q: Any, psi: Any, lean: Any, thrusts: Any, push: Any) -> tuple[Any, Any]:
    """What is left over of force and torque, (6,), and torques on all joints, for CasADi's expressions.

    The push is in the level frame whose x axis is the tip link's.
    """
    C, V, J_c, J_r, r, heading = loads_function(robot)(q, psi)
    pushed = ca.SX(rot_z(heading)) @ push
    function = rest_function(robot.n_rotors, robot.n_joints + robot.n_vectoring)
    return function(C, V, J_c, J_r, r, robot.weight, lean, thrusts, pushed)
