"""What moved in a flight, and whether that is enough to show anything."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from skylimb.base.errors import ConfigError
from skylimb.studies.calibration.record import Record

LEAST_MOTION = (0.01, 0.01, 0.02)
"""Least motion that excites anything: of the root (m), of its attitude (rad) or of a joint (rad), as
standard deviations."""


def require_excited(record: Record) -> None:
    """Refuse a flight in which nothing moves enough to be seen.

    Raises:
        ConfigError: with what moved, and what should have.
    """
    used = record.frames
    turned = record.attitude[used] - record.attitude[used].mean(axis=0)
    moved = (
        float(record.position[used].std(axis=0).max()),
        float(np.sqrt(0.5 * (turned**2).sum(axis=(1, 2)).mean())),
        float(record.angles[used].std(axis=0).max(initial=0.0)),
    )
    if all(found < least for found, least in zip(moved, LEAST_MOTION, strict=True)):
        raise ConfigError(
            f"the flight excites nothing: the root moves by {1e3 * moved[0]:.2g} mm, turns by "
            f"{moved[1]:.2g} rad, the joints by {moved[2]:.2g} rad (standard deviations); fly "
            f"`skylimb calibrate`"
        )


def motion_of(record: Record) -> str:
    """What moved in a record, and how far, in a sentence."""
    used = record.frames
    place = np.ptp(record.position[used], axis=0)
    rpy = Rotation.from_matrix(record.attitude[used]).as_euler("xyz")
    tilt = np.abs(rpy[:, :2]).max()
    names = record.robot.description.moving_joints
    joints = ", ".join(
        f"{name} over {np.ptp(angle):.2f}" for name, angle in zip(names, record.angles[used].T, strict=True)
    )
    return (
        f"The measured link moved over {place[0]:.2f}, {place[1]:.2f} and {place[2]:.2f} m along x, y and z, "
        f"tilted by up to {np.degrees(tilt):.1f} degrees and turned over "
        f"{np.degrees(np.ptp(np.unwrap(rpy[:, 2]))):.0f} degrees; in rad, {joints}. Commanded thrusts went "
        f"over {np.ptp(record.command[used], axis=0).max():.1f} N."
    )
