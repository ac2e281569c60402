"""A robot's mechanics as functions of its joint and vectoring angles, in numbers and in CasADi symbols."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.errors import AllocationError, ConfigError
from skylimb.base.packing import Layout
from skylimb.robots.bodies import lump
from skylimb.robots.description import RobotDescription
from skylimb.robots.hovering import hovering_frame
from skylimb.robots.kinematics import BodyPose, angular_velocities, body_poses, composite, congruence
from skylimb.symbolic import is_symbolic

Array = Any
"""A NumPy array or a CasADi matrix (SX, MX, DM)."""

_CONDITION_MAX = 1e7


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
        hover_thrusts: (n,) thrusts that carry m g along z of {C} without torque, N.
        tip_C: (3,) tip in {C}, m.
        tip_root: (3,) tip in the root frame, m.
        tip_jacobian: (3, nq) derivative of tip_root by the joint angles, m/rad.
        cog_jacobian: (3, nq + nv) derivative of cog_root by joint and vectoring angles, m/rad.
        tip_heading: yaw of the tip link's x axis in the root frame, rad, 0 where the heading is the root's;
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


class ImuPlace(NamedTuple):
    """The IMU in the root frame.

    Attributes:
        xyz: (3,) its origin, m.
        R: (3, 3) its axes.
        velocity: (3,) of the origin by the joints that turn, m/s.
        rates: (3,) of the axes by these, in root axes, rad/s.
    """

    xyz: Array
    R: Array
    velocity: Array
    rates: Array


class Robot:
    """A multi-link aerial robot: its description, and its mechanics as functions of (q, psi).

    Attributes:
        description: what the files say.
        name: short name.
        mass: total mass, kg.
        weight: m g, N.
        n_joints: number of shape joints, the length of q.
        n_vectoring: number of vectoring joints, the length of psi.
        n_rotors: number of rotors, the length of a thrust vector.
    """

    def __init__(self, description: RobotDescription) -> None:
        self.description = description
        self.name = description.name
        self.n_joints = len(description.shape_joints)
        self.n_vectoring = len(description.vectoring_joints)
        self.n_rotors = len(description.rotors)
        self.bodies, self.placements = lump(description)
        self.mass = float(sum(body.mass for body in self.bodies))
        self.weight = self.mass * description.gravity
        q, psi = ca.SX.sym("q", self.n_joints), ca.SX.sym("psi", self.n_vectoring)
        poses = self._poses(q, psi)
        # Equal subexpressions are shared once here rather than in every function that the model is composed
        # into.
        state = RobotState(*ca.cse([ca.SX(entry) for entry in self._state(poses, q, psi)]))
        self._function = ca.Function("robot", [q, psi], list(state), ["q", "psi"], state._fields)
        # All entries in one vector: numbers cross from CasADi once instead of eleven times.
        z3, square, nq, n = np.zeros(3), np.zeros((3, 3)), self.n_joints, self.n_rotors
        by_q, by_all = np.zeros((3, nq)), np.zeros((3, nq + self.n_vectoring))
        allocation, thrusts = np.zeros((6, n)), np.zeros(n)
        self._layout = Layout(
            RobotState(0.0, z3, z3, square, square, allocation, thrusts, z3, z3, by_q, by_all, 0.0)
        )
        self._numbers = ca.Function("numbers", [q, psi], [ca.densify(self._layout.pack(state))])
        self._skeleton = ca.Function("skeleton", [q, psi], [self._skeleton_points(poses)])
        self._link_poses = ca.Function(
            "links",
            [q, psi],
            [ca.horzcat(*(ca.horzcat(*self._place(poses, link.name)) for link in description.links))],
        )

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, {self.mass:.4f} kg, {self.n_joints} joints, {self.n_rotors} rotors)"

    def at(
        self, joint_angles: Sequence[float] | Array, vectoring_angles: Sequence[float] | Array
    ) -> RobotState:
        """The model in numbers; in CasADi expressions of symbols, see `model`.

        Args:
            joint_angles: (nq,) q in rad; limits are not checked here, a measurement may lie a little outside.
            vectoring_angles: (nv,) psi in rad.

        Raises:
            ConfigError: the wrong number of angles, or one that is not a finite number.
            AllocationError: at these angles the rotors cannot carry the robot without torque.
        """
        if is_symbolic(joint_angles, vectoring_angles):
            return self.model(joint_angles, vectoring_angles)
        q = self._angles("joint_angles", joint_angles, self.n_joints)
        psi = self._angles("vectoring_angles", vectoring_angles, self.n_vectoring)
        state = self._layout.unpack(self._numbers(q, psi).full().ravel())
        condition = _condition(state.allocation_C)
        if condition > _CONDITION_MAX:
            raise AllocationError(
                f"the allocation matrix of '{self.name}' is singular (condition {condition:.1e}) at joint "
                "angles "
                f"{np.round(q, 4).tolist()}, vectoring angles {np.round(psi, 4).tolist()} rad"
            )
        return state

    def model(self, joint_angles: Array, vectoring_angles: Array) -> RobotState:
        """The model in CasADi expressions of the given ones (SX or MX), for composing into a function.

        Entries that are not used cost nothing in the function that is built. No check is made: a singular
        allocation gives entries that are not finite.
        """
        return RobotState(*self._function.call([joint_angles, vectoring_angles]))

    def skeleton(self, joint_angles: Any, vectoring_angles: Any) -> Array:
        """Points along the chain from the root link to the tip, for drawing: (nq + 2, 3), root frame, m.

        They are the origin of the root link, of each body behind a shape joint, and the tip.
        """
        points = self._skeleton(joint_angles, vectoring_angles)
        return points.full() if isinstance(points, ca.DM) else points

    def link_poses(
        self, joint_angles: Any, vectoring_angles: Any
    ) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Position (3,) in m and orientation (3, 3) of every link's frame in the root frame, in numbers."""
        blocks = np.split(
            self._link_poses(joint_angles, vectoring_angles).full(), len(self.description.links), axis=1
        )
        return {
            link.name: (b[:, 0], b[:, 1:]) for link, b in zip(self.description.links, blocks, strict=True)
        }

    def link_pose_function(self, *links: str) -> ca.Function:
        """(q, psi) -> (3, 4) position (m) and orientation of a link's frame in the root frame, each."""
        q, psi = ca.SX.sym("q", self.n_joints), ca.SX.sym("psi", self.n_vectoring)
        poses = self._poses(q, psi)
        return ca.Function("pose", [q, psi], [ca.horzcat(*self._place(poses, link)) for link in links])

    def joint_limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper limits of the joint angles q, (nq,) each, rad."""
        return self._limits(self.description.shape_joints)

    def vectoring_limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper limits of the vectoring angles psi, (nv,) each, rad; infinite where none are."""
        return self._limits(self.description.vectoring_joints)

    def thrust_limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and greatest thrust of each rotor, (n,) each, N."""
        rotors = self.description.rotors
        least, most = ([getattr(rotor, end) for rotor in rotors] for end in ("thrust_min", "thrust_max"))
        return np.array(least), np.array(most)

    def _limits(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
        joints = [self.description.joint(name) for name in names]
        return np.array([joint.lower for joint in joints]), np.array([joint.upper for joint in joints])

    def nominal_posture(self) -> np.ndarray:
        """Joint angles q (nq,) of the description's nominal posture, rad."""
        return self.description.posture.nominal

    @functools.cached_property
    def wrench_function(self) -> ca.Function:
        """(q, psi) -> (6, n) wrench in root axes about the centre of gravity per thrust: - and m.

        Unlike the allocation matrix of `at` it needs no hovering frame, so it exists for any rotors.
        """
        q, psi = ca.SX.sym("q", self.n_joints), ca.SX.sym("psi", self.n_vectoring)
        poses = self._poses(q, psi)
        axes, points = self._thrust_lines(poses, composite(self.bodies, poses)[0])
        columns = [
            ca.vertcat(axis, ca.cross(point, axis) + rotor.drag_torque_coefficient * axis)
            for axis, point, rotor in zip(axes, points, self.description.rotors, strict=True)
        ]
        return ca.Function("wrench", [q, psi], [ca.horzcat(*columns)], ["q", "psi"], ["Q"])

    def imu_at(self, joint_angles: Array, vectoring_angles: Array, rates: Array) -> ImuPlace:
        """The IMU on its link, in numbers or symbols.

        Args:
            joint_angles: (nq,) q in rad.
            vectoring_angles: (nv,) psi in rad.
            rates: of both, rad/s.
        """
        found = self._imu.call([joint_angles, vectoring_angles, rates])
        if is_symbolic(joint_angles, vectoring_angles, rates):
            return ImuPlace(*found)
        xyz, R, velocity, turning = (part.full() for part in found)
        return ImuPlace(xyz[:, 0], R, velocity[:, 0], turning[:, 0])

    @functools.cached_property
    def _imu(self) -> ca.Function:
        q, psi = ca.SX.sym("q", self.n_joints), ca.SX.sym("psi", self.n_vectoring)
        angles, mount = ca.vertcat(q, psi), self.description.imu
        rates = ca.SX.sym("rates", angles.numel())
        poses = self._poses(q, psi)
        point, R = self._place(poses, mount.link, mount.xyz)
        by_joint = {name: rates[index] for index, name in enumerate(self.description.moving_joints)}
        turning = angular_velocities(self.bodies, poses, ca.SX(3, 1), by_joint)
        moved = point, R @ mount.R, ca.jtimes(point, angles, rates), turning[self.placements[mount.link].body]
        return ca.Function("imu", [q, psi, rates], list(map(ca.densify, moved)))

    def _angles(self, name: str, value: Any, length: int) -> np.ndarray:
        try:
            angles = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            raise ConfigError(f"{name} = {value!r} of '{self.name}' must be {length} numbers (rad)") from None
        if angles.shape != (length,) or not np.all(np.isfinite(angles)):
            raise ConfigError(
                f"{name} = {angles.tolist()} of '{self.name}' must be {length} finite numbers (rad)"
            )
        return angles

    def _poses(self, q: Array, psi: Array) -> list[BodyPose]:
        angles, names = ca.vertcat(q, psi), self.description.moving_joints
        return body_poses(self.bodies, {name: angles[index] for index, name in enumerate(names)})

    def _place(
        self, poses: Sequence[BodyPose], link: str, xyz: Array = (0.0, 0.0, 0.0)
    ) -> tuple[Array, Array]:
        """Position in the root frame of a point of a link, and the link's orientation."""
        place = self.placements[link]
        pose = poses[place.body]
        return pose.point(place.xyz + place.R @ np.asarray(xyz, dtype=float)), pose.turned(place.R)

    def _thrust_lines(self, poses: Sequence[BodyPose], cog: Array) -> tuple[list[Array], list[Array]]:
        """Axis of each rotor's thrust, and where it acts from the centre of gravity, in root axes."""
        axes, points = [], []
        for rotor in self.description.rotors:
            point, R = self._place(poses, rotor.link, rotor.xyz)
            axes.append(R @ rotor.R[:, 2])
            points.append(point - cog)
        return axes, points

    def _state(self, poses: Sequence[BodyPose], q: Array, psi: Array) -> RobotState:
        cog, inertia = composite(self.bodies, poses)
        thrust_axes, thrust_points = self._thrust_lines(poses, cog)
        drag = [rotor.drag_torque_coefficient for rotor in self.description.rotors]
        hover = hovering_frame(
            thrust_axes, thrust_points, drag, self.weight, self.description.preferred_thrusts
        )
        tip, R_tip = self._place(poses, self.description.tip.link, self.description.tip.position)
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
            tip_jacobian=ca.jacobian(tip, q),
            cog_jacobian=ca.jacobian(cog, ca.vertcat(q, psi)),
            tip_heading=self._heading(poses, R_tip, q, psi),
        )

    def _heading(self, poses: Sequence[BodyPose], R_tip: Array, q: Array, psi: Array) -> Any:
        if self.description.tip.heading == "root":
            return ca.SX(0.0)
        place = self.placements[self.description.tip.link]
        pose = poses[place.body]
        if pose.base is None and abs(pose.axis[2]) == 1.0:
            # About z the angles add up, which costs no arctangent and never jumps by 2 pi.
            x_axis = pose.R_zero @ place.R[:, 0]
            return pose.axis[2] * pose.angle + np.arctan2(x_axis[1], x_axis[0])
        # Counted from the nominal posture, so that it jumps by 2 pi half a turn away from there only.
        x_axis = R_tip[:2, 0]
        at = self.description.posture.nominal, self.description.vectoring_start
        start = ca.Function("x_axis", [q, psi], [x_axis])(*at).full()
        first = np.arctan2(start[1, 0], start[0, 0])
        cos, sin = np.cos(first), np.sin(first)
        return first + ca.atan2(cos * x_axis[1] - sin * x_axis[0], cos * x_axis[0] + sin * x_axis[1])

    def _skeleton_points(self, poses: Sequence[BodyPose]) -> Array:
        origins = [self._place(poses, self.description.root)[0]]
        origins += [
            self._place(poses, self.description.joint(name).child)[0]
            for name in self.description.shape_joints
        ]
        tip, _ = self._place(poses, self.description.tip.link, self.description.tip.position)
        return ca.horzcat(*origins, tip).T


def _condition(allocation: np.ndarray) -> float:
    if not np.all(np.isfinite(allocation)):
        return float("inf")
    singular_values = np.linalg.svd(allocation[2:], compute_uv=False)
    return float(singular_values[0] / max(singular_values[-1], 1e-300))
