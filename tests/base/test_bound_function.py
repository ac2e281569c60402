from __future__ import annotations

import gc

import casadi as ca
import numpy as np

from skylimb.base.bound_function import ArrayFunction, BoundFunction


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


def test_arrays_in_and_out_stand_as_in_the_function() -> None:
    A, x, none = ca.SX.sym("A", 2, 3), ca.SX.sym("x", 3), ca.SX.sym("none", 0)
    function = ArrayFunction(ca.Function("f", [A, x, none], [A @ x, 2.0 * A.T, x[0]]))
    rng = np.random.default_rng(0)
    given = rng.standard_normal((2, 3)), rng.standard_normal(3), np.zeros(0)
    product, turned, first = made = function(*given)
    np.testing.assert_allclose(product, given[0] @ given[1])
    np.testing.assert_array_equal(turned, 2.0 * given[0].T)
    assert first == given[1][0]
    function(*(2.0 * part for part in given))
    assert first == given[1][0], "results are the caller's own"
    assert [part.shape for part in made] == [(2,), (3, 2), (1,)]
