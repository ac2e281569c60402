"""A CasADi function on the memory of NumPy arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from time import perf_counter
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.split_function import PythonCall


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
        calls: Python in the middle of the function (`base.split_function`).

    Attributes:
        evaluate: reads the arguments and writes the results.
        spent: time in Python in the last evaluation, s.
    """

    def __init__(
        self,
        function: ca.Function,
        given: Sequence[np.ndarray],
        results: Sequence[np.ndarray],
        calls: Sequence[PythonCall] = (),
    ) -> None:
        self._buffer, self.evaluate = function.buffer()
        self.spent, self._last = 0.0, self.evaluate
        self._turns, self._made = [], list[tuple[str, np.ndarray]]()
        for call in calls:
            asked, made = np.zeros(call.before.numel_out(0)), np.zeros(call.size)
            before = BoundFunction(call.before, given, [asked])
            self._turns.append((before.evaluate, call.bind(asked, made), before))
            self._made.append((call.what, made))
            given = *given, made
        if calls:
            self.evaluate = self._evaluate_in_turns
        self.bind(given, results)

    def _evaluate_in_turns(self) -> None:
        self.spent = 0.0
        for before, run, _ in self._turns:
            before()
            begun = perf_counter()
            run()
            self.spent += perf_counter() - begun
        self._last()

    def asked_again(self) -> Iterator[tuple[str, float]]:
        """Which Python makes something else of what it was given last, and by how much at most.

        What was made and returned stays as it is.
        """
        for (_, run, _), (what, made) in zip(self._turns, self._made, strict=True):
            before = made.copy()
            run()
            gap = np.max(np.abs(made - before), initial=0.0)
            same = np.array_equal(made, before, equal_nan=True)
            made[:] = before
            if not same:
                yield what, float(gap)

    def bind(self, given: Sequence[np.ndarray], results: Sequence[np.ndarray]) -> None:
        """Read and write other arrays from now on."""
        self._arrays = given, results
        array: Any  # CasADi's stubs know no buffers
        for index, array in enumerate(given):
            self._buffer.set_arg(index, memoryview(array))  # pyright: ignore[reportCallIssue]
        for index, array in enumerate(results):
            self._buffer.set_res(index, memoryview(array))  # pyright: ignore[reportCallIssue]


class ArrayFunction:
    """A CasADi function of dense matrices that takes and returns NumPy arrays, on memory of its own.

    A call takes a tenth of the time of the function's own. It is not for several threads at a time.
    """

    def __init__(self, function: ca.Function) -> None:
        given = [np.zeros(function.size_in(index)[::-1]) for index in range(function.n_in())]
        made = [np.zeros(function.size_out(index)[::-1]) for index in range(function.n_out())]
        self._bound = BoundFunction(function, given, made)
        self._given = [array.T if len(array) > 1 else array[0] for array in given]
        self._made = [array.T if len(array) > 1 else array[0] for array in made]

    def __call__(self, *given: np.ndarray) -> list[np.ndarray]:
        """The results; one with a single column is a vector."""
        for array, value in zip(self._given, given, strict=True):
            array[...] = value
        self._bound.evaluate()
        return [array.copy() for array in self._made]
