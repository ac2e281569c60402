"""What the rotors of a robot can do in its nominal posture, in numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from skylimb.base.errors import AllocationError
from skylimb.robots.controlled_axes import inputs_at
from skylimb.robots.equilibrium_results import Held, NotHeld
from skylimb.robots.hover import find_hover, find_hovers
from skylimb.robots.model import Robot
from skylimb.robots.reaction import reaction_zeros, slowest_unstable_zero
from skylimb.robots.touch import Touch, can_touch

_RANK = 1e-6
"""A singular value counts from this share of the greatest one on."""


@dataclass(frozen=True)
class Actuation:
    """What the rotors can do.

    Attributes:
        thrust_to_weight: sum of the greatest thrusts over the weight.
        hover: the steadiest hover, or what is in its way.
        touch: how the tip stands there to the rest of the robot, where it is foremost by most.
        ahead: the same along the heading, as a wall is touched.
        rank: of the (6, n) wrench matrix with the vectoring angles at rest there.
        condition: of its rows for lift and torque, which the flight controllers use; the best of the hovers
            found.
        rank_moving: of the (6, n + nv) matrix with thrusts and vectoring angles as inputs.
        lift_and_torque: whether thrusts alone give lift and three torques.
        unstable_zero: the slowest zero in the right half plane by the rotors' reaction (`robots.reaction`),
            rad/s: infinite where there is none, None where the rotors' inertia is not known.
    """

    thrust_to_weight: float
    hover: Held | NotHeld
    touch: Touch
    ahead: Touch
    rank: int
    condition: float
    rank_moving: int
    lift_and_torque: bool
    unstable_zero: float | None = None

    @property
    def in_words(self) -> str:
        """Whether the robot is fully actuated."""
        if self.rank == 6:
            return "fully actuated with vectoring angles at rest"
        if self.rank_moving == 6:
            return "fully actuated when its vectoring angles move"
        if not self.lift_and_torque:
            return "cannot give lift and three torques by its thrusts alone"
        return "underactuated: side force needs tilt"


def actuation(robot: Robot) -> Actuation:
    """The actuation in the nominal posture, at the vectoring angles of its steadiest hover."""
    q = robot.nominal_posture()
    hovers = find_hovers(robot, q)
    # Where there is none, the question says what is in the way.
    hover = max(hovers, key=lambda one: one.room, default=None) or find_hover(robot, q)
    at = hover.vectoring_angles if hover else robot.description.vectoring_start
    limits = np.array([rotor.thrust_max for rotor in robot.description.rotors])
    thrusts = hover.thrusts if hover else 0.5 * limits
    fixed, moving = inputs_at(robot, q, at, thrusts)
    angles = [at, *(one.vectoring_angles for one in hovers)]
    condition = min(_condition(robot.wrench_function(q, psi).full()[2:]) for psi in angles)
    return Actuation(
        float(limits.sum() / robot.weight),
        hover,
        can_touch(robot, q, at),
        can_touch(robot, q, at, np.array([1.0, 0.0, 0.0])),
        _rank(fixed),
        condition,
        _rank(np.hstack([fixed, moving])),
        math.isfinite(condition),
        _unstable_zero(robot, q, at) if hover else None,
    )


def _unstable_zero(robot: Robot, q: np.ndarray, psi: np.ndarray) -> float | None:
    if any(rotor.inertia is None or rotor.thrust_factor is None for rotor in robot.description.rotors):
        return None
    try:
        return slowest_unstable_zero(reaction_zeros(robot, q, psi))
    except AllocationError:
        return None


def _condition(matrix: np.ndarray) -> float:
    """Greatest over least singular value of (4, n), infinite where the rank is below four."""
    return float(np.linalg.cond(matrix)) if _rank(matrix) == 4 else math.inf


def _rank(matrix: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(matrix, rtol=_RANK)) if np.isfinite(matrix).all() else 0
