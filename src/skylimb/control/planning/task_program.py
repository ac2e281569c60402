"""The nonlinear programme behind the posture for a task, with exact derivatives from CasADi.

Unknown are joint and vectoring angles, the heading, and for each push a lean, all thrusts and where the
joints come to rest; see `control.planning.task_posture`.
"""

from __future__ import annotations

import functools
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.interrupts import search
from skylimb.base.rotations import rot_z
from skylimb.base.statics import turned_back
from skylimb.control.planning.nlp import ipopt
from skylimb.control.planning.task import WITHIN, Task, TaskPosture, travel
from skylimb.control.planning.tip_pose import link_distances
from skylimb.control.planning.vectoring_criteria import VectoringCriteria
from skylimb.control.planning.vectoring_search import bounded_by
from skylimb.robots.equilibrium_program import rests
from skylimb.robots.model import Robot
from skylimb.symbolic import right_inverse

_TURN = 0.6
"""Greatest heading beside the contact axis, rad."""

_FACING = 1e-6
"""Keeps the derivative of how far a disc reaches finite where it faces the surface."""

_NEAR = 1e-3
"""Margin given up for a squared radian nearer to the nominal posture, N m."""


class TaskProgram:
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
            between = dict(zip(("lbx", "ubx", "lbg", "ubg"), bounds, strict=True))
            found, solved = search(self._solver, x0=x0, p=p, **between)
            if not solved or float(found["x"][-2]) < 0.0:
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
    servos, most = description.shape_servos, description.servos.torque_limit * WITHIN.servo
    given = ca.vertcat(torques / most, -torques / most, ca.sumsqr(lean) / WITHIN.tilt**2)
    bent = (servos.stiffness * bend - torques[:nq, :]) / servos.torque_limit
    scale = right_inverse(robot.wrench_function(there, psi)[2:, :])[:, 1:]
    sizes = ca.sqrt(ca.sum2(scale * scale))
    least, high = robot.thrust_limits()
    rooms = ca.vertcat((thrusts - least) / sizes, (high - thrusts) / sizes)
    # The normal seen by the robot as it leans, with its heading at yaw: how far points are off.
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
