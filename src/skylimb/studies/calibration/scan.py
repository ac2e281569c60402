"""A step's function over all rows of a flight."""

from __future__ import annotations

import casadi as ca
import numpy as np

from skylimb.base.bound_function import BoundFunction


def scan(function: ca.Function, state: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """What a function (state, row) -> (state, output) gives along all rows.

    Args:
        function: of dense columns.
        state: before the first row.
        rows: (k, size).

    Returns:
        The outputs, (k, size).
    """
    rows = np.ascontiguousarray(rows, dtype=float)
    outputs = np.empty((len(rows), function.size1_out(1)))
    state = np.array(state, dtype=float)
    following = np.empty_like(state)
    bound = BoundFunction(function, (), ())
    for row, output in zip(rows, outputs, strict=True):
        bound.bind((state, row), (following, output))
        bound.evaluate()
        state, following = following, state
    return outputs
