"""From a target to the reference that a controller flies, and back from a mission's row to a place."""

from __future__ import annotations

import numpy as np

from skylimb.analysis.exchange.frames import LinkFrames, frames_at, frames_function
from skylimb.apps.ros.targets import Place, Target
from skylimb.base.rotations import rot_z
from skylimb.control.missions.reference import Reference
from skylimb.control.planning.posture import posture_family, standing
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.robots.model import Robot


class References:
    """Free-flight references of a robot.

    Args:
        robot: what flies.
        link: whose pose is on the lab's topics.
        template: any reference of its mission: contact axis and reach are taken from it.
        purpose: of the vectoring angles.
    """

    def __init__(self, robot: Robot, link: str, template: Reference, purpose: str) -> None:
        self.robot = standing(robot, purpose)
        self._family, self._table = posture_family(self.robot), vectoring_table(robot, purpose)
        self._frames = frames_function(robot, link)
        self._template = template._replace(
            tare=0.0, align=0.0, adapt=0.0, touch=0.0, wait=0.0, tip_acceleration=np.zeros(3), ahead=()
        )
        self._theta = self._family.theta_nominal
        self._posture = self._made(self._theta)

    def posture(self, theta: float) -> tuple[np.ndarray, np.ndarray, LinkFrames, np.ndarray]:
        """Joint angles, vectoring angles, frames, and tip seen from the centre of gravity at heading 0."""
        if theta != self._theta:
            self._posture, self._theta = self._made(theta), theta
        return self._posture

    def _made(self, theta: float) -> tuple[np.ndarray, np.ndarray, LinkFrames, np.ndarray]:
        theta = float(np.clip(theta, self._family.theta_min, self._family.theta_max))
        q = np.asarray(self._family.joint_angles(theta), dtype=float)
        psi = np.asarray(self._table.angles(theta), dtype=float)
        state = self.robot.at(q, psi)
        return q, psi, frames_at(self._frames, q, psi), rot_z(-state.tip_heading) @ state.tip_C

    def at(self, target: Target) -> Reference:
        """The reference of a target."""
        place = target.place
        q, psi, frames, tip = self.posture(place.theta)
        heading = place.yaw - frames.yaw_in_C + frames.tip_heading
        return self._template._replace(
            position=place.position,
            velocity=target.velocity,
            acceleration=target.acceleration,
            heading=heading,
            joint_angles=q,
            vectoring_angles=psi,
            tip_position=place.position + rot_z(heading) @ tip,
            tip_velocity=target.velocity,
            tip_acceleration=target.acceleration,
        )

    def place_of(self, reference: Reference) -> Place:
        """The place of a mission's row."""
        q = np.asarray(reference.joint_angles, dtype=float)
        frames = frames_at(self._frames, q, np.asarray(reference.vectoring_angles, dtype=float))
        yaw = float(reference.heading) - frames.tip_heading + frames.yaw_in_C
        return Place(np.array(reference.position, dtype=float), yaw, theta_of(self.robot, q))


def theta_of(robot: Robot, joint_angles: np.ndarray) -> float:
    """The shape angle whose posture is nearest to some joint angles (nq,), rad; nominal without joints."""
    posture = robot.description.posture
    slope = np.asarray(posture.slope)
    size = float(slope @ slope)
    return (
        float(slope @ (joint_angles - np.asarray(posture.offset)) / size) if size else posture.theta_nominal
    )
