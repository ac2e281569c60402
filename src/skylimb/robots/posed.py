"""A robot at angles given as symbols: where its bodies, rotors and tip are, and the model that follows."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.robots.bodies import Body, Placement
from skylimb.robots.description import RobotDescription
from skylimb.robots.hovering import hovering_frame, hovering_in
from skylimb.robots.kinematics import BodyPose, angular_velocities, body_poses, composite, congruence
from skylimb.robots.urdf import clean_rotation

Array = Any
"""A NumPy array or a CasADi matrix (SX, MX, DM)."""


class RobotState(NamedTuple):
    """What the model says at one (q, psi); the root frame is the root link's, {C} is the hovering frame.

    Attributes:
        mass: total mass m, kg.
        gravity: (3,) g of eq:dynamics, m (p'' + g) = f_cmd + f_ext, in W with z up, m/s^2.
        cog_root: (3,) centre of gravity in the root frame, m.
        R_root_C: (3, 3) orientation of {C} seen from the root frame: a turn in roll and pitch, without yaw,
            after which the net force of the hover thrusts lies along z of {C}.
        inertia_C: (3, 3) composite inertia I about the centre of gravity in {C}, kg m^2.
        allocation_C: (6, n) matrix Q of eq:allocation for wrench in {C}: force rows (-), torque rows (m).
        hover_thrusts: (n,) thrusts that carry m g along z of {C} without torque, N; of two or three rotors
            with the vectoring angles of that hover.
        tip_C: (3,) tip in {C}, m.
        tip_root: (3,) tip in the root frame, m.
        tip_jacobian: (3, nq) derivative of tip_root by the joint angles, m/rad.
        cog_jacobian: (3, nq + nv) derivative of cog_root by joint and vectoring angles, m/rad.
        tip_heading: yaw of the tool's x axis in the root frame, rad, 0 where the heading is the root's;
            {C} has the same yaw up to its small tilt.
    """

    mass: Any
    gravity: Array
    cog_root: Array
    R_root_C: Array
    inertia_C: Array  # noqa: N815
    allocation_C: Array  # noqa: N815
    hover_thrusts: Array
    tip_C: Array  # noqa: N815
    tip_root: Array
    tip_jacobian: Array
    cog_jacobian: Array
    tip_heading: Any


@dataclass(frozen=True)
class Posed:
    """A robot at symbolic angles; positions in the root frame, m.

    Attributes:
        description: what the files say.
        bodies: that move against each other.
        placements: of the links on them.
        mass: of all, kg.
        q: joint angles, rad, (nq,).
        psi: vectoring angles, rad, (nv,).
    """

    description: RobotDescription
    bodies: tuple[Body, ...]
    placements: Mapping[str, Placement]
    mass: float
    q: Array
    psi: Array

    @functools.cached_property
    def poses(self) -> list[BodyPose]:
        """Of the bodies."""
        return body_poses(self.bodies, self._by_joint(ca.vertcat(self.q, self.psi)))

    def turns(self, root: Array, rates: Array) -> list[Array]:
        """Angular velocity of each body in root axes, rad/s, from the root's and the rates of all joints."""
        return angular_velocities(self.bodies, self.poses, root, self._by_joint(rates))

    def _by_joint(self, values: Array) -> dict[str, Array]:
        return {name: values[index] for index, name in enumerate(self.description.moving_joints)}

    def place(self, link: str, xyz: Array = (0.0, 0.0, 0.0)) -> tuple[Array, Array]:
        """Position in the root frame of a point of a link, and the link's orientation."""
        place = self.placements[link]
        pose = self.poses[place.body]
        return pose.point(place.xyz + place.R @ np.asarray(xyz, dtype=float)), pose.turned(place.R)

    def thrust_lines(self, cog: Array) -> tuple[list[Array], list[Array]]:
        """Axis of each rotor's thrust, and where it acts from the centre of gravity, in root axes."""
        axes, points = [], []
        for rotor in self.description.rotors:
            point, R = self.place(rotor.link, rotor.xyz)
            axes.append(R @ rotor.R[:, 2])
            points.append(point - cog)
        return axes, points

    def rotor_wrenches(self, cog: Array) -> tuple[Array, Array]:
        """Force and torque about the centre of gravity of 1 N of each rotor in root axes, (3, n) each."""
        axes, points = self.thrust_lines(cog)
        drag = [rotor.drag_torque_coefficient for rotor in self.description.rotors]
        torques = [ca.cross(p, u) + kappa * u for u, p, kappa in zip(axes, points, drag, strict=True)]
        return ca.horzcat(*axes), ca.horzcat(*torques)

    def state(self, of_pairs: tuple[Array, Array] | None = None) -> RobotState:
        """What the model says.

        Args:
            of_pairs: orientation of {C} and hover thrusts, N, (n,), of a robot that is flown as pairs of
                fixed rotors; by default those of thrusts alone.
        """
        cog, inertia = composite(self.bodies, self.poses)
        given = self.rotor_wrenches(cog)
        weight, preferred = self.mass * self.description.gravity, self.description.preferred_thrusts
        if of_pairs is None:
            hover = hovering_frame(*given, weight, preferred)
        else:
            hover = hovering_in(*of_pairs, *given)
        tip, _ = self.tool
        R = hover.R_root_C
        return RobotState(
            mass=self.mass,
            gravity=ca.DM([0.0, 0.0, self.description.gravity]),
            cog_root=cog,
            R_root_C=R,
            inertia_C=congruence(R.T, inertia),
            allocation_C=hover.allocation,
            hover_thrusts=hover.thrusts,
            tip_C=R.T @ (tip - cog),
            tip_root=tip,
            tip_jacobian=ca.jacobian(tip, self.q),
            cog_jacobian=ca.jacobian(cog, ca.vertcat(self.q, self.psi)),
            tip_heading=self.heading,
        )

    @functools.cached_property
    def tool(self) -> tuple[Array, Array]:
        """Position in the root frame of the tip, and the tool's orientation, its x axis out."""
        tip = self.description.tip
        place = self.placements[tip.link]
        at, _ = self.place(tip.link, tip.position)
        return at, self.poses[place.body].turned(clean_rotation(place.R @ tip.R))

    @functools.cached_property
    def heading(self) -> Any:
        """See `RobotState.tip_heading`."""
        tip = self.description.tip
        if tip.heading == "root":
            return ca.SX(0.0)
        place = self.placements[tip.link]
        pose = self.poses[place.body]
        if pose.base is None and abs(pose.axis[2]) == 1.0:
            # About z the angles add up, which costs no arctangent and never jumps by 2 pi.
            x_axis = pose.R_zero @ clean_rotation(place.R @ tip.R)[:, 0]
            return pose.axis[2] * pose.angle + np.arctan2(x_axis[1], x_axis[0])
        # Counted from the nominal posture, so that it jumps by 2 pi half a turn away from there only.
        x_axis = self.tool[1][:2, 0]
        at = self.description.posture.nominal, self.description.vectoring_start
        start = ca.Function("x_axis", [self.q, self.psi], [x_axis])(*at).full()
        first = np.arctan2(start[1, 0], start[0, 0])
        cos, sin = np.cos(first), np.sin(first)
        return first + ca.atan2(cos * x_axis[1] - sin * x_axis[0], cos * x_axis[0] + sin * x_axis[1])

    def skeleton(self) -> Array:
        """Points along the chain from the root link to the tip; see `Robot.skeleton`."""
        origins = [self.place(self.description.root)[0]]
        origins += [
            self.place(self.description.joint(name).child)[0] for name in self.description.shape_joints
        ]
        return ca.horzcat(*origins, self.tool[0]).T
