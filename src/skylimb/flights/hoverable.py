"""Whether the nominal postures of a flight leave the rotors enough; where they do not, no flight begins."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np

from skylimb.control.controller import Controller
from skylimb.control.needs import needs_of
from skylimb.errors import ConfigError
from skylimb.experiments.experiment import Experiment
from skylimb.missions.posture import PosturePlan, posture_plan
from skylimb.planning.joint_torque import held_shares, rest_function
from skylimb.planning.posture_limits import nearest_posture, weakest_margin
from skylimb.planning.posture_path import PostureConfig
from skylimb.planning.posture_rehearsal import rehearse
from skylimb.planning.vectoring import ONLINE
from skylimb.planning.vectoring_merit import merit_function
from skylimb.planning.vectoring_step import RATE
from skylimb.robots.model import Robot

_ROUNDING = 2e-3
"""N m by which the margin of the search may be too large."""

_SAME = 1e-3
"""Postures closer than this in every joint are one, rad."""


def require_hoverable(experiment: Experiment, robot: Robot, controller: Controller) -> None:
    """Raise a `ConfigError` when some nominal posture leaves less than `posture.margin`.

    The vectoring angles are those that the flight begins with, or goes through; a controller that plans them
    in flight is rehearsed. Margins are those where the servos hold the joints. The message names the torque
    or the rotor, the posture as commanded, and the nearest posture that leaves enough. A posture on the way
    in which a servo of the shape joints cannot hold its joint is refused as well.
    """
    posture = experiment.posture
    # A configuration made in Python may hold lists.
    fixed = replace(posture, waypoints=tuple(tuple(way) for way in posture.waypoints))
    _require(fixed, robot, needs_of(controller).vectoring)


@functools.lru_cache(maxsize=64)
def _require(posture: PostureConfig, robot: Robot, purpose: str) -> None:
    """Once for all flights that differ in nothing else."""
    plan = posture_plan(posture, robot, purpose)
    times = np.arange(0.0, plan.duration + 1.0 / RATE, 1.0 / RATE)
    q, psi = plan.joint_angles(times), plan.vectoring_angles(times)
    if purpose == ONLINE:
        psi = rehearse(robot, q, psi[0]).vectoring_angles
    rest = rest_function(robot).map(len(times))(q.T, psi.T)
    margins = merit_function(robot).map(len(times))(rest, psi.T)[1].full().ravel()
    worst = int(np.argmin(np.nan_to_num(margins, nan=-np.inf)))
    if not margins[worst] >= posture.margin - _ROUNDING:
        raise ConfigError(_refusal(robot, plan, (times[worst], q[worst], psi[worst]), posture.margin))
    if posture.waypoints:
        _require_servos(robot, times, q, psi)


def _require_servos(robot: Robot, times: np.ndarray, q: np.ndarray, psi: np.ndarray) -> None:
    """Refuse postures in which rotors that push against each other bend a joint more than its servo holds."""
    shares = np.array([held_shares(robot, *angles) for angles in zip(q, psi, strict=True)])
    if np.max(shares, initial=0.0) <= 1.0:
        return
    row, joint = np.unravel_index(int(np.argmax(shares)), shares.shape)
    most = robot.description.shape_servo.torque_limit
    raise ConfigError(
        f"the servo of joint '{robot.description.shape_joints[joint]}' of '{robot.name}' must hold "
        f"{shares[row, joint] * most:.3g} N m at q = {np.round(q[row], 3).tolist()} rad, {times[row]:.1f} s "
        f"after posture.waypoints begin, and has {most:g} N m; rotors push against each other there, so go "
        "round that posture"
    )


def _refusal(
    robot: Robot, plan: PosturePlan, where: tuple[float, np.ndarray, np.ndarray], least: float
) -> str:
    time, q, psi = where
    name, margin = weakest_margin(robot, rest_function(robot)(q, psi).full().ravel(), psi)
    nearest = nearest_posture(robot, q, psi, least)
    if nearest is None:
        instead = "no posture near it leaves more"
    elif np.allclose(nearest, q, atol=_SAME):
        instead = "other vectoring angles leave it there, so come to it another way"
    else:
        instead = f"the nearest posture that leaves it is {np.round(nearest, 3).tolist()} rad"
    when = f", {time:.1f} s after posture.waypoints begin," if plan.duration > 0.0 else ""
    return (
        f"'{robot.name}' has a {name} margin of {margin:.3g} N m at q = {np.round(q, 3).tolist()} rad{when} "
        f"below {least:g} N m (posture.margin); {instead}"
    )
