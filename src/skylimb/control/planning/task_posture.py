"""The posture for a task: joint angles, heading and vectoring angles with the greatest worst margin.

While the tip presses on the surface with each of some pushes (normal force and the drag of friction, along
the path), the robot is at rest as `robots.equilibrium` has it: every thrust within its limits, no servo
beyond its share, joints where the servos hold them, leaning for each push by a lean of its own. The least
margin over the pushes is maximised over q, the heading, psi and all thrusts, within joint limits, with links
apart and rotors clear of the surface: one nonlinear programme with exact derivatives from CasADi. It begins
in the nominal posture and in some others, the same every time. Where nothing holds the pushes, the same
programme says which share of them can be held.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.errors import UnreachableError
from skylimb.base.rotations import rot_z, wrapped
from skylimb.base.statics import turned_back
from skylimb.control.planning.nlp import ipopt
from skylimb.control.planning.tip_pose import link_distances
from skylimb.control.planning.vectoring_criteria import TORQUE, VectoringCriteria
from skylimb.control.planning.vectoring_search import bounded_by
from skylimb.robots.equilibrium import can_hold
from skylimb.robots.equilibrium_program import rests
from skylimb.robots.equilibrium_results import TILT, NotHeld, Within
from skylimb.robots.model import Robot
from skylimb.robots.starts import evenly
from skylimb.symbolic import right_inverse

_STARTS = 24
"""Searches; a third of them end without a posture, and half of the others meet in the same one."""

_SAME = 0.05
"""Postures closer than this in every joint are one, rad."""

_TURN = 0.6
"""Greatest heading of the tip link beside the contact axis, rad."""

WITHIN = Within(TILT)
"""What a planned posture keeps for every push."""

_TRAVEL = 0.3
"""How far joints stay from their limits, so that the arm can give way, rad."""

_FACING = 1e-6
"""Keeps the derivative of how far a disc reaches finite where it faces the surface."""

_NEAR = 1e-3
"""Margin given up for a squared radian nearer to the nominal posture, N m."""


@dataclass(frozen=True, eq=False)
class Task:
    """What the tip has to do, in the level frame whose x axis is the contact axis's heading.

    Attributes:
        pushes: of the tip on the surface, N, (k, 3).
        normals: of the surface where each acts, unit, outward, (k, 3).
        clearance: least distance between links that are not joined, m.
        room: least distance of rotors' discs and links' origins to the plane of the surface, m.
        criteria: what the vectoring angles keep.
    """

    pushes: np.ndarray
    normals: np.ndarray
    clearance: float = 0.1
    room: float = 0.03
    criteria: VectoringCriteria = TORQUE

    @property
    def force(self) -> float:
        """The normal force of the hardest push, N."""
        return float(-np.sum(self.pushes * self.normals, axis=1).min())


@dataclass(frozen=True, eq=False)
class TaskPosture:
    """A posture for a task.

    Attributes:
        joint_angles: q, rad, (nq,).
        vectoring_angles: psi, rad, (nv,).
        heading: of the tip link beside the contact axis, rad.
        thrusts: while it presses, N, (k, n).
        margins: torque that is left about any axis, N m, (k,).
        share: of the pushes that is held.
    """

    joint_angles: np.ndarray
    vectoring_angles: np.ndarray
    heading: float
    thrusts: np.ndarray
    margins: np.ndarray
    share: float = 1.0

    @property
    def angles(self) -> np.ndarray:
        """All joints and the heading, rad, (nq + nv + 1,)."""
        return np.concatenate([self.joint_angles, self.vectoring_angles, [self.heading]])

    @property
    def margin(self) -> float:
        """The worst, N m."""
        return float(self.margins.min())


def best_postures(robot: Robot, task: Task, start: TaskPosture) -> list[TaskPosture]:
    """The postures with the greatest worst margin that searches from several starts find, best first.

    Args:
        robot: of four rotors or more.
        task: what the tip has to do.
        start: where the search begins; of its angles alone.

    Raises:
        UnreachableError: no posture that the search finds can do it. The message names what is in the way,
            and the share of the pushes that can be held.
    """
    program = _Program(robot, len(task.pushes), task.criteria)
    found = [program.solve(task, one) for one in _starts(robot, start)]
    best: list[TaskPosture] = []
    for one in sorted((one for one in found if one is not None), key=lambda one: -one.margin):
        if all(np.max(np.abs(wrapped(one.angles - other.angles)), initial=0.0) > _SAME for other in best):
            best.append(one)
    if not best:
        raise UnreachableError(_nothing_holds(robot, program, task, start))
    return best


def _starts(robot: Robot, start: TaskPosture) -> list[TaskPosture]:
    """The given posture, and others spread evenly over joint and vectoring angles.

    Each branch of vectoring angles ends somewhere else.
    """
    nq, turns = robot.n_joints, robot.vectoring_limits()
    lower, upper = (
        np.concatenate([some, np.clip(turn, -math.pi, math.pi)])
        for some, turn in zip(travel(robot), turns, strict=True)
    )
    others = evenly(lower, upper, _STARTS - 1)
    return [start, *(replace(start, joint_angles=x[:nq], vectoring_angles=x[nq:]) for x in others)]


def _nothing_holds(robot: Robot, program: _Program, task: Task, start: TaskPosture) -> str:
    """In words: what is in the way, and how much can be held."""
    tried = [program.solve(task, one, most=True) for one in _starts(robot, start)]
    nearest = max((one for one in tried if one is not None), key=lambda one: one.share, default=None)
    said = f"'{robot.name}' cannot do this task: no posture holds all of the {len(task.pushes)} pushes"
    if nearest is None or nearest.share <= 0.0:
        apart = f"links {task.clearance:g} m apart and rotors {task.room:g} m off the surface"
        return f"{said} within its limits, nor any share of them, with {apart}"
    there = nearest.joint_angles, nearest.vectoring_angles, nearest.heading
    judged = judged_posture(robot, task, *there)
    why = f": {judged}" if isinstance(judged, NotHeld) else ""
    return f"{said}{why}; what can be held is at most {nearest.share * task.force:.1f} N"


def judged_posture(
    robot: Robot,
    task: Task,
    joint_angles: np.ndarray,
    vectoring_angles: np.ndarray,
    heading: float = 0.0,
    within: Within = WITHIN,
) -> TaskPosture | NotHeld:
    """A posture as it is: thrusts and margin for every push; else what is in the way of the hardest one.

    What can be held the greatest of is then the normal force.
    """
    turned = task.pushes @ rot_z(-heading).T
    found = [can_hold(robot, joint_angles, vectoring_angles, push, within) for push in turned]
    missed = [
        # Of the whole push, friction and all, to the force that presses.
        replace(one, greatest=one.greatest and one.greatest / float(np.linalg.norm(push)) * task.force)
        for one, push in zip(found, turned, strict=True)
        if isinstance(one, NotHeld)
    ]
    if missed:
        return min(missed, key=lambda one: one.greatest or 0.0)
    held = [one for one in found if not isinstance(one, NotHeld)]
    return TaskPosture(
        np.asarray(joint_angles, dtype=float),
        np.asarray(vectoring_angles, dtype=float),
        heading,
        np.array([one.thrusts for one in held]),
        np.array([one.margin for one in held]),
    )


def travel(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Joint angles within which a posture leaves the arm some way to go, rad, (nq,) each."""
    lower, upper = (np.clip(limit, -math.pi, math.pi) for limit in robot.joint_limits())
    room = np.minimum(_TRAVEL, 0.25 * (upper - lower))
    return lower + room, upper - room


