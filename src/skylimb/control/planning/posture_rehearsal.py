"""A way through postures rehearsed on the ground: vectoring angles as a flight plans them, and what is left.

`control.allocation.planned` plans from the commanded joint angles alone, so the rehearsal is what flies.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.control.planning.joint_torque import HELD, held_share
from skylimb.control.planning.vectoring_step import Planned, plan_vectoring
from skylimb.robots.model import Robot

_APART = 0.02
"""Greatest change of a joint angle between two plans on a straight way, rad."""


class Rehearsal(NamedTuple):
    """What a flight through some postures would plan, one row a posture.

    Attributes:
        joint_angles: q, rad, (k, nq).
        vectoring_angles: psi, rad, (k, nv).
        margins: torque that is left, N m, (k,); see `Planned.margin`.
        tilts: of the hover, rad, (k,).
        servos: greatest share of their torque that the shape joints' servos give (`joint_torque`), (k,).
    """

    joint_angles: np.ndarray
    vectoring_angles: np.ndarray
    margins: np.ndarray
    tilts: np.ndarray
    servos: np.ndarray

    @property
    def worst(self) -> int:
        """Row with the least margin; of those that tilt too much, the one with the most tilt."""
        return int(np.argmin(self.margins))

    def leaves(self, least: float) -> bool:
        """Whether every row leaves a margin (N m), and the servos of the joints enough to bend them."""
        return self.first_without(least) is None and bool(np.all(self.servos <= HELD))

    @property
    def last(self) -> Planned:
        """The plan at its end."""
        return Planned(self.vectoring_angles[-1], float(self.margins[-1]), float(self.tilts[-1]))

    def first_without(self, least: float) -> int | None:
        """The first row with a margin below `least` (N m), or None."""
        short = np.flatnonzero(~(self.margins >= least))
        return int(short[0]) if len(short) else None


def rehearse(robot: Robot, postures: np.ndarray, before: np.ndarray) -> Rehearsal:
    """The plans for postures (k, nq), one after another from the angles `before` (nv,), rad.

    Args:
        robot: of four rotors or more.
        postures: q, as they are commanded from plan to plan, rad.
        before: psi in the first of them, rad.
    """
    plans, angles = [], np.asarray(before, dtype=float)
    for q in postures:
        plans.append(plan_vectoring(robot, q, angles))
        angles = plans[-1].angles
    return Rehearsal(
        np.asarray(postures, dtype=float),
        np.array([plan.angles for plan in plans]).reshape(len(plans), robot.n_vectoring),
        np.array([plan.margin for plan in plans]),
        np.array([plan.tilt for plan in plans]),
        np.array([held_share(robot, q, plan.angles) for q, plan in zip(postures, plans, strict=True)]),
    )


def straight_way(begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Postures (k, nq) from one to another, all joints together, as densely as a flight plans, rad."""
    begin, end = np.asarray(begin, dtype=float), np.asarray(end, dtype=float)
    count = 1 + int(np.ceil(np.max(np.abs(end - begin), initial=0.0) / _APART))
    share = np.linspace(0.0, 1.0, count + 1)[1:, None]
    return (1.0 - share) * begin + share * end
