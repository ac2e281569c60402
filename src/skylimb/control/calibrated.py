"""A cascade that knows of its robot what a calibration found."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

from skylimb.base.errors import ConfigError
from skylimb.base.keys import rows_of
from skylimb.control.cascade import Cascade
from skylimb.control.corrections import GAINS, Corrections, believed_robot, require_made_for
from skylimb.robots.model import Robot


def calibrated(
    controller: Any, robot: Robot, corrections: Corrections, given: Collection[str] = ()
) -> Cascade:
    """A cascade that knows of its robot what a calibration found.

    Args:
        controller: a cascade of the described robot.
        robot: as it is described.
        corrections: what was found.
        given: keys of gains that the user gave; they stay.

    Raises:
        ConfigError: when the calibration was made for another robot, or the controller is no cascade.
    """
    if not isinstance(controller, Cascade):
        raise ConfigError(
            f"controller '{controller.name}' is Python of its own, which a calibration cannot reach; only "
            "presets fly calibrated"
        )
    require_made_for(robot, corrections)
    known = {key for key, _, _ in rows_of(controller.key_tables())}
    found = {key: float(getattr(corrections, name)) for name, key in GAINS.items()}
    changes = {
        key: value for key, value in found.items() if key in known and key not in given and value >= 0.0
    }
    believed = believed_robot(robot, corrections)
    return replace(controller.with_gains(changes), robot=believed, corrections=corrections)