class _Program:
    """The program for some number of pushes: x is q, psi, heading, a column for each push, margin and share.

    A push's column is its lean, its thrusts, and how far each joint gives way.
    """

    def __init__(self, robot: Robot, pushes: int, criteria: VectoringCriteria) -> None:
        self._robot, self._pushes = robot, pushes
        nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
        q, psi, yaw, t = ca.MX.sym("q", nq), ca.MX.sym("psi", nv), ca.MX.sym("yaw"), ca.MX.sym("t")
        column, share, worth = ca.MX.sym("column", 2 + n + nq, pushes), ca.MX.sym("share"), ca.MX.sym("worth")
        p, normals, nominal = ca.MX.sym("p", 3, pushes), ca.MX.sym("normals", 3, pushes), ca.MX.sym("q0", nq)
        rest, given, rooms, clear = _load_function(robot).map(pushes)(q, psi, yaw, column, share * p, normals)
        shape = _distances(robot)(q)
        kept, self._least, self._most = ca.MX(0, 1), list[float](), list[float]()
        if nv:
            within, self._least, self._most = _criteria_function(robot, criteria)
            kept = within(q, psi)
        x = ca.vertcat(q, psi, yaw, ca.vec(column), t, share)
        g = ca.vertcat(ca.vec(rest), ca.vec(given), ca.vec(rooms) - t, ca.vec(clear), shape, kept)
        cost = -(1.0 - worth) * t - worth * share + _NEAR * (ca.sumsqr(q - nominal) + yaw**2)
        problem = {"x": x, "p": ca.vertcat(nominal, ca.vec(p), ca.vec(normals), worth), "f": cost, "g": g}
        self._sizes = [ca.vec(part).shape[0] for part in (rest, given, rooms, clear, shape)]
        self._solver = ipopt(problem, 300)
        self._rooms = ca.Function("rooms", [x, problem["p"]], [rooms])

    def solve(self, task: Task, start: TaskPosture, *, most: bool = False) -> TaskPosture | None:
        """What the search finds from the angles of `start`; None without success.

        With `most` it is the posture that holds the greatest share of all pushes, however little is left.
        """
        robot, k = self._robot, self._pushes
        nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
        _, high = robot.thrust_limits()
        guess = robot.weight / high.sum() * high
        first = np.tile([0.0, 0.0, *guess, *np.zeros(nq)], k)
        x0 = np.concatenate([start.angles, first, [0.0, 0.0 if most else 1.0]])
        angles = travel(robot), robot.vectoring_limits()
        least, greatest = (
            np.concatenate([angles[0][i], angles[1][i], [(2 * i - 1) * _TURN]]) for i in (0, 1)
        )
        lean = WITHIN.tilt
        rest, given, rooms, clear, shape = self._sizes
        lbg = [0.0] * rest + [-np.inf] * given + [0.0] * rooms + [task.room] * clear
        lbg += [task.clearance] * shape + self._least
        ubg = [0.0] * rest + [1.0] * given + [np.inf] * (rooms + clear + shape) + self._most
        p = np.concatenate(
            [robot.nominal_posture(), task.pushes.ravel(), task.normals.ravel(), [1.0 if most else 0.0]]
        )
        # Servos that give way make the search harder: it begins where stiff ones end.
        found: dict[str, Any] = {}
        for stiff in (False,) if most else (True, False):
            # Thrusts are bounded by their margins, which may be negative on the way to a solution.
            wide = np.concatenate([[lean, lean], np.full(n, np.inf), np.full(nq, 0.0 if stiff else np.inf)])
            lbx = [*least, *np.tile(-wide, k), 0.0 if most else -np.inf, 0.0 if most else 1.0]
            ubx = [*greatest, *np.tile(wide, k), np.inf, 1.0]
            bent = np.tile([*[0.0] * 6, *[np.inf if stiff else 0.0] * nq], k)
            lbg[:rest] = (-bent).tolist()
            ubg[: rest + given] = [*bent, *[np.inf if stiff else 1.0] * given]
            bounds = [np.nan_to_num(np.array(one), posinf=1e19, neginf=-1e19) for one in (lbx, ubx, lbg, ubg)]
            found = self._solver(x0=x0, p=p, lbx=bounds[0], ubx=bounds[1], lbg=bounds[2], ubg=bounds[3])
            if not self._solver.stats()["success"] or float(found["x"][-2]) < 0.0:
                return None
            x0 = found["x"]
        x = found["x"].full().ravel()
        column = x[nq + nv + 1 : -2].reshape(k, -1)
        margins = self._rooms(found["x"], p).full().min(axis=0)
        heading = float(x[nq + nv])
        return TaskPosture(x[:nq], x[nq : nq + nv], heading, column[:, 2 : 2 + n], margins, float(x[-1]))


