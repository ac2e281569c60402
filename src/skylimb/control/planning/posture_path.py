"""A path through given postures: joints move from one to the next with quintic timing, and wait at each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from skylimb.base.errors import ConfigError, UnreachableError
from skylimb.base.keys import Key, configuration
from skylimb.control.planning.smooth_step import STEEPEST, quintic
from skylimb.robots.model import Robot


@configuration
class PostureConfig:
    """Postures to go through while the robot holds or follows its path."""

    waypoints: Annotated[
        tuple[tuple[float, ...], ...],
        Key(
            "rad",
            "joint angles of each posture; empty keeps the nominal posture",
            low=-2.0 * math.pi,
            high=2.0 * math.pi,
        ),
    ] = ()
    speed: Annotated[float, Key("rad/s", "greatest joint speed on the way", above=0.0, high=20.0)] = 0.4
    hold: Annotated[float, Key("s", "time at each posture", low=0.0, high=3600.0)] = 2.0
    margin: Annotated[
        float,
        Key(
            "N m",
            "torque that every nominal posture has to leave about any axis while lift and attitude are kept",
            low=0.0,
            high=1e3,
        ),
    ] = 0.0


@dataclass(frozen=True)
class PosturePath:
    """Knots of the path: at `times[i]` (s) the joints are at `postures[i]` (rad)."""

    times: np.ndarray
    postures: np.ndarray

    @property
    def duration(self) -> float:
        """Length of the path, s."""
        return float(self.times[-1])

    def sample(self, t: np.ndarray) -> np.ndarray:
        """Joint angles at times t (k,), still before and after the path; (k, nq), rad."""
        t = np.clip(t, 0.0, self.duration)
        segment = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, max(len(self.times) - 2, 0))
        if len(self.times) < 2:
            return np.repeat(self.postures, len(t), axis=0)
        begin, end = self.times[segment], self.times[segment + 1]
        s = (t - begin) / (end - begin)
        blend, _, _ = quintic(s)
        return self.postures[segment] + blend[:, None] * (self.postures[segment + 1] - self.postures[segment])


def posture_path(config: PostureConfig, robot: Robot, start: np.ndarray) -> PosturePath:
    """The path from `start` (rad, (nq,)) through the postures.

    Raises:
        ConfigError: for a posture with the wrong number of joints, or a speed above the servos'.
        UnreachableError: for a posture beyond the joints' limits.
    """
    fastest = min(robot.description.shape_servos.speed_limit, default=np.inf)
    if config.waypoints and config.speed > fastest:
        raise ConfigError(
            f"posture.speed = {config.speed:g} rad/s is above the joint speed of {robot.name}, "
            f"{fastest:g} rad/s"
        )
    times, postures = [0.0], [np.asarray(start, dtype=float)]
    lower, upper = robot.joint_limits()
    for waypoint in config.waypoints:
        target = np.asarray(waypoint, dtype=float)
        if target.shape != (robot.n_joints,):
            raise ConfigError(
                f"posture.waypoints: {list(waypoint)} has {len(target)} angles; {robot.name} has "
                f"{robot.n_joints} joints"
            )
        if np.any(target < lower - 1e-9) or np.any(target > upper + 1e-9):
            raise UnreachableError(
                f"posture.waypoints: {list(waypoint)} rad is beyond the limits of {robot.name}, "
                f"{lower.tolist()} .. {upper.tolist()} rad"
            )
        way = float(np.max(np.abs(target - postures[-1])))
        if way > 0.0:
            times.append(times[-1] + STEEPEST * way / config.speed)
            postures.append(target)
        if config.hold > 0.0:
            times.append(times[-1] + config.hold)
            postures.append(target)
    return PosturePath(np.array(times), np.array(postures))
