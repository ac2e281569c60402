from __future__ import annotations

import gc

import casadi as ca
import numpy as np

from skylimb.base.bound_function import BoundFunction


def test_a_bound_function_reads_and_writes_the_arrays_in_place() -> None:
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y")
    function = ca.Function("f", [x, y], [y * x, ca.dot(x, x)])
    given, results = [np.zeros(2), np.zeros(1)], [np.zeros(2), np.zeros(1)]
    bound = BoundFunction(function, given, results)
    del function
    gc.collect()
    given[0][:], given[1][:] = (1.0, 2.0), 3.0
    bound.evaluate()
    assert [part.tolist() for part in results] == [[3.0, 6.0], [5.0]]
    other = np.zeros(2)
    bound.bind([np.array([2.0, 2.0]), np.array([0.5])], [other, results[1]])
    bound.evaluate()
    assert other.tolist() == [1.0, 1.0]
    assert results[0].tolist() == [3.0, 6.0]
