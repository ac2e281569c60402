"""Vectoring angles psi(theta) along the posture family, as smooth polynomials that never flip.

They are cheap enough for every tick. The search takes seconds, so its result is kept: in a file beside a
robot that comes with the package, else in the user's cache folder (`planning.vectoring_files`).
"""

from __future__ import annotations

import contextlib
import functools
import logging
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.errors import AllocationError, ConfigError
from skylimb.base.keys import choice_problem
from skylimb.control.planning import vectoring_files
from skylimb.control.planning.hover_margins import hover_margins_function
from skylimb.control.planning.posture import posture_family, standing
from skylimb.control.planning.series import within
from skylimb.control.planning.vectoring_criteria import CONTACT, TORQUE, VectoringCriteria
from skylimb.control.planning.vectoring_search import NoPathError, evaluate
from skylimb.control.planning.vectoring_step import first_vectoring
from skylimb.robots import Robot
from skylimb.symbolic import is_symbolic

PURPOSES = {criteria.purpose: criteria for criteria in (TORQUE, CONTACT)}
_log = logging.getLogger(__name__)
_SPARED = 0.8
"""Share of their torque that servos keep to where the angles of most torque ask for more than all of it."""
ONLINE = "online"
"""Purpose of angles that a controller plans in flight: the table has those of the nominal posture only."""


class VectoringTable:
    """psi(theta) for one robot.

    Attributes:
        coefficients: (n_vectoring, degree + 1) Chebyshev coefficients over theta_min .. theta_max, rad.
        theta_min: start of the range of theta, rad.
        theta_max: end of it, rad.
        digest: of what the table was found for.
    """

    def __init__(
        self, robot: Robot, coefficients: np.ndarray, digest: str, span: tuple[float, float] | None = None
    ) -> None:
        self._angle = f"shape angle {{}} of '{robot.name}'"
        posture = robot.description.posture
        self.coefficients = coefficients
        self.theta_min, self.theta_max = span or (posture.theta_min, posture.theta_max)
        self.digest = digest

    def angles(self, theta: Any) -> Any:
        """Vectoring angles psi: (nv,) rad, or (..., nv) for an array of theta; nv x 1 in CasADi.

        Symbols are held inside theta_min .. theta_max; numbers outside of it raise `UnreachableError`.
        """
        return self._series(theta, 0)

    def slope(self, theta: Any) -> Any:
        """dpsi/dtheta in rad/rad, shaped as `angles`."""
        return self._series(theta, 1)

    def _series(self, theta: Any, order: int) -> Any:
        low, high = ends = self.theta_min, self.theta_max
        inside = within(theta, ends, self._angle, "rad", "where vectoring angles are known")
        if not is_symbolic(theta):
            return evaluate(self.coefficients, low, high, inside, order)
        # Powers of x by Horner's rule cost half of Clenshaw's recurrence; at this degree they are as exact.
        x = (2.0 * inside - (low + high)) / (high - low)
        rows = []
        for series in np.polynomial.chebyshev.chebder(self.coefficients, order, axis=1):
            powers = np.polynomial.chebyshev.cheb2poly(series) * (2.0 / (high - low)) ** order
            value = powers[-1]
            for power in powers[-2::-1]:
                value = value * x + power
            rows.append(value)
        return ca.vertcat(*rows) if rows else ca.SX(0, 1)


def vectoring_table(robot: Robot, purpose: str = "torque", *, cache: bool = True) -> VectoringTable:
    """The robot's table: the one that comes with it, a cached one, or a newly found one.

    "torque" has the most guaranteed control torque, without hover tilt, over all described postures.
    "contact" keeps a push across the surface out of the pressing force (`vectoring_criteria.CONTACT`), for up
    to 0.1 rad of hover tilt and some torque, over the postures within the joint limits. A tip that points up
    presses along z, where nothing leaks whatever the angles. Its table is that of a tip at the foot of its
    stem: with the angles for torque the thrusts that tilt hydrus_xi_quad push the other way first. That is a
    zero of the side force in the right half plane at 12 rad/s, as fast as the attitude loop of `following`,
    which then loses the robot in free flight. With the angles for contact the zero is at 17 rad/s, about the
    axis where the loop is slower.

    A robot that is flown as pairs of fixed rotors takes off with the angles of its nominal posture's hover,
    whatever the purpose; its laws find the others in flight.

    "online" is for a controller that plans its angles in flight (`planning.vectoring_step`): the same angles,
    the best of the nominal posture, at every theta. Nothing is searched but these.

    Args:
        robot: any robot.
        purpose: "torque", "contact" or "online".
        cache: False searches anew and neither reads nor writes a file.

    Raises:
        ConfigError: another purpose.
        AllocationError: no continuous path of vectoring angles keeps the purpose's criteria over its range,
            or none let it hover in its nominal posture.
    """
    robot = standing(robot, purpose)
    if robot.turned is not None:
        return VectoringTable(robot, _of_pairs(robot)[:, None], ONLINE)
    if purpose == ONLINE:
        return VectoringTable(robot, first_vectoring(robot).angles[:, None], ONLINE)
    criteria, coefficients, digest = _found(robot, _criteria(purpose), cache=cache)
    return VectoringTable(robot, coefficients, digest, criteria.span(robot))


