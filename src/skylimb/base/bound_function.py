"""A CasADi function on the memory of NumPy arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np


class BoundFunction:
    """A CasADi function that reads and writes NumPy arrays in place: a call copies and allocates nothing.

        twice = BoundFunction(function, [given], [result])
        given[:] = 1.0, 2.0
        twice.evaluate()            # result holds the values now

    Arrays are contiguous and of floats. CasADi stores matrices by columns, so (n, m) of a function is an
    array (m, n). They live as long as this object does: keep it with `evaluate`.

    Args:
        function: of dense arguments and results.
        given: an array for each argument.
        results: an array for each result.

    Attributes:
        evaluate: reads the arguments and writes the results.
    """

    def __init__(
        self, function: ca.Function, given: Sequence[np.ndarray], results: Sequence[np.ndarray]
    ) -> None:
        self._buffer, self.evaluate = function.buffer()
        self.bind(given, results)

    def bind(self, given: Sequence[np.ndarray], results: Sequence[np.ndarray]) -> None:
        """Read and write other arrays from now on."""
        self._arrays = given, results
        array: Any  # CasADi's stubs know no buffers
        for index, array in enumerate(given):
            self._buffer.set_arg(index, memoryview(array))  # pyright: ignore[reportCallIssue]
        for index, array in enumerate(results):
            self._buffer.set_res(index, memoryview(array))  # pyright: ignore[reportCallIssue]
