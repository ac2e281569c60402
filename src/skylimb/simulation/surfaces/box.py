"""The closest point of a box."""

from __future__ import annotations

import numpy as np


def closest_on_box(points: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Closest points of a box around the origin, outward normals there (..., 3), and signed distances (...).

    Of a point inside, the nearest face counts.

    Args:
        points: in the box's axes, m, (..., 3).
        half: half lengths along its axes, m, (3,).
    """
    held = np.clip(points, -half, half)
    away = points - held
    distance = np.linalg.norm(away, axis=-1, keepdims=True)
    depths = half - np.abs(points)
    unit = np.eye(3)[np.argmin(depths, axis=-1)] * np.where(points < 0.0, -1.0, 1.0)
    deep = np.min(depths, axis=-1, keepdims=True)
    inside = distance == 0.0
    normal = np.where(inside, unit, away / np.maximum(distance, 1e-300))
    foot = np.where(inside, points + unit * deep, held)
    return foot, normal, np.where(inside, -deep, distance)[..., 0]
