"""The nominal posture of a flight: the robot's own, or a path through the experiment's postures."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from skylimb.base.errors import AllocationError, ConfigError
from skylimb.base.rotations import rot_z
from skylimb.control.planning.posture import posture_family, standing
from skylimb.control.planning.posture_path import PostureConfig, posture_path
from skylimb.control.planning.vectoring import ONLINE, nominal_posture
from skylimb.control.planning.vectoring_path import vectoring_path
from skylimb.robots.flight_check import require_heading
from skylimb.robots.model import Robot

LONGEST = 600.0
"""Longest way through the postures, s: vectoring angles are sought all along it."""

_KNOT = 0.1
"""Time between two knots at which vectoring angles are sought, s."""

_OTHER_WAY = {
    "torque": "go another way there (posture.waypoints)",
    "contact": "from the angles for contact there may be no way where there is one from those for torque "
    '(controller.allocation.vectoring.purpose = "torque"); or go another one (posture.waypoints)',
}
"""What else there is, by the purpose of the angles at the beginning."""


@dataclass(frozen=True)
class PosturePlan:
    """The nominal posture over time, counted from the beginning of the slide.

    Attributes:
        reach: r_ref, m.
        tip: from the centre of gravity to the tip in the level robot whose heading is along x, m, (3,).
        tip_radius: m.
        duration: time that the plan takes, s; 0 for a posture that stays.
        joint_angles: times (k,) -> q (k, nq), rad.
        vectoring_angles: times (k,) -> psi (k, nv), rad.
        tip_heading: times (k,) -> the heading in C less that of the first posture, (k,), rad.
    """

    reach: float
    tip: np.ndarray
    tip_radius: float
    duration: float
    joint_angles: Callable[[np.ndarray], np.ndarray]
    vectoring_angles: Callable[[np.ndarray], np.ndarray]
    tip_heading: Callable[[np.ndarray], np.ndarray]


@functools.lru_cache(maxsize=8)
def _along(robot: Robot, postures: tuple[tuple[float, ...], ...], start: tuple[float, ...]) -> np.ndarray:
    """Vectoring angles along some postures; flights that differ in nothing else share one search."""
    return vectoring_path(robot, np.array(postures), np.array(start))


def posture_plan(config: PostureConfig, robot: Robot, purpose: str = "torque") -> PosturePlan:
    """From the nominal posture through the experiment's, with the vectoring angles that suit each.

    Args:
        config: postures to go through.
        robot: whose.
        purpose: of the vectoring angles in the nominal posture.

    Raises:
        ConfigError: when the way through the postures takes too long, or as `posture_path` does.
        AllocationError: when no vectoring angles lead along it, with what else there is.
    """
    joint_angles, vectoring_angles = nominal_posture(robot, purpose)
    path = posture_path(config, robot, joint_angles)
    if path.duration > LONGEST:
        raise ConfigError(
            f"posture.waypoints: the way through them takes {path.duration:.4g} s; {LONGEST:g} s is the most"
        )
    knots = np.append(np.arange(0.0, path.duration, _KNOT), path.duration)
    vectoring = vectoring_angles[None, :]
    if purpose == ONLINE:
        vectoring = np.repeat(vectoring, len(knots), axis=0)
    elif path.duration > 0.0:
        postures = tuple(map(tuple, path.sample(knots[1:]).tolist()))
        try:
            found = _along(robot, postures, tuple(vectoring_angles.tolist()))
        except AllocationError as error:
            raise AllocationError(f"{error}; {_OTHER_WAY[purpose]}") from error
        vectoring = np.vstack([vectoring_angles, found])
    require_heading(robot, path.sample(knots), vectoring, "on the way through posture.waypoints")
    nominal = robot.at(joint_angles, vectoring_angles)
    # Without jumps by a turn: between two knots one would be a turn of the body.
    headings = np.unwrap(
        [
            float(robot.model(ca.DM(q), ca.DM(psi)).tip_heading)
            for q, psi in zip(path.sample(knots), vectoring, strict=True)
        ]
    )

    return PosturePlan(
        reach=float(posture_family(standing(robot, purpose)).reach_nominal),
        tip=rot_z(-nominal.tip_heading) @ nominal.tip_C,
        tip_radius=robot.description.tip.radius,
        duration=path.duration,
        joint_angles=path.sample,
        vectoring_angles=lambda t: (
            np.array([np.interp(np.clip(t, 0.0, path.duration), knots, angles) for angles in vectoring.T])
            .reshape(robot.n_vectoring, len(t))
            .T
        ),
        tip_heading=lambda t: np.interp(np.clip(t, 0.0, path.duration), knots, headings) - headings[0],
    )
