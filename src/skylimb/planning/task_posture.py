"""The posture for a task: joint angles, heading and vectoring angles with the greatest worst margin.

While the tip presses on the surface with each of some pushes p_k (normal force and the drag of friction,
along the path), the robot is at rest,

    R_k Q_t lambda_k = m g z + p_k,        Q_r lambda_k = r x R_k^T p_k,

leaning by a roll and a pitch of its own for each. With A = [Q_z; Q_r], rotor i still allows a torque of

    min(lambda_i - lambda_min, lambda_max - lambda_i) / |row i of A^+ that torques act through|

about any axis beside the lift. Exact for four rotors; for more it is what least-norm thrusts allow, a lower
bound. The least over rotors and pushes is the margin, N m. One nonlinear program with exact derivatives from
CasADi maximises it over q, the heading, psi and all thrusts, within joint limits, with links apart and rotors
clear of the surface. It begins in the nominal posture and in some others, the same every time.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import casadi as ca
import numpy as np

from skylimb.errors import UnreachableError
from skylimb.planning.press import statics_function
from skylimb.planning.tip_pose import link_distances
from skylimb.planning.vectoring_criteria import TORQUE, VectoringCriteria
from skylimb.planning.vectoring_program import ipopt
from skylimb.planning.vectoring_search import bounded_by
from skylimb.robots.hover import golden_steps
from skylimb.robots.model import Robot
from skylimb.spatial import rot_z
from skylimb.symbolic import right_inverse

_STARTS = 9
_SAME = 0.05
"""Postures closer than this in every joint are one, rad."""

_TURN = 0.6
"""Greatest heading of the tip link beside the contact axis, rad."""

_LEAN = 0.35
"""Greatest roll and pitch, rad."""

_TRAVEL = 0.3
"""How far joints stay from their limits, so that the arm can give way, rad."""

_NEAR = 1e-3
"""Margin given up for a squared radian nearer to the nominal posture, N m."""


@dataclass(frozen=True, eq=False)
class Task:
    """What the tip has to do, in the level frame whose x axis is the contact axis's heading.

    Attributes:
        pushes: of the tip on the surface, N, (k, 3).
        normals: of the surface where each acts, unit, outward, (k, 3).
        clearance: least distance between links that are not joined, m.
        rotor_room: least distance of rotors' middles and links' origins to the plane of the surface, m.
        criteria: what the vectoring angles keep.
    """

    pushes: np.ndarray
    normals: np.ndarray
    clearance: float = 0.1
    rotor_room: float = 0.2
    criteria: VectoringCriteria = TORQUE


@dataclass(frozen=True, eq=False)
class TaskPosture:
    """A posture for a task.

    Attributes:
        joint_angles: q, rad, (nq,).
        vectoring_angles: psi, rad, (nv,).
        heading: of the tip link beside the contact axis, rad.
        thrusts: while it presses, N, (k, n).
        margins: torque that is left about any axis, N m, (k,).
    """

    joint_angles: np.ndarray
    vectoring_angles: np.ndarray
    heading: float
    thrusts: np.ndarray
    margins: np.ndarray

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
        start: where the search begins, `judged_posture` of the nominal one.

    Raises:
        UnreachableError: no posture that the search finds can do it.
    """
    program = _Program(robot, len(task.pushes), task.criteria)
    lower, upper = travel(robot)
    steps = np.outer(np.arange(1, _STARTS), golden_steps(max(robot.n_joints, 1)))[:, : robot.n_joints] % 1.0
    starts = [start.joint_angles, *(lower + (upper - lower) * steps)]
    found = [program.solve(task, start, q) for q in starts]
    best: list[TaskPosture] = []
    for one in sorted((one for one in found if one is not None), key=lambda one: -one.margin):
        if all(np.max(np.abs(one.angles - other.angles), initial=0.0) > _SAME for other in best):
            best.append(one)
    if not best:
        raise UnreachableError(
            f"no posture of '{robot.name}' holds all of the {len(task.pushes)} pushes within its limits, "
            f"with links {task.clearance:g} m apart and rotors {task.rotor_room:g} m off the surface"
        )
    return best


def judged_posture(
    robot: Robot, task: Task, joint_angles: np.ndarray, vectoring_angles: np.ndarray, heading: float = 0.0
) -> TaskPosture | None:
    """A posture as it is: its thrusts and margins, negative beyond limits; None where it cannot rest."""
    n = robot.n_rotors
    given = TaskPosture(
        np.asarray(joint_angles, dtype=float),
        np.asarray(vectoring_angles, dtype=float),
        heading,
        np.zeros((len(task.pushes), n)),
        np.zeros(len(task.pushes)),
    )
    return _Program(robot, len(task.pushes), None).solve(task, given, given.joint_angles)


