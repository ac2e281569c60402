"""Refuse robots that cannot fly: what only the whole model shows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from skylimb.base.errors import AllocationError, DescriptionError
from skylimb.robots.controlled_axes import inputs_at, not_given
from skylimb.robots.equilibrium_results import Held, NotHeld
from skylimb.robots.hover import any_hover, cannot_hover, find_hover
from skylimb.robots.links import Inertial
from skylimb.robots.model import Robot
from skylimb.robots.starts import golden_steps, vectoring_starts, within_limits
from skylimb.robots.turned_rotors import ENOUGH
from skylimb.robots.validation import check_inertial, limited_by_torque

_TRIES = 16
"""Sets of vectoring angles near the first ones at which least-norm thrusts are looked at."""

_FLAT = 0.2
"""Length of the tool's x axis, seen from above, from which on it gives a heading."""
_ALONG = 21
"""Postures of the family at which that is looked at."""

_SAMPLES = 64
"""Sets of vectoring angles at which the rank of the allocation matrix is looked at."""


def check_robot(robot: Robot) -> None:
    """Check what only the whole model shows: moving bodies have mass, and the rotors can carry it all.

    Raises:
        DescriptionError: a moving body without mass, or too few rotors.
        AllocationError: at the nominal posture the rotors cannot command a thrust and three torques, or
            cannot hover.
    """
    check_moving_bodies(robot)
    check_few_rotors(robot)
    _check_heading(robot)
    robot = robot.pairs
    q, start = robot.nominal_posture(), robot.description.vectoring_start
    steps = np.outer(np.arange(_TRIES if robot.n_vectoring else 1), golden_steps(robot.n_vectoring))
    # Least-norm thrusts that hold answer in no time; only where none are found a search has to.
    near = within_limits(robot, start + np.sign(steps) * (steps % 1.0 - 0.5))
    if any(_hovers_at(robot, q, psi) for psi in near):
        return
    found = any_hover(robot, q)
    if not found:
        _refuse(robot, q, found)


def _check_heading(robot: Robot) -> None:
    posture, start = robot.description.posture, robot.description.vectoring_start
    require_heading(robot, [robot.nominal_posture()], [start], "in the nominal posture")
    thetas = np.linspace(posture.theta_min, posture.theta_max, _ALONG)
    along = [posture.offset + posture.slope * theta for theta in thetas]
    require_heading(robot, along, [start] * _ALONG, "in the family of postures")


def require_heading(
    robot: Robot, joint_angles: Iterable[np.ndarray], vectoring_angles: Iterable[np.ndarray], where: str
) -> None:
    """Refuse a heading by an axis that comes upright: what is left of it, seen from above, is rounding.

    Past upright it jumps by half a turn.

    Args:
        robot: whose tool may give the heading.
        joint_angles: of postures that follow each other, (nq,), rad.
        vectoring_angles: of the same, (nv,), rad.
        where: these are, in words.

    Raises:
        DescriptionError: the tool gives no heading in one of them, or between two of them.
    """
    if robot.description.tip.heading == "root":
        return
    axes = [robot.tool(q, psi)[0][:, 1] for q, psi in zip(joint_angles, vectoring_angles, strict=True)]
    for axis, before in zip(axes, [axes[0], *axes], strict=False):
        if np.hypot(axis[0], axis[1]) < _FLAT or axis[:2] @ before[:2] < 0.0 < abs(axis[2] + before[2]):
            raise DescriptionError(
                f"the tool of '{robot.name}' points {'up' if axis[2] + before[2] > 0.0 else 'down'} {where}, "
                "so its x axis gives no heading; say tip.heading = 'root', and the root's x axis does"
            )


def check_moving_bodies(robot: Robot) -> None:
    """Refuse a moving body without mass, or one whose links together have an inertia that no body has."""
    for body in robot.bodies:
        if body.mass <= 0.0:
            raise DescriptionError(
                f"the body of link '{body.name}' moves but has no mass; give it an <inertial>"
            )
        check_inertial(body.name, Inertial(body.mass, body.com, body.inertia))


def check_few_rotors(robot: Robot) -> None:
    """Refuse a robot of fewer than four rotors, for what it really lacks.

    Where arms turn its rotors, thrusts and angles together may give lift and three torques; so it is flown
    where each such joint turns one rotor, across its thrust (`robots.turned_rotors`).
    """
    if robot.pairs.n_rotors >= ENOUGH:
        return
    q, who = robot.nominal_posture(), f"'{robot.name}' has {robot.n_rotors} rotors"
    hover = find_hover(robot, q)
    if not hover:
        raise DescriptionError(f"{who}; {cannot_hover(robot, q, hover)}")
    thrusts, angles = (part[2:] for part in inputs_at(robot, q, hover.vectoring_angles, hover.thrusts))
    lacking = not_given(np.hstack([thrusts, angles]))
    if lacking:
        raise DescriptionError(f"{who}; it hovers, but neither thrusts nor vectoring angles give {lacking}")
    raise DescriptionError(
        f"{who}; it hovers, and thrusts with vectoring angles hold every axis, but its laws need joints that "
        f"turn one rotor each, across its thrust; thrusts alone do not give {not_given(thrusts)}"
    )


def bounded(robot: Robot) -> Robot:
    """The robot with hover thrusts within their limits, where those of the least norm are not.

    With more than four rotors thrusts can be chosen: then those of the steadiest hover in the nominal posture
    are preferred. A robot with vectoring joints chooses angles instead, and stays as it is.
    """
    q = robot.nominal_posture()
    if robot.n_rotors <= 4 or robot.n_vectoring or _hovers_at(robot, q, np.zeros(0)):
        return robot
    hover = find_hover(robot, q)
    return Robot(replace(robot.description, preferred_thrusts=hover.thrusts)) if hover else robot


def least_norm_hover(robot: Robot, hover: Held) -> bool:
    """Whether least-norm thrusts hover as well, where joints and vectoring angles are those of a hover."""
    return _hovers_at(robot, hover.joint_angles, hover.vectoring_angles)


def _hovers_at(robot: Robot, q: np.ndarray, psi: np.ndarray) -> bool:
    try:
        thrusts = robot.at(q, psi).hover_thrusts
    except AllocationError:
        return False
    least, most = robot.thrust_limits()
    return bool(np.all(thrusts > least) and np.all(thrusts < most))


def _refuse(robot: Robot, q: np.ndarray, found: NotHeld) -> None:
    angles = vectoring_starts(robot, robot.description.vectoring_start, _SAMPLES)
    ranks = [np.linalg.matrix_rank(robot.wrench_function(q, psi).full()[2:], tol=1e-7) for psi in angles]
    if max(ranks) < 4:
        raise AllocationError(
            f"the allocation matrix of '{robot.name}' is singular at its nominal posture, whatever the "
            "vectoring angles: "
            "its rotors cannot command a thrust and three torques; look at rotor frames and spins"
        )
    anyhow = " at any vectoring angles within their limits" if robot.n_vectoring else ""
    weak = limited_by_torque(robot.description)
    raise AllocationError(
        f"{cannot_hover(robot, q, found)}{anyhow}{weak}; look at rotor frames, spins and masses"
    )
