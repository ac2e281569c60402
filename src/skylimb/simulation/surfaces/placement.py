"""Where a surface stands in the world, and how it turns.

A surface has its own axes: w points into it along the contact axis, u and v span it. In the paper's
placement they are the world's x, y and z. `contact_axis` swings them over by the smallest rotation (a
ceiling has w up, u along y and v along -x), then `slope` and `pitch` tilt the surface: w = u tan(slope) at
pitch 0, so that a positive slope recedes toward +u, and a positive pitch recedes toward +v. `roll` last
turns the shape in its own plane, for example the waves of a sine.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.base.keys import refused
from skylimb.base.rotations import rot_x, rot_y, rot_z, rotation_from_x_to


def check_unit_vector(config: Any, key: str) -> None:
    """Raise a `ConfigError` unless the field `key` of a configuration is a unit vector."""
    length = float(np.linalg.norm(getattr(config, key)))
    if not abs(length - 1.0) < 1e-3:
        raise refused(
            config,
            key,
            f"has length {length:.4g}: it must be a unit vector, for example [1.0, 0.0, 0.0] for a wall or "
            "[0.0, 0.0, 1.0] for a ceiling",
        )


def surface_rotation(
    contact_axis: tuple[float, ...], slope: float, pitch: float, roll: float = 0.0
) -> np.ndarray:
    """(3, 3) R_WS, whose columns are the surface's axes w (into it), u and v in the world."""
    return rotation_from_x_to(contact_axis) @ rot_z(-slope) @ rot_y(pitch) @ rot_x(roll)
