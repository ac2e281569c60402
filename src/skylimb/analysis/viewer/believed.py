"""Where a flight believes its surface, and the axes of its path and contact, as a page shows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from skylimb.analysis.scores.signals import Direction

SIZE = (2.0, 2.0)
"""Of a surface that does not say its own, m."""


def believed_frame(
    center: Sequence[float], contact: Direction, sliding: Sequence[Direction], size: Sequence[float] | None
) -> dict[str, Any]:
    """The plane on which a mission lays its path, whatever is there in truth.

    Args:
        center: believed middle of the path, W, m.
        contact: axis along which the robot pushes.
        sliding: the two in which the tip slides.
        size: of the surface along those, m.

    Returns:
        `origin`, `size`, and `axes`: each with its `name` in figures and charts, what it is for, and its
        `vector` in W; that of the contact is `inward`, so that it can be drawn before the surface.
    """
    named = [(contact, "contact"), *((axis, "path") for axis in sliding)]
    axes = [
        {
            "name": f"{axis} {what}",
            "vector": np.asarray(axis.vector, dtype=float).tolist(),
            "inward": what == "contact",
        }
        for axis, what in named
    ]
    return {"origin": list(map(float, center)), "size": list(map(float, size or SIZE)), "axes": axes}
