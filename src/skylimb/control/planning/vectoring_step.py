"""Vectoring angles for any posture, in flight: a few damped Newton steps from the angles of before.

A plan is one call with a fixed number of operations, so it can be traced into the tick, and is the same in C.
It begins at the angles that are flown (warm start) and goes uphill on the merit of `vectoring_merit`: per
iteration one Newton step, of which the longest of `SHARES` that gains is taken, or none. No angle moves by
more than `step` in a plan, and the merit never falls. So the angles follow the posture continuously and
cannot jump to another branch, however much better that one may be. Where their own branch comes to an end,
the margin says so: it is negative, or small.

Joints are given as they are commanded. What is planned for is where their servos hold them
(`joint_torque.rest_function`): DRAGON's give way by up to 0.06 rad, which can be 4 N of a hover thrust.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.errors import AllocationError
from skylimb.base.rotations import wrapped
from skylimb.control.planning.joint_torque import rest_function
from skylimb.control.planning.nlp import distinct
from skylimb.control.planning.vectoring_merit import merit_function, uphill_function
from skylimb.control.planning.vectoring_program import turns_freely
from skylimb.robots.hover import find_hovers
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, clip, is_symbolic, solve_positive

RATE = 20.0
"""Plans in a second of flight, Hz."""

STEP = 0.025
"""Greatest move of an angle in a plan of a flight, rad: faster ones push the robot off its place."""

TILTED = 0.1
"""Tilt of the hover beyond which a posture counts as none to fly in, rad."""

SHARES = (1.0, 0.5, 0.25, 0.06)
"""Of a Newton step, the longest first."""

_ITERATIONS = 3
_SAME = 0.05
"""Angles closer than this lead to the same place, rad."""

_SETTLING = 0.2
"""Greatest move of an angle in a plan while angles settle, rad."""

_SETTLED = 100
"""Plans until angles have settled in a posture that stays."""


class Planned(NamedTuple):
    """Vectoring angles of a posture.

    Attributes:
        angles: psi, rad, (nv,).
        margin: torque that is left about every axis, or to a thrust's limit, N m; negative where it cannot
            hover within the limits.
        tilt: angle between the net thrust and z of the root link, rad.
    """

    angles: Array
    margin: Any
    tilt: Any

    def feasible(self, least: float = 0.0) -> bool:
        """Whether more than a margin (N m) is left, with the root link near level."""
        return bool(self.margin > least and self.tilt <= TILTED)


@functools.lru_cache(maxsize=16)
def planning_function(robot: Robot) -> ca.Function:
    """(q, psi, step) -> psi (nv,), margin, tilt: one plan, for numbers or inside of a traced function."""
    nq, nv = robot.n_joints, robot.n_vectoring
    q, start, step = ca.MX.sym("q", nq), ca.MX.sym("psi", nv), ca.MX.sym("step")
    rest, psi = rest_function(robot)(q, start), start
    if nv:
        iterate = _iteration(robot)
        for _ in range(_ITERATIONS):
            psi = iterate(rest, psi, start, step)
    _, margin, tilt = merit_function(robot)(rest_function(robot)(q, psi), psi)
    return ca.Function(
        "plan_vectoring",
        [q, start, step],
        [psi, margin, ca.norm_2(tilt)],
        ["q", "psi", "step"],
        ["angles", "margin", "tilt"],
        {"never_inline": True},
    )


def plan_vectoring(robot: Robot, joint_angles: Any, before: Any, step: float = STEP) -> Planned:
    """One plan: the angles that follow those of before to a posture.

    Args:
        robot: of four rotors or more.
        joint_angles: q, rad, (nq,): as commanded now.
        before: psi, rad, (nv,): of the plan before.
        step: greatest move of an angle, rad.

    Returns:
        Of angles that are no finite numbers a plan that is not feasible.

    Raises:
        ConfigError: the wrong number of angles.
    """
    q, psi = robot.checked_angles(joint_angles, before, finite=False)
    angles, margin, tilt = planning_function(robot)(q, psi, step)
    return Planned(angles.full().ravel(), float(margin), float(tilt))


def planned_along(robot: Robot, postures: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Psi, rad, (k, nv), as a flight plans it, one plan after another; it depends on the commanded q alone.

    Args:
        robot: of four rotors or more.
        postures: q as commanded from plan to plan, rad, (k, nq).
        before: psi in the first of them, rad, (nv,).
    """
    found = [np.asarray(before, dtype=float)]
    for q in postures:
        found.append(plan_vectoring(robot, q, found[-1]).angles)
    return np.array(found[1:])


