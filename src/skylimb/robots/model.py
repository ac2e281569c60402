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
from skylimb.robots.kinematics import composite
from skylimb.robots.posed import Posed, RobotState
from skylimb.robots.turned_rotors import turned_rotors
from skylimb.symbolic import is_symbolic

Array = Any
"""A NumPy array or a CasADi matrix (SX, MX, DM)."""

_CONDITION_MAX = 1e7


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
        turned: how two or three rotors on arms that turn are flown; None for all other robots.
        pairs: the robot that laws and supervisor fly: itself, or that of `turned`.
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
        self.turned = turned_rotors(description)
        self.pairs = self if self.turned is None else Robot(self.turned.description)

    # Each is made where it is asked for first: of a robot that stands otherwise nobody asks most of them.

    @functools.cached_property
    def _symbols(self) -> tuple[list[ca.SX], Posed]:
        """Symbolic angles, and where everything is at them."""
        given = [ca.SX.sym("q", self.n_joints), ca.SX.sym("psi", self.n_vectoring)]
        return given, self.posed(*given)

    @functools.cached_property
    def _state(self) -> RobotState:
        """The model at the symbols.

        Equal subexpressions are shared once here rather than in every function that it is composed into.
        """
        (q, _), here = self._symbols
        return RobotState(*ca.cse([ca.SX(entry) for entry in here.state(self._of_pairs(q))]))

    @functools.cached_property
    def _function(self) -> ca.Function:
        state = self._state
        return ca.Function("robot", self._symbols[0], list(state), ["q", "psi"], state._fields)

    @functools.cached_property
    def _layout(self) -> Layout[RobotState]:
        z3, square, nq, n = np.zeros(3), np.zeros((3, 3)), self.n_joints, self.n_rotors
        by_q, by_all = np.zeros((3, nq)), np.zeros((3, nq + self.n_vectoring))
        allocation, thrusts = np.zeros((6, n)), np.zeros(n)
        return Layout(RobotState(0.0, z3, z3, square, square, allocation, thrusts, z3, z3, by_q, by_all, 0.0))

    @functools.cached_property
    def _numbers(self) -> ca.Function:
        """All entries in one vector: numbers cross from CasADi once instead of eleven times."""
        return ca.Function("numbers", self._symbols[0], [ca.densify(self._layout.pack(self._state))])

    @functools.cached_property
    def _skeleton(self) -> ca.Function:
        given, here = self._symbols
        return ca.Function("skeleton", given, [here.skeleton()])

    @functools.cached_property
    def _tool(self) -> ca.Function:
        given, here = self._symbols
        return ca.Function("tool", given, [ca.horzcat(*here.tool), here.heading])

    @functools.cached_property
    def _link_poses(self) -> ca.Function:
        given, here = self._symbols
        poses = (ca.horzcat(*here.place(link.name)) for link in self.description.links)
        return ca.Function("links", given, [ca.horzcat(*poses)])

    def _of_pairs(self, q: Array) -> tuple[Array, Array] | None:
        """{C} and hover thrusts of a robot that is flown as pairs of fixed rotors."""
        if self.turned is None:
            return None
        hover = self.pairs.model(q, ca.SX(0, 1))
        return hover.R_root_C, self.turned.command(hover.hover_thrusts)[0]

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
        q, psi = self.checked_angles(joint_angles, vectoring_angles)
        state = self._layout.unpack(self._numbers(q, psi).full().ravel())
        of = state if self.turned is None else self.pairs.at(q, np.zeros(0))
        condition = _condition(of.allocation_C)
        if condition > _CONDITION_MAX:
            raise AllocationError(
                f"the allocation matrix of '{self.name}' is singular (condition {condition:.1e}) at joint "
                "angles "
                f"{np.round(q, 4).tolist()}, vectoring angles {np.round(psi, 4).tolist()} rad"
            )
        return state

    def posed(self, joint_angles: Array, vectoring_angles: Array) -> Posed:
        """Where everything is at symbolic angles, (nq,) and (nv,) in rad."""
        return Posed(
            self.description, self.bodies, self.placements, self.mass, joint_angles, vectoring_angles
        )

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

    def tool(self, joint_angles: Any, vectoring_angles: Any) -> tuple[Array, Any]:
        """The tool in the root frame and the heading there, rad, in numbers or symbols.

        The first is (3, 4): the tip's position, m, and the tool's orientation, its x axis out.
        """
        pose, heading = self._tool.call([joint_angles, vectoring_angles])
        return (pose.full(), float(heading)) if isinstance(pose, ca.DM) else (pose, heading)

    def link_poses(
        self, joint_angles: Any, vectoring_angles: Any
    ) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Position (3,) in m and orientation (3, 3) of every link's frame in the root frame, in numbers."""
        poses = self._link_poses(joint_angles, vectoring_angles).full()
        return {
            link.name: (poses[:, 4 * k], poses[:, 4 * k + 1 : 4 * k + 4])
            for k, link in enumerate(self.description.links)
        }

    def link_pose_function(self, *links: str) -> ca.Function:
        """(q, psi) -> (3, 4) position (m) and orientation of a link's frame in the root frame, each."""
        q, psi = ca.SX.sym("q", self.n_joints), ca.SX.sym("psi", self.n_vectoring)
        here = self.posed(q, psi)
        return ca.Function("pose", [q, psi], [ca.horzcat(*here.place(link)) for link in links])

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
        here = self.posed(q, psi)
        columns = here.rotor_wrenches(composite(self.bodies, here.poses)[0])
        return ca.Function("wrench", [q, psi], [ca.vertcat(*columns)], ["q", "psi"], ["Q"])

    def imu_at(self, joint_angles: Array, vectoring_angles: Array, rates: Array) -> ImuPlace:
        """The IMU on its link, in numbers or symbols.

        Args:
            joint_angles: (nq,) q in rad.
            vectoring_angles: (nv,) psi in rad.
            rates: of both, rad/s.
        """
        found = self.imu_function.call([joint_angles, vectoring_angles, rates])
        if is_symbolic(joint_angles, vectoring_angles, rates):
            return ImuPlace(*found)
        xyz, R, velocity, turning = (part.full() for part in found)
        return ImuPlace(xyz[:, 0], R, velocity[:, 0], turning[:, 0])

    @functools.cached_property
    def imu_function(self) -> ca.Function:
        """(q, psi, their rates) -> the entries of `ImuPlace`."""
        q, psi = ca.SX.sym("q", self.n_joints), ca.SX.sym("psi", self.n_vectoring)
        angles, mount = ca.vertcat(q, psi), self.description.imu
        rates = ca.SX.sym("rates", angles.numel())
        here = self.posed(q, psi)
        point, R = here.place(mount.link, mount.xyz)
        turning = here.turns(ca.SX(3, 1), rates)[self.placements[mount.link].body]
        moved = point, R @ mount.R, ca.jtimes(point, angles, rates), turning
        return ca.Function("imu", [q, psi, rates], list(map(ca.densify, moved)))

    def checked_angles(
        self, joint_angles: Any, vectoring_angles: Any, finite: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Joint angles (nq,) and vectoring angles (nv,), rad, as arrays.

        Args:
            joint_angles: (nq,) q in rad; limits are not checked.
            vectoring_angles: (nv,) psi in rad.
            finite: whether each has to be a finite number.

        Raises:
            ConfigError: the wrong number of angles, or one that is no number.
        """
        return (
            self._angles("joint_angles", joint_angles, self.n_joints, finite),
            self._angles("vectoring_angles", vectoring_angles, self.n_vectoring, finite),
        )

    def _angles(self, name: str, value: Any, length: int, finite: bool) -> np.ndarray:
        try:
            angles = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            raise ConfigError(f"{name} = {value!r} of '{self.name}' must be {length} numbers (rad)") from None
        if angles.shape != (length,) or (finite and not np.all(np.isfinite(angles))):
            raise ConfigError(
                f"{name} = {angles.tolist()} of '{self.name}' must be {length} finite numbers (rad)"
            )
        return angles


def _condition(allocation: np.ndarray) -> float:
    if not np.all(np.isfinite(allocation)):
        return float("inf")
    singular_values = np.linalg.svd(allocation[2:], compute_uv=False)
    return float(singular_values[0] / max(singular_values[-1], 1e-300))
