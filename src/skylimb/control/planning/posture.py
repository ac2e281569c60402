"""The one-parameter family of postures: reach <-> shape angle theta -> joint angles (eq:joint angles).

Reach r is the distance from the centre of gravity to the tip along the heading. The vectoring
units shift the centre of gravity by up to 1.5 mm as they turn; r takes their average over a turn, so that it
depends on theta only. A robot without bending joints has one posture, at its nominal theta, and one reach.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.polynomial import chebyshev

from skylimb.base.errors import DescriptionError
from skylimb.control.planning.series import evaluate_chebyshev, fit_chebyshev, fit_circle, within
from skylimb.robots import PostureFamily, Robot
from skylimb.symbolic import clip, is_symbolic

CONTACT = "contact"
"""Purpose of vectoring angles with which a robot may stand on the other side."""

_NEWTON_STEPS = 2
_STILL = 1e-9
"""Change of the reach that is rounding, m."""
_WIDEST, _NARROWEST = 0.35, 0.02
"""How far theta of a family that is sought goes to both sides, at most and at least, rad."""


@functools.lru_cache(maxsize=16)
def posture_family(robot: Robot) -> ReachFamily:
    """The robot's family of postures, with its reach; found once for each robot object.

    Raises:
        DescriptionError: no posture of the family is within the joint limits, or reach does not change one
            way with theta.
    """
    return ReachFamily(robot)


@functools.lru_cache(maxsize=16)
def standing(robot: Robot, purpose: str) -> Robot:
    """The robot as it stands with vectoring angles of a purpose, for contact perhaps bent to the other side.

    Mirrored, a chain keeps what its rotors can hold but for their spins, which nobody mirrors: where their
    reaction was against their thrust it helps it (`robots.reaction`).

    Args:
        robot: as it is described.
        purpose: as of `vectoring.vectoring_table`.
    """
    posture = robot.description.posture
    if purpose != CONTACT or posture.contact_side == "same":
        return robot
    posture = replace(posture, offset=-posture.offset, slope=-posture.slope, contact_side="same")
    return Robot(replace(robot.description, posture=posture))


def widest_family(
    robot: Robot, offset: np.ndarray, slope: np.ndarray, nominal: float
) -> PostureFamily | None:
    """Postures offset + slope theta (rad) as far about a nominal theta as a reach names one of them.

    They go equally far to both sides, within the joint limits; None where that is hardly any way.
    """
    width = _WIDEST
    while width > _NARROWEST:
        family = PostureFamily(offset, slope, nominal - width, nominal + width, nominal)
        try:
            reach = ReachFamily(Robot(replace(robot.description, posture=family)))
        except DescriptionError:  # beyond a limit, or it turns back
            width *= 0.8
            continue
        width = min(nominal - reach.theta_min, reach.theta_max - nominal)
        if width > _NARROWEST:
            return replace(family, theta_min=nominal - width, theta_max=nominal + width)
    return None


class ReachFamily:
    """Postures q = offset + slope theta, and the reach each gives.

    Every method takes floats, arrays and CasADi symbols. Floats out of range raise `UnreachableError`;
    symbols cannot raise and are held inside the range instead.

    Attributes:
        theta_min: least shape angle within the joint limits and the description's range, rad.
        theta_max: greatest one, rad.
        theta_nominal: the description's nominal shape angle, rad.
        reach_min: least reach between theta_min and theta_max, m.
        reach_max: greatest one, m.
        reach_nominal: reach at the nominal shape angle, m.
        described: the description's own range of theta, rad, which the joint limits may cut short.
        coefficients: (A, B, C) of r = A + B cos(theta) + C sin(theta) where that is exact, else None.
    """

    def __init__(self, robot: Robot) -> None:
        posture = robot.description.posture
        self._name, self._angle = robot.name, f"shape angle {{}} of '{robot.name}'"
        self._offset, self._slope = posture.offset, posture.slope
        self.described = (posture.theta_min, posture.theta_max)
        self.theta_nominal = posture.theta_nominal
        self.theta_min, self.theta_max, self._limits = _within_joint_limits(robot)
        geometry = _averaged_reach(robot)
        self._rigid = robot.n_joints == 0
        if self._rigid:  # one posture, one reach
            self.coefficients = (geometry(self.theta_nominal), 0.0, 0.0)
            self.reach_min = self.reach_max = self.reach_nominal = self.coefficients[0]
            self._falling = False
            return
        self.coefficients = fit_circle(geometry, *self.described)
        if self.coefficients is None:
            low, high = self.described
            self._forward = fit_chebyshev(geometry, low, high)
            self._derivative = chebyshev.chebder(self._forward) * 2.0 / (high - low)
        grid = np.linspace(self.theta_min, self.theta_max, 201)
        reach = np.array([self.reach(theta) for theta in grid])
        steps = np.diff(reach)
        if np.ptp(reach) < _STILL:
            raise DescriptionError(
                f"the joints of '{robot.name}' ({', '.join(robot.description.shape_joints)}) do not move its "
                f"tip ahead in its family of postures: the reach stays {reach[0]:.4g} m"
            )
        if not (np.all(steps > 0.0) or np.all(steps < 0.0)):
            turning = grid[np.argmax(reach) if steps[0] > 0.0 else np.argmin(reach)]
            raise DescriptionError(
                f"reach of '{robot.name}' turns back at theta = {turning:.3f} rad, so a reach does not name "
                "one posture; "
                f"narrow posture.theta_min .. theta_max ({self.theta_min:.4g} .. {self.theta_max:.4g} rad)"
            )
        self._falling = bool(steps[0] < 0.0)
        self.reach_min, self.reach_max = float(reach.min()), float(reach.max())
        self.reach_nominal = self.reach(self.theta_nominal)
        if self.coefficients is None:
            self._inverse = self._fit_inverse(grid, reach)

    def joint_angles(self, theta: Any) -> Any:
        """Joint angles q = offset + slope theta: (nq,) rad, (..., nq) for an array, nq x 1 in CasADi."""
        inside = within(theta, (self.theta_min, self.theta_max), self._angle, "rad", self._limits)
        if is_symbolic(theta):
            return ca.DM(self._offset) + ca.DM(self._slope) * inside
        return self._offset + self._slope * np.asarray(inside)[..., None]

    def reach(self, theta: Any) -> Any:
        """Reach r in m at the shape angle theta, over the description's range whatever the joint limits."""
        return self._series(theta, 0)

    def slope(self, theta: Any) -> Any:
        """dr/dtheta in m/rad."""
        return self._series(theta, 1)

    def shape_angle(self, reach: Any) -> Any:
        """The shape angle theta in rad that gives a reach in m.

        Raises:
            UnreachableError: the reach is outside of reach_min .. reach_max.
        """
        symbolic = is_symbolic(reach)
        angles = f"shape angle {self.theta_min:.4g} .. {self.theta_max:.4g} rad"
        value = within(reach, (self.reach_min, self.reach_max), f"reach {{}} of '{self._name}'", "m", angles)
        if self._rigid:
            return ca.SX(self.theta_nominal) if symbolic else _number(0.0 * value + self.theta_nominal)
        if self.coefficients is None:
            return self._invert_series(value)
        # r = A + D cos(theta - phi): theta is on the falling half of the cosine, or on the rising one.
        A, B, C = self.coefficients
        D, phi = math.hypot(B, C), math.atan2(C, B)
        cosine = (value - A) / D
        turn = ca.acos(clip(cosine, -1.0, 1.0)) if symbolic else np.arccos(np.clip(cosine, -1.0, 1.0))
        return _number(phi + turn if self._falling else phi - turn)

    def _invert_series(self, reach: Any) -> Any:
        """The inverse polynomial, made exact by Newton steps on the forward one."""
        theta = evaluate_chebyshev(self._inverse, self.reach_min, self.reach_max, reach)
        for _ in range(_NEWTON_STEPS):
            error = evaluate_chebyshev(self._forward, *self.described, theta) - reach
            theta = theta - error / evaluate_chebyshev(self._derivative, *self.described, theta)
        return _number(theta)

    def _fit_inverse(self, thetas: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """The inverse polynomial; `thetas` and `reach` are a table of the forward one, (k,) each."""
        order = np.argsort(reach)

        def invert(wanted: float) -> float:
            theta = float(np.interp(wanted, reach[order], thetas[order]))
            for _ in range(_NEWTON_STEPS + 2):
                error = float(evaluate_chebyshev(self._forward, *self.described, theta)) - wanted
                theta -= error / float(evaluate_chebyshev(self._derivative, *self.described, theta))
            return min(max(theta, self.theta_min), self.theta_max)

        return fit_chebyshev(invert, self.reach_min, self.reach_max)

    def _series(self, theta: Any, order: int) -> Any:
        """Reach (order 0) or its slope (order 1) at a theta in the description's range."""
        angle = within(theta, self.described, self._angle, "rad", "posture.theta_min, theta_max")
        if self.coefficients is None:
            series = self._derivative if order else self._forward
            return _number(evaluate_chebyshev(series, *self.described, angle))
        A, B, C = self.coefficients
        cos, sin = (ca.cos, ca.sin) if is_symbolic(theta) else (np.cos, np.sin)
        return _number(C * cos(angle) - B * sin(angle) if order else A + B * cos(angle) + C * sin(angle))


def _number(value: Any) -> Any:
    return float(value) if not is_symbolic(value) and np.ndim(value) == 0 else value


def _within_joint_limits(robot: Robot) -> tuple[float, float, str]:
    """The part of the described range of theta within the joint limits, and what bounds it, in words."""
    posture = robot.description.posture
    low, high = posture.theta_min, posture.theta_max
    bounds = ["posture.theta_min", "posture.theta_max"]
    for name, offset, slope, *limits in zip(
        robot.description.shape_joints, posture.offset, posture.slope, *robot.joint_limits(), strict=True
    ):
        if slope == 0.0:
            continue
        ends = sorted((limit - offset) / slope for limit in limits)
        if ends[0] > low:
            low, bounds[0] = ends[0], f"limits of {name}"
        if ends[1] < high:
            high, bounds[1] = ends[1], f"limits of {name}"
    if not low <= posture.theta_nominal <= high:
        raise DescriptionError(
            f"the joint limits of '{robot.name}' leave the shape angles {low:.4g} .. {high:.4g} rad, without "
            f"posture.theta_nominal = {posture.theta_nominal:.4g} rad"
        )
    return float(low), float(high), f"{bounds[0]}, {bounds[1]}"


def _averaged_reach(robot: Robot) -> Callable[[float], float]:
    """Reach as a function of theta, averaged over the vectoring angles.

    The centre of gravity is linear in the sine and cosine of each vectoring angle, so two opposite angles
    average a turn.
    """
    posture = robot.description.posture
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    state = robot.model(q, psi)
    d = state.tip_root - state.cog_root
    along = ca.Function(
        "along", [q, psi], [d[0] * ca.cos(state.tip_heading) + d[1] * ca.sin(state.tip_heading)]
    )

    def reach(theta: float) -> float:
        angles = posture.offset + posture.slope * theta
        opposite = [float(along(angles, np.full(robot.n_vectoring, turn))) for turn in (0.0, math.pi)]
        return 0.5 * sum(opposite)

    return reach