def plan_when(
    robot: Robot, due: Any, joint_angles: Array, before: Array, step: Any, margin: Any
) -> tuple[Array, Any]:
    """Angles and margin of a plan where one is due, else those of before: a part of a traced tick.

    Args:
        robot: of four rotors or more.
        due: whether to plan; the plan costs nothing where it is not due.
        joint_angles: q, rad, (nq,).
        before: psi, rad, (nv,).
        step: greatest move of an angle, rad.
        margin: of the plan before, N m.
    """
    angles, margin = _plan_when(robot)(due, joint_angles, before, step, margin)
    if is_symbolic(joint_angles, before, due):
        return angles, margin
    return angles.full().ravel(), float(margin)


@functools.lru_cache(maxsize=16)
def _plan_when(robot: Robot) -> ca.Function:
    nq, nv = robot.n_joints, robot.n_vectoring
    q, psi, step, margin = ca.MX.sym("q", nq), ca.MX.sym("psi", nv), ca.MX.sym("step"), ca.MX.sym("margin")
    due, given = ca.MX.sym("due"), [q, psi, step, margin]
    planned = ca.Function("planned", given, planning_function(robot).call([q, psi, step])[:2])
    kept = ca.Function("kept", given, [psi, margin])
    return ca.Function(
        "plan_when",
        [due, *given],
        ca.Function.if_else("whether", planned, kept).call([due, *given]),
        {"never_inline": True},
    )


def settled_vectoring(robot: Robot, joint_angles: Any, before: Any) -> Planned:
    """Where plans in one posture lead, from some angles on. Arguments are those of `plan_vectoring`."""
    plan = plan_vectoring(robot, joint_angles, before, _SETTLING)
    for _ in range(_SETTLED):
        last, plan = plan, plan_vectoring(robot, joint_angles, plan.angles, _SETTLING)
        if np.max(np.abs(plan.angles - last.angles), initial=0.0) < 1e-4:
            break
    return plan


def first_vectoring(robot: Robot, joint_angles: Any = None) -> Planned:
    """The best vectoring angles of a posture, whatever the angles before: for a robot on the ground.

    Args:
        robot: of four rotors or more.
        joint_angles: q, rad, (nq,); the nominal posture by default.

    Raises:
        ConfigError: the wrong number of angles, or one that is no finite number.
        AllocationError: no angles let it hover within the thrusts' limits.
    """
    given = robot.nominal_posture() if joint_angles is None else joint_angles
    q, _ = robot.checked_angles(given, robot.description.vectoring_start)
    best = _first(robot, tuple(q.tolist()))
    if best is None:
        raise AllocationError(
            f"no vectoring angles of '{robot.name}' let it hover within its rotors' limits at joint angles "
            f"{np.round(q, 3).tolist()} rad"
        )
    return best


@functools.lru_cache(maxsize=256)
def _first(robot: Robot, joint_angles: tuple[float, ...]) -> Planned | None:
    q, merit = np.array(joint_angles), merit_function(robot)
    free = turns_freely(*robot.vectoring_limits())
    hovers = (hover.vectoring_angles for hover in find_hovers(robot, q, stiff=True))
    begun = (np.where(free, wrapped(angles), angles) for angles in hovers)
    plans = [settled_vectoring(robot, q, angles) for angles in distinct(begun, lambda one: one, _SAME)]
    usable = [plan for plan in plans if plan.margin > 0.0]
    return max(usable, key=lambda plan: float(merit(q, plan.angles)[0]), default=None)


def _iteration(robot: Robot) -> ca.Function:
    """(q, psi, start, step) -> psi after one Newton step that does not lose."""
    nq, nv = robot.n_joints, robot.n_vectoring
    q, psi, start, step = ca.MX.sym("q", nq), ca.MX.sym("psi", nv), ca.MX.sym("start", nv), ca.MX.sym("step")
    merit, gradient, curvature = uphill_function(robot)(q, psi)
    move = _solver(nv)(curvature, gradient)
    lower, upper = (np.clip(limit, -1e9, 1e9) for limit in robot.vectoring_limits())
    gains, best, found = merit_function(robot), merit, psi
    for share in reversed(SHARES):
        tried = clip(clip(psi + share * move, start - step, start + step), lower, upper)
        reached = gains(q, tried)[0]
        # A comparison with what is no number is false, so a singular place is never gone to.
        found = ca.if_else(reached > merit, tried, found)
        best = ca.if_else(reached > merit, reached, best)
    return ca.Function("iteration", [q, psi, start, step], [found])


def _solver(n: int) -> ca.Function:
    M, right = ca.SX.sym("M", n, n), ca.SX.sym("right", n)
    return ca.Function("solve", [M, right], [solve_positive(M, right)], {"cse": True})
