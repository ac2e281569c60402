"""A way from one posture to any other: joints from rest to rest, vectoring angles planned along them in step.

It is planned one plan a tick, at the pace in which it is flown (`planning.vectoring_step`), and is only gone
when all of it leaves torque: a posture that cannot be reached is refused before anything moves.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from skylimb.apps.ros.targets import Form, Shape
from skylimb.control.planning.smooth_step import quintic
from skylimb.control.planning.vectoring_step import RATE, STEP, TILTED, Planned, plan_vectoring
from skylimb.robots.model import Robot

KEPT = 0.5
"""Least torque that a posture has to leave, of what the nominal one does."""

_SLOWER = (1.0, 2.0, 4.0)
"""Times as long as its joints need: slow gimbals need longer."""

_SETTLING = 100
"""Plans at most behind the last one, until the gimbals have come to where they stay."""

_STILL = 1e-3
"""Move of a gimbal in a plan that counts as none, rad."""


@dataclass
class Bending:
    """A way that is being planned.

    Args:
        robot: whose.
        start: where it begins.
        end: joint angles where it ends, rad, (nq,).
        home: vectoring angles that belong to the end, rad, (nv,); None for those that are found there.
        form: of the end, where it has another name than its angles.
        shortest: least time that its joints may take, s.
        least: torque that has to be left all the way, N m; half of what is left where it begins with less.

    Attributes:
        rows: shapes so far, `1 / RATE` s apart.
        refused: why it cannot be gone; empty while that is not known.
        done: whether all of it is planned.
    """

    robot: Robot
    start: Shape
    end: np.ndarray
    home: np.ndarray | None
    form: float | None
    shortest: float
    least: float
    rows: list[Shape] = field(default_factory=list)
    refused: str = ""
    done: bool = False

    def __post_init__(self) -> None:
        self._tries = iter(_SLOWER)
        before = plan_vectoring(self.robot, *self.start, 0.0)
        # Whoever stands in a poor posture may leave it.
        left = max(float(before.margin), 0.0)
        self._least = self.least if left >= self.least else KEPT * left
        self._again()

    @property
    def duration(self) -> float:
        """Of the way, s."""
        return (len(self.rows) - 1) / RATE

    @property
    def ends(self) -> Form:
        """The form that it ends in."""
        return self.rows[-1] if self.form is None else self.form

    def plan(self) -> None:
        """One plan further."""
        if self.done or self.refused:
            return
        k, before = len(self.rows), self.rows[-1]
        part = float(quintic(np.asarray(min(k / self._steps, 1.0)))[0])
        joints = self.start.joints + part * (self.end - self.start.joints)
        if self.home is not None and k >= self._steps:
            self._go_home(before)
            return
        plan = plan_vectoring(self.robot, joints, before.vectoring)
        if not plan.feasible(self._least):
            self._fail(plan, part)
            return
        self.rows.append(Shape(joints, plan.angles))
        moved = float(np.max(np.abs(plan.angles - before.vectoring), initial=0.0))
        self.done = k >= self._steps and (moved < _STILL or k >= self._steps + _SETTLING)

    def _go_home(self, before: Shape) -> None:
        """Straight to the vectoring angles that belong to the end, at the gimbals' pace."""
        assert self.home is not None
        way = np.asarray(self.home) - before.vectoring
        left = float(np.max(np.abs(way), initial=0.0))
        angles = before.vectoring + way * min(1.0, STEP / max(left, STEP))
        plan = plan_vectoring(self.robot, self.end, angles, 0.0)
        if not plan.feasible(self._least):
            self._fail(plan, 1.0)
            return
        self.rows.append(Shape(self.end, angles))
        self.done = left <= STEP

    def _fail(self, plan: Planned, part: float) -> None:
        """Try it slower, or say why it cannot be gone."""
        if not self._again():
            where = "" if part >= 1.0 else f"{100.0 * part:.0f} % of the way there, "
            self.refused = where + shortfall(plan, self._least)

    def _again(self) -> bool:
        slower = next(self._tries, None)
        if slower is None:
            return False
        self._steps = max(1, round(slower * self.shortest * RATE))
        self.rows[:] = [self.start]
        return True


def shortfall(plan: Planned, least: float) -> str:
    """Why a posture is not flown in."""
    return (
        f"{plan.margin:.2f} N m are left about its axes, at a tilt of {plan.tilt:.2f} rad; it takes "
        f"{least:.2f} N m and at most {TILTED:g} rad"
    )