@functools.lru_cache(maxsize=16)
def nominal_posture(robot: Robot, purpose: str = "torque") -> tuple[np.ndarray, np.ndarray]:
    """Joint angles q (nq,) and vectoring angles psi (nv,) of a robot's nominal posture, rad.

    Args:
        robot: any robot.
        purpose: of the vectoring angles, as of `vectoring_table`.
    """
    family = posture_family(standing(robot, purpose))
    angles = family.joint_angles, vectoring_table(robot, purpose).angles
    q, psi = (np.asarray(of(family.theta_nominal), dtype=float) for of in angles)
    return q, psi


def _of_pairs(robot: Robot) -> np.ndarray:
    """Vectoring angles of the hover of a robot that is flown as pairs of fixed rotors, rad, (nv,)."""
    assert robot.turned is not None
    pairs = robot.pairs.at(robot.nominal_posture(), np.zeros(0))
    return robot.turned.command(pairs.hover_thrusts)[1]


def vectoring_file(robot: Robot, purpose: str = "torque") -> tuple[str, str] | None:
    """Name and text of the file that brings a robot's table along, to lie beside its flight TOML.

    None for angles that are planned in flight, and of a robot that is flown as pairs of fixed rotors.
    """
    if purpose == ONLINE or robot.turned is not None:
        return None
    robot = standing(robot, purpose)
    criteria, coefficients, digest = _found(robot, _criteria(purpose))
    text = vectoring_files.table_text(coefficients, digest, robot, criteria)
    return vectoring_files.table_file(criteria), text


def _criteria(purpose: str) -> VectoringCriteria:
    problem = choice_problem(purpose, (*PURPOSES, ONLINE))
    if problem is not None:
        raise ConfigError(f"purpose = {purpose!r} {problem}")
    return PURPOSES[purpose]


def _found(
    robot: Robot, criteria: VectoringCriteria, *, cache: bool = True
) -> tuple[VectoringCriteria, np.ndarray, str]:
    """The criteria that a table keeps, its coefficients and its digest.

    Where the angles of most torque ask more of a bending joint's servo than it has in the nominal posture,
    those of a search that spares the servos are taken, if it finds any. Where no angles keep a push across
    the surface out of the pressing force, those of most torque are taken: the laws feel what leaks.
    """
    level = _level(robot, criteria)
    try:
        found = criteria, *vectoring_files.find_coefficients(level, criteria, cache=cache)
    except NoPathError as error:
        if not criteria.about_contact:
            raise
        _say(f"{error}; it flies with those of most torque")
        return _found(robot, TORQUE, cache=cache)
    if not robot.n_vectoring or not robot.n_joints:
        return found
    posture = robot.description.posture
    q = posture.offset + posture.slope * posture.theta_nominal
    psi = evaluate(found[1], *criteria.span(robot), posture.theta_nominal)
    shares = hover_margins_function(robot)(q, psi)[2].full()
    if np.all(np.abs(shares) <= 1.0):
        return found
    sparing = replace(criteria, servos=_SPARED)
    with contextlib.suppress(AllocationError):
        return sparing, *vectoring_files.find_coefficients(level, sparing, cache=cache)
    return found


@functools.lru_cache(maxsize=64)
def _say(words: str) -> None:
    _log.warning(words)


def _level(robot: Robot, criteria: VectoringCriteria) -> Robot:
    """The robot to search angles for: where the tip counts and points up, it is at the foot of its stem."""
    tip = robot.description.tip
    if not criteria.about_contact or tip.stem is None:
        return robot
    along = tip.position - tip.stem
    if abs(along[2]) <= np.hypot(along[0], along[1]):
        return robot
    return Robot(replace(robot.description, tip=replace(tip, position=tip.stem)))
