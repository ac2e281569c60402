"""A step's function over all rows of a flight."""

from __future__ import annotations

from itertools import cycle

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
    state = np.array(state, dtype=float)
    following, given, made = np.empty_like(state), np.empty(rows.shape[1]), np.empty(function.size1_out(1))
    there = BoundFunction(function, (state, given), (following, made))
    back = BoundFunction(function, (following, given), (state, made))
    outputs = np.empty((len(rows), len(made)))
    # To copy a row costs a tenth of binding the function to it.
    for row, output, step in zip(rows, outputs, cycle((there.evaluate, back.evaluate)), strict=False):
        given[:] = row
        step()
        output[:] = made
    return outputs
