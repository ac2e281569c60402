"""Every operation of `skylimb.symbolic` gives the same on numbers and on symbols, and NumPy's as well."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from skylimb import symbolic as sym
from skylimb.base.packing import number

V, W = np.array([0.3, -1.2, 0.7]), np.array([-0.5, 0.4, 2.0])
TABLE = np.array([1.0, 3.0, 2.0])
SAME: dict[str, tuple[Callable[..., Any], tuple[Any, ...], Any]] = {
    "sin": (sym.sin, (V,), np.sin),
    "cos": (sym.cos, (V,), np.cos),
    "tan": (sym.tan, (V,), np.tan),
    "tanh": (sym.tanh, (V,), np.tanh),
    "exp": (sym.exp, (V,), np.exp),
    "log": (sym.log, (V**2,), np.log),
    "sqrt": (sym.sqrt, (V**2,), np.sqrt),
    "abs": (sym.abs, (V,), np.abs),
    "sign": (sym.sign, (V,), np.sign),
    "floor": (sym.floor, (V,), np.floor),
    "atan2": (sym.atan2, (V, W), np.arctan2),
    "clip": (sym.clip, (V, -0.5, 0.5), np.clip),
    "least": (sym.min, (V,), np.min),
    "greatest": (sym.max, (V,), np.max),
    "min": (sym.min, (V, W), np.minimum),
    "max": (sym.max, (V, 0.0), np.maximum),
    "norm": (sym.norm, (V,), np.linalg.norm),
    "dot": (sym.dot, (V, W), None),  # np.dot takes CasADi's columns for matrices
    "cross": (sym.cross, (V, W), np.cross),
    "where": (lambda a, b: sym.where(a > b, a, b), (V, W), lambda a, b: np.where(a > b, a, b)),
}


def on_symbols(function: Callable[..., Any], given: tuple[Any, ...]) -> Any:
    """A function traced on symbols, and called with numbers."""
    symbols = [ca.SX.sym("x", len(np.atleast_1d(one))) for one in given]
    return number(ca.Function("traced", symbols, [function(*symbols)])(*given))


@pytest.mark.filterwarnings("ignore::FutureWarning")
@pytest.mark.parametrize("name", SAME)
def test_numbers_and_symbols_give_the_same(name: str) -> None:
    function, given, of_numpy = SAME[name]
    expected = function(*given)
    np.testing.assert_allclose(on_symbols(function, given), expected, rtol=1e-15)
    if of_numpy is not None:
        np.testing.assert_allclose(of_numpy(*given), expected, rtol=1e-15)
        np.testing.assert_allclose(on_symbols(of_numpy, given), expected, rtol=1e-15)


def test_least_and_greatest_take_any_number_of_values() -> None:
    assert sym.min(3.0, 1.0, 2.0) == on_symbols(sym.min, (3.0, 1.0, 2.0)) == 1.0
    assert sym.max(3.0, 1.0, 2.0) == on_symbols(sym.max, (3.0, 1.0, 2.0)) == 3.0


@pytest.mark.parametrize("at", [-1.0, 0.0, 0.25, 1.0, 1.5, 3.0, 9.0])
def test_interpolation_is_that_of_numpy_also_beyond_the_ends(at: float) -> None:
    points = (0.0, 1.0, 3.0)
    expected = np.interp(at, points, TABLE)
    assert sym.interp(at, points, TABLE) == expected
    assert on_symbols(lambda x: sym.interp(x, points, TABLE), (at,)) == pytest.approx(expected)
    assert on_symbols(lambda y: sym.interp(at, points, y), (TABLE,)) == pytest.approx(expected)


@pytest.mark.parametrize(("most", "expected"), [(3, 8.0), (20, 128.0)])
def test_a_loop_ends_by_its_condition_or_its_bound(most: int, expected: float) -> None:
    def doubled(x: Any) -> Any:
        return sym.repeat(lambda value: 2.0 * value, x, lambda value: value < 100.0, most)

    assert doubled(1.0) == on_symbols(doubled, (1.0,)) == expected
