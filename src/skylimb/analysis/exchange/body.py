"""Where centre of gravity and the lab's link are and how they move, straight from a measurement."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from skylimb.analysis.exchange.frames import frames_function
from skylimb.base.bound_function import ArrayFunction
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.robots.model import Robot
from skylimb.symbolic import cross


class Body(NamedTuple):
    """The robot as measured.

    Attributes:
        cog: centre of gravity in W, m, (3,).
        velocity: of it, m/s, (3,); joints that turn are left out.
        R_WC: axes of C in W, (3, 3).
        rates_cog: angular velocity in C, rad/s, (3,).
        link: origin of the lab's link in W, m, (3,).
        link_velocity: of it, m/s, (3,).
        R_W_link: its axes, (3, 3).
        rates_link: angular velocity in its axes, rad/s, (3,).
        root: origin of the measured link in W, m, (3,).
        R_W_root: its axes, (3, 3).
    """

    cog: np.ndarray
    velocity: np.ndarray
    R_WC: np.ndarray
    rates_cog: np.ndarray
    link: np.ndarray
    link_velocity: np.ndarray
    R_W_link: np.ndarray
    rates_link: np.ndarray
    root: np.ndarray
    R_W_root: np.ndarray

    @property
    def yaw(self) -> float:
        """Yaw of the lab's link, rad."""
        return float(np.arctan2(self.R_W_link[1, 0], self.R_W_link[0, 0]))

    @property
    def yaw_in_C(self) -> float:
        """Yaw of the lab's link in C, rad."""
        R = self.R_WC.T @ self.R_W_link
        return float(np.arctan2(R[1, 0], R[0, 0]))

    @property
    def tilt(self) -> float:
        """Angle of C's z axis against the vertical, rad."""
        return float(np.arccos(min(max(self.R_WC[2, 2], -1.0), 1.0)))


class Bodies:
    """Makes bodies of measurements: one evaluation, on its own memory.

    Args:
        robot: whose.
        link: whose pose is on the lab's topics.

    Attributes:
        sizes: of what is measured, in the order of `of`.
    """

    def __init__(self, robot: Robot, link: str) -> None:
        self.sizes = (3, 4, 3, 3, robot.n_joints, robot.n_vectoring)
        given = [ca.SX.sym(name, size) for name, size in zip("pqvwjg", self.sizes, strict=True)]
        p, q, v, w, joints, vectoring = given
        cog, R_root_C, _, link_root, R_root_link = frames_function(robot, link)(joints, vectoring)
        R: Any = rotation_from_quaternion(q / ca.norm_2(q))
        parts = [
            p + R @ cog,
            v + R @ cross(w, cog),
            R @ R_root_C,
            R_root_C.T @ w,
            p + R @ link_root,
            v + R @ cross(w, link_root),
            R @ R_root_link,
            R_root_link.T @ w,
            p,
            R,
        ]
        function = ca.Function("body", given, [ca.densify(part) for part in parts], {"cse": True})
        self._function = ArrayFunction(function)

    def of(self, measured: Sequence[Any]) -> Body:
        """The body of a measurement that is believed.

        Args:
            measured: of the measured link: position in W, m, (3,), quaternion (w, x, y, z), velocity in W,
                m/s, (3,), and angular velocity in its axes, rad/s, (3,); joint and vectoring angles, rad;
                what comes behind them does not matter.
        """
        return Body(*self._function(*measured[:6]))
