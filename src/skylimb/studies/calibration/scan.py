"""A step's function over all rows of a flight."""

from __future__ import annotations

import casadi as ca
import numpy as np


def scan(function: ca.Function, state: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """What a function (state, row) -> (state, output) gives along all rows.

    Args:
        function: of dense columns.
        state: before the first row.
        rows: (k, size).

    Returns:
        The outputs, (k, size).
    """
    buffer, evaluate = function.buffer()
    rows = np.ascontiguousarray(rows, dtype=float)
    outputs = np.empty((len(rows), function.size1_out(1)))
    state = np.array(state, dtype=float)
    following = np.empty_like(state)
    for row, output in zip(rows, outputs, strict=True):
        buffer.set_arg(0, memoryview(state))  # pyright: ignore[reportCallIssue, reportArgumentType]
        buffer.set_arg(1, memoryview(row))  # pyright: ignore[reportCallIssue, reportArgumentType]
        buffer.set_res(0, memoryview(following))  # pyright: ignore[reportCallIssue, reportArgumentType]
        buffer.set_res(1, memoryview(output))  # pyright: ignore[reportCallIssue, reportArgumentType]
        evaluate()
        state, following = following, state
    return outputs
