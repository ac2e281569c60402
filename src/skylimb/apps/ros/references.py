"""From a target to the reference that a controller flies, and back from a mission's row to a place."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from skylimb.analysis.exchange.frames import Frames, LinkFrames
from skylimb.apps.ros.bending import KEPT, Bending, shortfall
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.targets import Form, Place, RefusedError, Shape, Target
from skylimb.base.errors import AllocationError
from skylimb.base.rotations import rot_z
from skylimb.control.missions.reference import Reference, untasked
from skylimb.control.planning.posture import posture_family, standing
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.control.planning.vectoring_step import first_vectoring, plan_vectoring
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
        self._frames = Frames(robot, link)
        self._template = untasked(template, align=0.0, tip_acceleration=np.zeros(3))
        self._form: Form = self._family.theta_nominal
        self._posture = self._made(self._form)

    def posture(self, form: Form) -> tuple[np.ndarray, np.ndarray, LinkFrames, np.ndarray]:
        """Joint angles, vectoring angles, frames, and tip seen from the centre of gravity at heading 0."""
        outside = isinstance(form, Shape) or isinstance(self._form, Shape)
        if form is not self._form and (outside or form != self._form):
            self._posture, self._form = self._made(form), form
        return self._posture

    def shape(self, form: Form) -> Shape:
        """Joint and vectoring angles."""
        if isinstance(form, Shape):
            return form
        theta = float(np.clip(form, self._family.theta_min, self._family.theta_max))
        angles = self._family.joint_angles(theta), self._table.angles(theta)
        return Shape(*(np.asarray(one, dtype=float) for one in angles))

    def bending(self, start: Shape, joints: np.ndarray, theta: float | None, limits: FlightLimits) -> Bending:
        """A way to other joint angles, which is still to be planned.

        Args:
            start: where it begins.
            joints: where it ends, rad, (nq,).
            theta: of the family where it ends in one of its postures, rad.
            limits: how fast joints move.

        Raises:
            RefusedError: for a robot whose vectoring angles cannot be planned.
        """
        self._require_plans()
        home = None if theta is None else self.shape(theta)
        joints = joints if home is None else home.joints
        way = float(np.abs(joints - start.joints).max())
        shortest = max(limits.shortest_way, way / limits.joint_speed)
        psi = None if home is None else home.vectoring
        return Bending(self.robot, start, joints, psi, theta, shortest, self.least)

    @property
    def plans(self) -> bool:
        """Whether ways to other postures than those of the family can be planned."""
        return self.robot.n_joints > 0 and self.robot.n_rotors >= 4

    def _require_plans(self) -> None:
        if not self.plans:
            raise RefusedError("only its family of postures is flown: plans take four rotors or more")

    @cached_property
    def least(self) -> float:
        """Torque that a posture has to leave: a share of what the nominal one does, N m."""
        return KEPT * float(plan_vectoring(self.robot, *self.shape(self._family.theta_nominal), 0.0).margin)

    def on_ground(self, joints: np.ndarray) -> Shape:
        """The best shape with these joint angles, for a robot on the ground.

        Raises:
            RefusedError: where it could not fly in it.
        """
        self._require_plans()
        try:
            plan = first_vectoring(self.robot, joints)
        except AllocationError as error:
            raise RefusedError(str(error)) from None
        if not plan.feasible(self.least):
            raise RefusedError(shortfall(plan, self.least))
        return Shape(joints, plan.angles)

    def _made(self, form: Form) -> tuple[np.ndarray, np.ndarray, LinkFrames, np.ndarray]:
        q, psi = self.shape(form)
        state = self.robot.at(q, psi)
        return q, psi, self._frames.at(q, psi), rot_z(-state.tip_heading) @ state.tip_C

    def at(self, target: Target) -> Reference:
        """The reference of a target."""
        place = target.place
        q, psi, frames, tip = self.posture(place.form)
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
        frames = self._frames.at(q, np.asarray(reference.vectoring_angles, dtype=float))
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
