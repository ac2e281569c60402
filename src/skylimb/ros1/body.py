"""Where centre of gravity and the lab's link are and how they move, straight from a measurement."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.estimation.records import Measurement
from skylimb.ros1.kinematics import Seats
from skylimb.spatial import rotation_from_quaternion, rpy_from_rotation


class Body(NamedTuple):
    """The robot as measured.

    Attributes:
        cog: centre of gravity in W, m, (3,).
        velocity: of it, m/s, (3,); joints that turn are left out.
        R_WC: axes of C in W, (3, 3).
        link: origin of the lab's link in W, m, (3,).
        link_velocity: of it, m/s, (3,).
        R_W_link: its axes, (3, 3).
        angular_velocity: in the axes of the measured link, rad/s, (3,).
        rates_cog: the same in C.
        rates_link: the same in the lab's link.
    """

    cog: np.ndarray
    velocity: np.ndarray
    R_WC: np.ndarray
    link: np.ndarray
    link_velocity: np.ndarray
    R_W_link: np.ndarray
    angular_velocity: np.ndarray
    rates_cog: np.ndarray
    rates_link: np.ndarray

    @property
    def yaw(self) -> float:
        """Yaw of the lab's link, rad."""
        return float(rpy_from_rotation(self.R_W_link)[2])

    @property
    def tilt(self) -> float:
        """Angle of C's z axis against the vertical, rad."""
        return float(np.arccos(np.clip(self.R_WC[2, 2], -1.0, 1.0)))


def body_of(measured: Measurement, seats: Seats) -> Body:
    """The body of a measurement that is believed."""
    seat = seats.at(np.asarray(measured.joint_angles), np.asarray(measured.vectoring_angles))
    q = np.asarray(measured.quaternion, dtype=float)
    R = np.asarray(rotation_from_quaternion(q / np.linalg.norm(q)))
    rates = np.asarray(measured.angular_velocity, dtype=float)
    position, velocity = np.asarray(measured.position), np.asarray(measured.velocity)
    return Body(
        cog=position + R @ seat.cog,
        velocity=velocity + R @ np.cross(rates, seat.cog),
        R_WC=R @ seat.R_root_C,
        link=position + R @ seat.link,
        link_velocity=velocity + R @ np.cross(rates, seat.link),
        R_W_link=R @ seat.R_root_link,
        angular_velocity=rates,
        rates_cog=seat.R_root_C.T @ rates,
        rates_link=seat.R_root_link.T @ rates,
    )
