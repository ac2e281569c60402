"""What a user's message asks of the hovering robot: checked, bounded, and turned into targets."""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise

import numpy as np

from skylimb.analysis.exchange.messages import WORLD, Joints, Nav, NavMode, Path, Pose
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.references import theta_of
from skylimb.apps.ros.targets import Place, RefusedError, Targets, duration_of
from skylimb.base.rotations import rot_z, rotation_from_quaternion, rpy_from_rotation
from skylimb.control.estimation.gates import BEYOND
from skylimb.control.planning.posture import posture_family
from skylimb.robots.model import Robot

OFF_FAMILY = 0.05
"""How far joint angles may be from the nearest posture of the family, or from a joint's end, rad."""

MOST_POSES = 200
"""Of a path: what is asked for is looked at within a tick."""

LONGEST_WAY = 300.0
"""Seconds that a pose's stamp may lie ahead: a robot would creep by the stamp of another clock, unasked."""

_POSITION = (NavMode.POSITION, NavMode.POSITION_VELOCITY)
_MODES = (NavMode.NO, NavMode.VELOCITY, *_POSITION)
_SOON = 0.01
"""Least time to a target pose's stamp for the stamp to count, s."""


class Requests:
    """Turns requests into targets.

    Args:
        robot: what flies.
        limits: of a target.
    """

    def __init__(self, robot: Robot, limits: FlightLimits) -> None:
        self._robot, self._limits = robot, limits
        self._names, self._family = robot.description.shape_joints, posture_family(robot)

    def targets(
        self, targets: Targets, request: Pose | Path | Nav, now: float, stamp_offset: float
    ) -> Targets:
        """The targets that a request leads to.

        Args:
            targets: of now.
            request: of a user.
            now: s.
            stamp_offset: what has to be added to a request's stamp for our clock, s.

        Raises:
            RefusedError: with the reason, when it cannot be.
        """
        here = targets.at(now)[0].place
        match request:
            case Pose():
                there = self._place(here, request)
                least, left = duration_of(here, there, self._limits), request.stamp + stamp_offset - now
                # A stamp that leaves less time than the way needs is one of "now".
                in_time = math.isfinite(left) and left > max(least, _SOON)
                if in_time and left > LONGEST_WAY:
                    raise RefusedError(
                        f"its stamp lies {left:.3g} s ahead (at most {LONGEST_WAY:g}): the sender's clock is "
                        "another one; a stamp of 0 means now"
                    )
                return targets.go(there, now, left if in_time else least)
            case Path():
                return self._path(targets, here, request, now)
            case Nav():
                return self._nav(targets, here, request, now)

    def joints(self, request: Joints, present: np.ndarray) -> np.ndarray:
        """The joint angles that are asked for, rad, (nq,); those not named stay.

        Args:
            request: angles by name, or all of them without names.
            present: angles, rad, (nq,).

        Raises:
            RefusedError: for what are no angles of this robot's joints.
        """
        if len(self._names) == 0:
            raise RefusedError("this robot has no joints to move")
        names = request.names or self._names
        if len(names) != len(request.angles):
            raise RefusedError(f"joints and angles are not as many: {len(names)} and {len(request.angles)}")
        if twice := [name for name, count in Counter(names).items() if count > 1]:
            raise RefusedError(f"{min(twice)[:60]!r} is named more than once")
        known = dict(zip(self._names, present.tolist(), strict=True))
        joints = {
            name: angle for name, angle in zip(names, request.angles, strict=True) if "gimbal" not in name
        }
        unknown = sorted(joints.keys() - known.keys())
        if unknown:
            raise RefusedError(
                f"no joint is called {unknown[0][:60]!r}; the joints are {', '.join(self._names)}"
            )
        angles = np.array(list({**known, **joints}.values()))
        if not _sane(angles):
            raise RefusedError("a joint angle is no number")
        low, high = self._robot.joint_limits()
        for name, angle, least, most in zip(self._names, angles, low, high, strict=True):
            if not least - OFF_FAMILY <= angle <= most + OFF_FAMILY:
                raise RefusedError(f"{name} = {angle:.2f} rad is beyond its {least:.2f} .. {most:.2f} rad")
        return np.clip(angles, low, high)

    def in_family(self, joints: np.ndarray, off: float = OFF_FAMILY) -> float | None:
        """The shape angle of joint angles (nq,), rad; None where they are further `off` the family's."""
        family = self._family
        found = float(np.clip(theta_of(self._robot, joints), family.theta_min, family.theta_max))
        nearest = np.asarray(family.joint_angles(found), dtype=float)
        return found if np.abs(nearest - joints).max(initial=0.0) <= off else None

    def _path(self, targets: Targets, here: Place, request: Path, now: float) -> Targets:
        _require_world(request.frame)
        if len(request.poses) > MOST_POSES:
            raise RefusedError(f"it has {len(request.poses)} poses, and at most {MOST_POSES} are flown")
        places = [here]
        for pose in request.poses:
            places.append(self._place(places[-1], pose))
        if len(places) == 1:
            raise RefusedError("a path without poses")
        out = targets.go(places[1], now, duration_of(here, places[1], self._limits))
        for start, end in pairwise(places[1:]):
            out = out.then(end, duration_of(start, end, self._limits))
        return out

    def _place(self, here: Place, pose: Pose) -> Place:
        """The place that a pose names: its position, and its yaw; roll and pitch are the robot's own."""
        _require_world(pose.frame)
        turn = np.asarray(pose.quaternion, dtype=float)
        size = float(np.linalg.norm(turn)) if _sane(turn) else 0.0
        if abs(size - 1.0) > 0.1:
            raise RefusedError("its orientation is no unit quaternion")
        yaw = float(rpy_from_rotation(rotation_from_quaternion(turn / size))[2])
        return self._bounded(here, here._replace(position=np.asarray(pose.position, dtype=float), yaw=yaw))

    def _bounded(self, here: Place, there: Place) -> Place:
        limits = self._limits
        if not _sane(np.array([*there.position, there.yaw])):
            raise RefusedError("its position is no number")
        if float(np.linalg.norm(there.position - here.position)) > limits.farthest:
            raise RefusedError(f"it is more than {limits.farthest:g} m away")
        if outside := limits.outside(there.position):
            raise RefusedError(f"it is beyond the fence: {outside}")
        if there.position[2] < limits.lowest:
            raise RefusedError(f"its height {there.position[2]:.2f} m is below {limits.lowest:g} m")
        return there

    def _nav(self, targets: Targets, here: Place, request: Nav, now: float) -> Targets:
        limits, modes = self._limits, (request.xy_mode, request.z_mode, request.yaw_mode)
        if not _sane(np.array([*request.position, *request.velocity, request.yaw, request.yaw_rate])):
            raise RefusedError("it holds something that is no number")
        if not set(modes) <= set(_MODES):
            raise RefusedError("its mode is neither a position nor a velocity")
        if NavMode.VELOCITY in modes:
            velocity = self._velocity(here, request)
            rate = float(np.clip(request.yaw_rate, -limits.turn_speed, limits.turn_speed))
            rate = rate if request.yaw_mode == NavMode.VELOCITY else 0.0
            self._bounded(here, here._replace(position=here.position + limits.nav_timeout * velocity))
            return targets.steer(velocity, rate, now, limits.nav_timeout)
        fixed = np.array([request.xy_mode in _POSITION] * 2 + [request.z_mode in _POSITION])
        position = np.where(fixed, request.position, here.position)
        yaw = request.yaw if request.yaw_mode in _POSITION else here.yaw
        there = self._bounded(here, here._replace(position=position, yaw=yaw))
        return targets.go(there, now, duration_of(here, there, limits, limits.nav_speed))

    def _velocity(self, here: Place, request: Nav) -> np.ndarray:
        """The velocity in W, no faster than allowed."""
        velocity = np.array(request.velocity, dtype=float)
        velocity[:2] *= request.xy_mode == NavMode.VELOCITY
        velocity[2] *= request.z_mode == NavMode.VELOCITY
        if request.frame == 1:
            velocity = rot_z(here.yaw) @ velocity
        speed = float(np.linalg.norm(velocity))
        return velocity * min(1.0, self._limits.fastest / speed) if speed > 0.0 else velocity


def _require_world(frame: str) -> None:
    """Refuse a target in other axes than those of the world; who names none means these."""
    if frame.strip("/") not in ("", WORLD):
        raise RefusedError(f"it is in the frame {frame[:60]!r}, and targets are in {WORLD!r}")


def _sane(numbers: np.ndarray) -> bool:
    """Whether all are numbers that a robot may be given; NaN is not below the bound either."""
    return bool((np.abs(numbers) < BEYOND).all())