@functools.lru_cache(maxsize=16)
def _load_function(robot: Robot) -> ca.Function:
    """One push: (q, psi, yaw, its column, p, normal) -> rest (6 + nq,), limits, margins (2 n,), rooms.

    The limits are the lean and the torques of all joints, as shares.
    """
    nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
    q, psi, yaw, column = (
        ca.SX.sym("q", nq),
        ca.SX.sym("psi", nv),
        ca.SX.sym("yaw"),
        ca.SX.sym("column", 2 + n + nq),
    )
    p, normal = ca.SX.sym("p", 3), ca.SX.sym("normal", 3)
    lean, thrusts, bend = column[:2], column[2 : 2 + n], column[2 + n :]
    there, rotors, description = q + bend, robot.description.rotors, robot.description
    left, torques = rests(robot, there, psi, lean, thrusts, ca.SX(rot_z(-yaw)) @ p)
    servos = description.shape_servo, description.vectoring_servo
    most = np.array([servos[0].torque_limit] * nq + [servos[1].torque_limit] * nv) * WITHIN.servo
    given = ca.vertcat(torques / most, -torques / most, ca.sumsqr(lean) / WITHIN.tilt**2)
    bent = (servos[0].stiffness * bend - torques[:nq]) / servos[0].torque_limit
    scale = right_inverse(robot.wrench_function(there, psi)[2:, :])[:, 1:]
    sizes = ca.sqrt(ca.sum2(scale * scale))
    least, high = robot.thrust_limits()
    rooms = ca.vertcat((thrusts - least) / sizes, (high - thrusts) / sizes)
    # The normal seen by the robot as it leans, with its tip link's heading at yaw: how far points are off.
    state = robot.model(there, psi)
    off = turned_back(lean, ca.SX(rot_z(state.tip_heading - yaw)) @ normal)
    poses = robot.link_pose_function(*(rotor.link for rotor in rotors)).call([there, psi])
    links = ca.vertsplit(robot.skeleton(there, psi)[:-1, :])
    clear = [ca.dot(off, link.T - state.tip_root) for link in links]
    for pose, rotor in zip(poses, rotors, strict=True):
        middle, axis = pose[:, 0] + pose[:, 1:] @ rotor.xyz, pose[:, 1:] @ rotor.R[:, 2]
        edge = (rotor.radius or 0.0) * ca.sqrt(1.0 - ca.dot(off, axis) ** 2 + _FACING)
        clear.append(ca.dot(off, middle - state.tip_root) - edge)
    rest = ca.vertcat(left / robot.weight, bent)
    return ca.Function(
        "load", [q, psi, yaw, column, p, normal], [rest, given, rooms, ca.vertcat(*clear)], {"cse": True}
    )


@functools.lru_cache(maxsize=16)
def _distances(robot: Robot) -> ca.Function:
    """Q -> distances between links that are not joined, m."""
    q = ca.SX.sym("q", robot.n_joints)
    return ca.Function("distances", [q], [link_distances(robot, q)], {"cse": True})


@functools.lru_cache(maxsize=16)
def _criteria_function(
    robot: Robot, criteria: VectoringCriteria
) -> tuple[ca.Function, list[float], list[float]]:
    """(q, psi) -> what the vectoring angles keep, with least and greatest values."""
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    _, kept, low, high = bounded_by(robot, criteria, q, psi)
    return ca.Function("kept", [q, psi], [kept], {"cse": True}), low, high