def travel(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Joint angles within which a posture leaves the arm some way to go, rad, (nq,) each."""
    lower, upper = (np.clip(limit, -math.pi, math.pi) for limit in robot.joint_limits())
    room = np.minimum(_TRAVEL, 0.25 * (upper - lower))
    return lower + room, upper - room


class _Program:
    """The program for some number of pushes; without criteria the posture is kept, and no limits but rest."""

    def __init__(self, robot: Robot, pushes: int, criteria: VectoringCriteria | None) -> None:
        self._robot, self._pushes, self._frozen = robot, pushes, criteria is None
        nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
        q, psi, yaw = ca.MX.sym("q", nq), ca.MX.sym("psi", nv), ca.MX.sym("yaw")
        lean, thrusts, t = ca.MX.sym("lean", 2, pushes), ca.MX.sym("thrusts", n, pushes), ca.MX.sym("t")
        p, normals, nominal = ca.MX.sym("p", 3, pushes), ca.MX.sym("normals", 3, pushes), ca.MX.sym("q0", nq)
        along = _load_function(robot).map(pushes)
        rest, rooms, clear = along(q, psi, yaw, lean, thrusts, p, normals)
        shape = _distances(robot)(q)
        kept, self._least, self._most = ca.MX(0, 1), list[float](), list[float]()
        if criteria is not None and nv:
            within, self._least, self._most = _criteria_function(robot, criteria)
            kept = within(q, psi)
        x = ca.vertcat(q, psi, yaw, ca.vec(lean), ca.vec(thrusts), t)
        g = ca.vertcat(ca.vec(rest), ca.vec(rooms) - t, ca.vec(clear), shape, kept)
        cost = -t + _NEAR * (ca.sumsqr(q - nominal) + yaw**2)
        problem = {"x": x, "p": ca.vertcat(nominal, ca.vec(p), ca.vec(normals)), "f": cost, "g": g}
        self._sizes = [ca.vec(part).shape[0] for part in (rest, rooms, clear, shape)]
        self._solver = ipopt(problem, 300)
        self._rooms = ca.Function("rooms", [x, problem["p"]], [rooms])

    def solve(self, task: Task, start: TaskPosture, q: np.ndarray) -> TaskPosture | None:
        """What the search finds from posture q, psi and heading of `start`; None without success."""
        robot, k = self._robot, self._pushes
        nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
        rotors, weight = robot.description.rotors, robot.weight
        most = np.array([rotor.thrust_max for rotor in rotors])
        guess = np.tile(weight / most.sum() * most, k)
        x0 = np.concatenate([q, start.vectoring_angles, [start.heading], np.zeros(2 * k), guess, [0.0]])
        angles = travel(robot), robot.vectoring_limits()
        fixed = np.concatenate([start.joint_angles, start.vectoring_angles, [start.heading]])
        low, high = (np.concatenate([angles[0][i], angles[1][i], [(2 * i - 1) * _TURN]]) for i in (0, 1))
        low, high = (fixed, fixed) if self._frozen else (low, high)
        wide = 1.5 if self._frozen else _LEAN
        reach = 10.0 * most.sum() if self._frozen else np.inf
        lbx = [*low, *[-wide] * (2 * k), *[-reach] * (n * k), -np.inf]
        ubx = [*high, *[wide] * (2 * k), *[reach] * (n * k), np.inf]
        free = np.inf if self._frozen else 0.0
        rest, rooms, clear, shape = self._sizes
        lbg = [0.0] * rest + [0.0] * rooms + [task.rotor_room - free] * clear
        lbg += [task.clearance - free] * shape + self._least
        ubg = [0.0] * rest + [np.inf] * (rooms + clear + shape) + self._most
        p = np.concatenate([robot.nominal_posture(), task.pushes.ravel(), task.normals.ravel()])
        bounds = [np.nan_to_num(np.array(part), posinf=1e19, neginf=-1e19) for part in (lbx, ubx, lbg, ubg)]
        found = self._solver(x0=x0, p=p, lbx=bounds[0], ubx=bounds[1], lbg=bounds[2], ubg=bounds[3])
        if not self._solver.stats()["success"]:
            return None
        x = found["x"].full().ravel()
        margins = self._rooms(found["x"], p).full().min(axis=0)
        return TaskPosture(
            x[:nq], x[nq : nq + nv], float(x[nq + nv]), x[nq + nv + 1 + 2 * k : -1].reshape(k, n), margins
        )


@functools.lru_cache(maxsize=16)
def _load_function(robot: Robot) -> ca.Function:
    """One push: (q, psi, yaw, lean, thrusts, p, normal) -> rest (6,), margins (2 n,), rooms (n + nq + 1,)."""
    nq, nv, n = robot.n_joints, robot.n_vectoring, robot.n_rotors
    q, psi, yaw, lean = ca.SX.sym("q", nq), ca.SX.sym("psi", nv), ca.SX.sym("yaw"), ca.SX.sym("lean", 2)
    thrusts, p, normal = ca.SX.sym("thrusts", n), ca.SX.sym("p", 3), ca.SX.sym("normal", 3)
    turn = ca.SX(rot_z(-yaw))
    rest = statics_function(robot)(ca.vertcat(lean, thrusts, ca.SX.zeros(nv)), q, psi, turn @ p)
    state, rotors = robot.model(q, psi), robot.description.rotors
    scale = right_inverse(state.allocation_C[2:, :])[:, 1:]
    sizes = ca.sqrt(ca.sum2(scale * scale))
    least = np.array([rotor.thrust_min for rotor in rotors])
    most = np.array([rotor.thrust_max for rotor in rotors])
    rooms = ca.vertcat((thrusts - least) / sizes, (most - thrusts) / sizes)
    # The level robot with its tip link's heading at yaw: where rotors are from the tip.
    level = ca.SX(rot_z(yaw - state.tip_heading)) @ state.R_root_C.T
    middles = [robot.link_pose_function(rotor.link)(q, psi)[:, 0] for rotor in rotors]
    links = ca.vertsplit(robot.skeleton(q, psi)[:-1, :])
    clear = [
        ca.dot(normal, level @ (point - state.tip_root)) for point in (*middles, *(link.T for link in links))
    ]
    weight = robot.weight
    return ca.Function(
        "load",
        [q, psi, yaw, lean, thrusts, p, normal],
        [rest / weight, rooms, ca.vertcat(*clear)],
        {"cse": True},
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
