"""The surface as a spring, a damper and bristles: forces for simulators whose own contact is not wanted.

The normal direction is the engine's, k delta + c delta' and never a pull. Friction is a bristle that bends
with the slip and slides at the cone's edge, so a tip that sticks does not creep: another law than the
engine's, by which the two can be held against each other.
"""

from __future__ import annotations

import numpy as np

from skylimb.simulation.surfaces import Surface

_STIFFER = 10.0
"""A bristle's stiffness over the surface's."""


class SpringContact:
    """The contact of one flight; it remembers how far the bristle is bent.

    Args:
        surface: what is touched.
        radius: of the tip's ball, m.
        tip_mass: that the damping ratio is meant for, kg.
        step: of the physics, s.

    Attributes:
        damping: normal, N s/m.
    """

    def __init__(self, surface: Surface, radius: float, tip_mass: float, step: float) -> None:
        self._surface, self._radius, self._step = surface, radius, step
        self.damping = surface.contact.normal_damping(tip_mass)
        self._bent = np.zeros(3)

    def __call__(self, tip: np.ndarray, velocity: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Force on the robot, N, and where it acts, m, in W; called once a step.

        Args:
            tip: centre of the tip's ball, (3,) m.
            velocity: of that point, (3,) m/s.
            time: since the flight's beginning, s.
        """
        surface, stiffness, now = self._surface, self._surface.stiffness, np.array([time])
        normal = surface.normal(tip[None], now)[0]
        gap = float(surface.signed_distance(tip[None], now)[0]) - self._radius
        slip = velocity - surface.velocity(time)
        pressed = -stiffness * gap - self.damping * float(slip @ normal)
        if gap >= 0.0 or pressed <= 0.0:
            self._bent = np.zeros(3)
            return np.zeros(3), tip
        slip = slip - (slip @ normal) * normal
        point = tip - (self._radius + 0.5 * gap) * normal
        cone = float(surface.friction_at(point, float(np.linalg.norm(slip)), time)[0]) * pressed
        bristle = _STIFFER * stiffness
        bent = self._bent - (self._bent @ normal) * normal + self._step * slip
        self._bent = _within(bent, cone / bristle)
        friction = _within(-bristle * self._bent - self.damping * slip, cone)
        return pressed * normal + friction, point


def _within(vector: np.ndarray, most: float) -> np.ndarray:
    """The vector, shortened to a length."""
    length = float(np.linalg.norm(vector))
    return vector * (most / length) if length > most else vector
