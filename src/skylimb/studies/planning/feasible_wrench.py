"""What a robot can do in a posture: wrenches at its centre of gravity, and pushes of its tip.

The joints are where they are, the vectoring angles are held, thrusts are within their limits. All of these
sets are then zonotopes or slices of one (`studies.planning.zonotope`):

    wrenches at the centre of gravity      Q lambda
    torque while it hovers                 those of them with the lift m g, whatever the side force
    force while it hovers level            those with no torque
    push of the tip while it hovers level  those that are (m g z + p, r x p)

with r the tip from the centre of gravity, and level that {C} is. A robot of four rotors spans four of the six
directions: with its angles held it has no force to the side while level. How hard it can push when it leans,
moves its vectoring angles, and its servos give way is the question of `robots.equilibrium` (`push_limit`).

The laboratory's two numbers take force and torque each by itself, with thrusts from zero: FCTmin is the
distance of no torque from the nearest face of all torques, FCFmin that of the weight from the nearest face of
all forces.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skylimb.base.errors import ConfigError, UnreachableError
from skylimb.base.rotations import hat, rot_z
from skylimb.control.missions.posture import posture_plan
from skylimb.control.planning.posture_path import PostureConfig
from skylimb.robots.equilibrium import greatest_push
from skylimb.robots.equilibrium_results import TILT, USUAL, Held, NotHeld, Within
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState
from skylimb.studies.planning.zonotope import Polytope, zonotope, zonotope_volume


@dataclass(frozen=True)
class FeasibleWrench:
    """What a robot can do at some joint and vectoring angles.

    Forces and torques are in {C} unless said otherwise. The heading frame is level, its x axis is the tip
    link's; pushes are those of the tip on its surroundings.

    Attributes:
        robot: whose rotors have limits.
        joint_angles: q, rad, (nq,).
        vectoring_angles: psi, rad, (nv,).
    """

    robot: Robot
    joint_angles: np.ndarray
    vectoring_angles: np.ndarray

    @cached_property
    def state(self) -> RobotState:
        """The model at these angles."""
        return self.robot.at(self.joint_angles, self.vectoring_angles)

    @property
    def hover(self) -> np.ndarray:
        """The wrench that carries the robot: (0, 0, m g, 0, 0, 0), N and N m."""
        return np.array([0.0, 0.0, self.robot.weight, 0.0, 0.0, 0.0])

    @cached_property
    def length(self) -> float:
        """Root mean square lever of the rotors, m: a torque counts as the force that makes it there."""
        levers = np.linalg.norm(self.state.allocation_C[3:], axis=0)
        return float(np.sqrt(np.mean(levers**2)))

    @cached_property
    def wrenches(self) -> Polytope:
        """All Q lambda, N: torques are divided by `length`."""
        return zonotope(self._scale[:, None] * self.state.allocation_C, *self.robot.thrust_limits())

    @property
    def volume(self) -> float:
        """Of `wrenches`, in as many dimensions as they have."""
        return zonotope_volume(self._scale[:, None] * self.state.allocation_C, *self.robot.thrust_limits())

    @cached_property
    def hover_torques(self) -> Polytope | None:
        """Torques, N m, that it can give while the lift is the weight; the side force is what comes of it."""
        lifting = zonotope(self.state.allocation_C[2:], *self.robot.thrust_limits())
        return lifting.section(self.hover[2:], np.eye(4)[:, 1:])

    @cached_property
    def level_forces(self) -> Polytope | None:
        """Forces, N, beyond the weight that it can give without torque and without tilting."""
        return self._level(np.vstack([np.eye(3), np.zeros((3, 3))]))

    @cached_property
    def level_pushes(self) -> Polytope | None:
        """Pushes of the tip, N, in the heading frame, that it can hold without tilting."""
        to_heading = rot_z(self.state.tip_heading)
        return self._level(np.vstack([to_heading, hat(self.state.tip_C) @ to_heading]))

    @property
    def fct_min(self) -> float:
        """FCTmin: the torque that it can give about every axis, whatever the force, from thrust 0, N m."""
        return self._from_zero(slice(3, 6))

    @property
    def fcf_min(self) -> float:
        """FCFmin: the force beside the weight that it can give in every direction, whatever the torque, N."""
        return self._from_zero(slice(3))

    def margin(self, wrench: np.ndarray) -> float:
        """Distance of a wrench (6,), N and N m, beyond hover to what cannot be given, N; negative beyond it.

        Torques count as the force that makes them at `length`. 0 or less for robots that cannot give wrenches
        in all six directions.
        """
        return self.wrenches.margin(self._scale * (self.hover + wrench))

    def times(self, wrench: np.ndarray) -> float:
        """How many times a wrench (6,), N and N m, can be given beside hover; NaN where it cannot hover."""
        return self.wrenches.reach(self._scale * self.hover, self._scale * np.asarray(wrench, dtype=float))

    def push(self, direction: np.ndarray, within: Within = USUAL) -> Held | NotHeld:
        """The greatest push of the tip along a direction (3,) of the heading frame, and what ends it.

        The joint angles count as commanded.

        Raises:
            ConfigError: for a direction that is none.
        """
        way = unit_vector(direction)
        return greatest_push(self.robot, self.joint_angles, self.vectoring_angles, way, within)

    @cached_property
    def _scale(self) -> np.ndarray:
        return np.array([1.0, 1.0, 1.0, *[1.0 / self.length] * 3])

    def _level(self, axes: np.ndarray) -> Polytope | None:
        """The slice of `wrenches` through hover along some axes (6, 3)."""
        return self.wrenches.section(self._scale * self.hover, self._scale[:, None] * axes)

    def _from_zero(self, rows: slice) -> float:
        """What is left every way beside hover of some rows of the wrench, with thrusts from zero."""
        upper = self.robot.thrust_limits()[1]
        given = zonotope(self.state.allocation_C[rows], np.zeros_like(upper), upper)
        return max(given.margin(self.hover[rows]), 0.0)


def feasible_wrench(
    robot: Robot, joint_angles: np.ndarray | None = None, vectoring_angles: np.ndarray | None = None
) -> FeasibleWrench:
    """What a robot can do in a posture.

    Args:
        robot: any.
        joint_angles: q, rad, (nq,); by default the nominal posture.
        vectoring_angles: psi, rad, (nv,); by default those with which a flight gets there.

    Raises:
        ConfigError: the wrong number of angles.
        UnreachableError: joint angles beyond their limits.
        AllocationError: at these angles the rotors cannot carry the robot without torque.
    """
    q = robot.nominal_posture() if joint_angles is None else np.asarray(joint_angles, dtype=float)
    _require_within_limits(robot, q)
    psi = _vectoring_angles(robot, q) if vectoring_angles is None else np.asarray(vectoring_angles)
    found = FeasibleWrench(robot, q, psi.astype(float))
    _ = found.state  # refuses wrong numbers of angles, and angles that carry nothing
    return found


def _require_within_limits(robot: Robot, q: np.ndarray) -> None:
    lower, upper = robot.joint_limits()
    if q.shape != lower.shape:
        raise ConfigError(f"joint_angles = {q.tolist()} of '{robot.name}' must be {len(lower)} numbers (rad)")
    for name, angle, low, high in zip(robot.description.shape_joints, q, lower, upper, strict=True):
        if not low - 1e-9 <= angle <= high + 1e-9:
            raise UnreachableError(
                f"joint '{name}' = {angle:g} rad is outside of its limits, {low:g} .. {high:g} rad"
            )


def _vectoring_angles(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Those of the nominal posture, taken along the way to q as a flight through that posture would."""
    waypoints = (tuple(map(float, q)),) if robot.n_joints else ()
    plan = posture_plan(PostureConfig(waypoints=waypoints, hold=0.0), robot)
    return plan.vectoring_angles(np.array([plan.duration]))[0]


