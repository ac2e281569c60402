"""What a user's message asks of the hovering robot: checked, bounded, and turned into targets."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skylimb.apps.ros1.limits import FlightLimits
from skylimb.apps.ros1.messages import Joints, Nav, NavMode, Path, Pose
from skylimb.apps.ros1.targets import Place, Targets, duration_of
from skylimb.base.errors import UnreachableError
from skylimb.base.rotations import rotation_from_quaternion, rpy_from_rotation
from skylimb.control.planning.posture import ReachFamily, posture_family
from skylimb.flight.realtime.watchdog import BEYOND
from skylimb.robots.model import Robot

Wish = Pose | Path | Nav | Joints

OFF_FAMILY = 0.05
"""How far wanted joint angles may be from the nearest posture that the robot is flown in, rad."""

_POSITION = (NavMode.POSITION, NavMode.POSITION_VELOCITY)
_SOON = 0.01
"""Least time to a target pose's stamp for the stamp to count, s."""


class Refused(NamedTuple):
    """Why a wish is not fulfilled."""

    why: str


class Wishes:
    """Turns wishes into targets.

    Args:
        robot: what flies.
        limits: of a target.
    """

    def __init__(self, robot: Robot, limits: FlightLimits) -> None:
        self._limits = limits
        self._names, self._family = robot.description.shape_joints, posture_family(robot)
        posture = robot.description.posture
        self._offset, self._slope = np.asarray(posture.offset), np.asarray(posture.slope)

    def fulfilled(self, targets: Targets, wish: Wish, now: float, stamp_offset: float) -> Targets | Refused:
        """The targets that a wish leads to, or why it is refused.

        Args:
            targets: of now.
            wish: of a user.
            now: s.
            stamp_offset: what has to be added to a wish's stamp for our clock, s.
        """
        here = targets.at(now)[0].place
        match wish:
            case Pose():
                return self._pose(targets, here, wish, now, wish.stamp + stamp_offset)
            case Path():
                return self._path(targets, here, wish, now)
            case Nav():
                return self._nav(targets, here, wish, now)
            case Joints():
                theta = self.shape_angle(wish, here.theta)
                if isinstance(theta, Refused):
                    return theta
                there = here._replace(theta=theta)
                return targets.go(there, now, duration_of(here, there, self._limits))

    def shape_angle(self, wish: Joints, theta: float) -> float | Refused:
        """The shape angle whose posture has some joint angles; those not named stay.

        Args:
            wish: angles by name, or all of them without names.
            theta: of the present posture, rad.
        """
        if len(self._names) == 0:
            return Refused("this robot has no joints to move")
        wanted = np.asarray(self._family.joint_angles(theta), dtype=float).copy()
        names = wish.names or self._names
        joints = {
            name: angle for name, angle in zip(names, wish.angles, strict=False) if "gimbal" not in name
        }
        unknown = sorted(joints.keys() - set(self._names))
        if len(names) != len(wish.angles) or len(set(names)) != len(names):
            return Refused(f"{len(wish.angles)} angles for {len(set(names))} joints")
        if unknown:
            return Refused(f"no joint is called {unknown[0]!r}; the joints are {', '.join(self._names)}")
        for index, name in enumerate(self._names):
            wanted[index] = joints.get(name, wanted[index])
        if not _sane(wanted):
            return Refused("a joint angle is no number")
        return _nearest(self._family, wanted, self._offset, self._slope)

    def _pose(self, targets: Targets, here: Place, wish: Pose, now: float, due: float) -> Targets | Refused:
        there = self._place(here, wish)
        if isinstance(there, Refused):
            return there
        least, left = duration_of(here, there, self._limits), due - now
        # A stamp that leaves less time than the way needs is one of "now".
        return targets.go(there, now, left if math.isfinite(left) and left > max(least, _SOON) else least)

    def _path(self, targets: Targets, here: Place, wish: Path, now: float) -> Targets | Refused:
        places, before = list[Place](), here
        for pose in wish.poses:
            place = self._place(before, pose)
            if isinstance(place, Refused):
                return place
            places.append(place)
            before = place
        if not places:
            return Refused("a path without poses")
        out = targets.go(places[0], now, duration_of(here, places[0], self._limits))
        for start, end in pairwise(places):
            out = out.then(end, duration_of(start, end, self._limits))
        return out

    def _place(self, here: Place, pose: Pose) -> Place | Refused:
        """The place that a pose names: its position, and its yaw; roll and pitch are the robot's own."""
        turn = np.asarray(pose.quaternion, dtype=float)
        size = float(np.linalg.norm(turn)) if _sane(turn) else 0.0
        if abs(size - 1.0) > 0.1:
            return Refused("its orientation is no unit quaternion")
        yaw = float(rpy_from_rotation(rotation_from_quaternion(turn / size))[2])
        return self._bounded(here, here._replace(position=np.asarray(pose.position, dtype=float), yaw=yaw))

    def _bounded(self, here: Place, there: Place) -> Place | Refused:
        limits = self._limits
        if not _sane(np.array([*there.position, there.yaw])):
            return Refused("its position is no number")
        if float(np.linalg.norm(there.position - here.position)) > limits.farthest:
            return Refused(f"it is more than {limits.farthest:g} m away")
        if there.position[2] < limits.lowest:
            return Refused(f"its height {there.position[2]:.2f} m is below {limits.lowest:g} m")
        return there

    def _nav(self, targets: Targets, here: Place, wish: Nav, now: float) -> Targets | Refused:
        limits = self._limits
        numbers = np.array([*wish.position, *wish.velocity, wish.yaw, wish.yaw_rate], dtype=float)
        if not _sane(numbers):
            return Refused("it holds something that is no number")
        modes = (wish.xy_mode, wish.z_mode, wish.yaw_mode)
        if any(mode in (NavMode.ACCELERATION, NavMode.GPS) or mode > NavMode.GPS for mode in modes):
            return Refused("its mode is neither a position nor a velocity")
        if NavMode.VELOCITY in modes:
            velocity = self._velocity(here, wish)
            rate = np.clip(wish.yaw_rate, -limits.turn_speed, limits.turn_speed)
            rate = float(rate) if wish.yaw_mode == NavMode.VELOCITY else 0.0
            ahead = here.position + limits.nav_timeout * velocity
            bounded = self._bounded(here, here._replace(position=ahead))
            if isinstance(bounded, Refused):
                return bounded
            return targets.steer(velocity, rate, now, limits.nav_timeout)
        x, y, z = here.position
        if wish.xy_mode in _POSITION:
            x, y = wish.position[:2]
        if wish.z_mode in _POSITION:
            z = wish.position[2]
        yaw = wish.yaw if wish.yaw_mode in _POSITION else here.yaw
        there = self._bounded(here, here._replace(position=np.array([x, y, z], dtype=float), yaw=yaw))
        if isinstance(there, Refused):
            return there
        return targets.go(there, now, duration_of(here, there, limits, limits.nav_speed))

    def _velocity(self, here: Place, wish: Nav) -> np.ndarray:
        """The velocity in W, no faster than allowed."""
        velocity = np.array(wish.velocity, dtype=float)
        velocity[:2] *= wish.xy_mode == NavMode.VELOCITY
        velocity[2] *= wish.z_mode == NavMode.VELOCITY
        if wish.local:
            cos, sin = math.cos(here.yaw), math.sin(here.yaw)
            velocity[:2] = np.array([[cos, -sin], [sin, cos]]) @ velocity[:2]
        speed = float(np.linalg.norm(velocity))
        return velocity * min(1.0, self._limits.fastest / speed) if speed > 0.0 else velocity


def _sane(numbers: np.ndarray) -> bool:
    """Whether all are numbers that a robot may be told; NaN is not below the bound either."""
    return bool((np.abs(numbers) < BEYOND).all())


def _nearest(
    family: ReachFamily, wanted: np.ndarray, offset: np.ndarray, slope: np.ndarray
) -> float | Refused:
    theta = float(np.clip(slope @ (wanted - offset) / (slope @ slope), family.theta_min, family.theta_max))
    try:
        nearest = np.asarray(family.joint_angles(theta), dtype=float)
    except UnreachableError as error:  # pragma: no cover - theta is within the range
        return Refused(str(error))
    if np.abs(nearest - wanted).max() > OFF_FAMILY:
        near = ", ".join(f"{angle:.2f}" for angle in nearest)
        return Refused(
            f"no vectoring angles are known for that posture; the nearest one flown is ({near}) rad"
        )
    return theta
