"""The axes of a task: the contact axis and the two sliding axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.rotations import rotation_from_x_to


@dataclass(frozen=True)
class ContactFrame:
    """Axes of the task, right-handed unit vectors in W: the contact axis and two sliding axes."""

    contact: np.ndarray
    sliding_u: np.ndarray
    sliding_v: np.ndarray

    @property
    def heading(self) -> float:
        """Heading of the contact axis about z, rad; zero when it is vertical."""
        return (
            float(np.arctan2(self.contact[1], self.contact[0])) if np.hypot(*self.contact[:2]) > 1e-6 else 0.0
        )


def contact_frame(axis: tuple[float, float, float]) -> ContactFrame:
    """The frame of a contact axis, as a surface has it.

    For x it is the paper's, u = y and v = z; a ceiling has u = y and v = -x.

    Raises:
        ConfigError: when the axis is no unit vector.
    """
    if not abs(float(np.linalg.norm(axis)) - 1.0) < 1e-3:
        raise ConfigError(
            f"contact_axis = {list(axis)} must be a unit vector; the paper's is [1.0, 0.0, 0.0]"
        )
    return ContactFrame(*rotation_from_x_to(axis).T)
