"""What a log says that no live flight would believe: most often a wrong unit or order, one line each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from skylimb.base.rotations import rotation_from_quaternion
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.realtime.preflight import StartLimits
from skylimb.flight.replay.recorded import Recorded
from skylimb.robots.model import Robot

OFTEN = 0.05
"""Share of the rows in which it has to be so: a flight that ends on the ground is none of a wrong unit."""

GIVES = 0.2
"""Radians by which a joint may be measured beyond its stops: they give way, and zero may be a little off."""

_EVERY = 10
"""Rows of which one attitude is looked at: a tilt that counts lasts."""


def doubts(held: Recorded, robot: Robot) -> Iterator[str]:
    """Compare a log with the gates and the fence of a live flight, and with the robot's own limits.

    Args:
        held: what the log says.
        robot: that flew it.
    """
    gates, measured = Limits(), held.measurement
    low, high = np.array(StartLimits().fence).T
    least, most = (np.asarray(bound, dtype=float) for bound in robot.joint_limits())
    thrust = 1.05 * np.asarray(robot.thrust_limits()[1], dtype=float)
    size = np.linalg.norm(measured.quaternion, axis=1)
    upright = np.array([rotation_from_quaternion(one)[2, 2] for one in measured.quaternion[::_EVERY]])
    for name, beyond, allowed, perhaps in (
        (
            "root_position_measured",
            _any(measured.position, low, high),
            f"is outside of {low} .. {high} m",
            "millimetres?",
        ),
        (
            "velocity",
            _any(measured.velocity, -gates.speed, gates.speed),
            f"is above {gates.speed:g} m/s",
            "millimetres?",
        ),
        (
            "angular velocity",
            _any(measured.angular_velocity, -gates.turning, gates.turning),
            f"is above {gates.turning:g} rad/s",
            "degrees?",
        ),
        ("root_quaternion_measured", np.abs(size - 1.0) > 0.1, "is of another length than 1", "no attitude"),
        (
            "root_quaternion_measured",
            upright < np.cos(gates.upset_at),
            f"tilts by more than {gates.upset_at:g} rad",
            "x y z w in place of w x y z?",
        ),
        (
            "joint_angles_measured",
            _any(measured.joint_angles, least - GIVES, most + GIVES),
            "is beyond the joints' limits",
            "degrees?",
        ),
        (
            "thrusts_command",
            _any(held.command.thrusts, -np.inf, thrust),
            f"is above the rotors' {thrust.max() / 1.05:g} N",
            "grams?",
        ),
    ):
        share = float(np.mean(beyond)) if len(beyond) else 0.0
        if share > OFTEN:
            yield f"{name} {allowed} in {100.0 * share:.0f} % of its rows: {perhaps}"


def _any(values: np.ndarray, low: np.ndarray | float, high: np.ndarray | float) -> np.ndarray:
    """Whether an entry of each row is beyond its bounds, (k,)."""
    return np.any((values < low) | (values > high), axis=1)