def push_limit(
    robot: Robot,
    direction: np.ndarray,
    joint_angles: np.ndarray | None = None,
    vectoring_angles: np.ndarray | None = None,
    *,
    tilt: float = TILT,
    moves: float = 0.0,
    margin: float = 0.0,
) -> Held | NotHeld:
    """How hard the robot can push here, this way: the greatest push of its tip at rest, and what ends it.

    It is the best of searches from several starts. With angles held, linear programmes over all leans agree
    (tests/robots/test_equilibrium.py); with angles that move it is a push that can be held, and a harder one
    is not ruled out. In flight some torque has to be left for control.

    Args:
        robot: any.
        direction: of the push, (3,), in the level frame whose x axis is the heading; of any length.
        joint_angles: q as commanded, rad; by default the nominal posture.
        vectoring_angles: psi, rad; by default those with which a flight gets there.
        tilt: of the measured link from the vertical, the greatest, rad; 0 for level.
        moves: how far each vectoring angle may move, rad; `math.inf` for all of its travel.
        margin: torque that has to be left about any axis, N m.

    Returns:
        `Held`, whose `force` is the greatest, N; `NotHeld` where the robot cannot rest there at all.

    Raises:
        ConfigError: as `feasible_wrench`, or for a direction that is none.
    """
    return feasible_wrench(robot, joint_angles, vectoring_angles).push(direction, Within(tilt, moves, margin))


def unit_vector(direction: np.ndarray) -> np.ndarray:
    """A direction (3,) of length 1.

    Raises:
        ConfigError: where it is none.
    """
    vector = np.asarray(direction, dtype=float)
    size = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
    if not np.isfinite(size) or size == 0.0:
        raise ConfigError(f"direction = {vector.tolist()} must be three finite numbers, not all zero")
    return vector / size
