"""The operations that a law is written with, on numbers and on symbols.

A law written with these and with plain operators runs on numbers in a test and on symbols in the compiled
tick. A function handed any CasADi argument returns a CasADi matrix, otherwise NumPy. Vectors are (n,) in
NumPy and n x 1 in CasADi. NumPy's functions of the same names take either as well; only those of two vectors
(`np.dot`, `a @ b`) need `dot`.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import casadi as ca
import numpy as np

Array = Any
"""A NumPy array or a CasADi matrix (SX, MX, DM)."""

_SYMBOLIC = (ca.SX, ca.MX, ca.DM)


def is_symbolic(*values: Any) -> bool:
    """Whether any of the values is a CasADi matrix."""
    for value in values:  # noqa: SIM110 - no generator, as laws that are flown in Python ask it often
        if isinstance(value, _SYMBOLIC):
            return True
    return False


_NUMBERS = (
    "__bool__",
    "__float__",
    "__int__",
    "__array__",
    "__iter__",
    "__array_ufunc__",
    "__array_function__",
)
"""What Python and NumPy call of a symbol that they take for a number, a truth value or numbers."""


@contextmanager
def symbols_are_no_numbers() -> Iterator[list[Exception]]:
    """Inside of the block a symbol that is asked for its number raises, `float` too, which would give NaN.

    The list gets each such error, also one that is caught inside of the block: what was computed then is not
    what would be computed with numbers.
    """
    raised: list[Exception] = []
    before = {name: getattr(ca.SX, name) for name in _NUMBERS}
    for name, method in before.items():
        setattr(ca.SX, name, _noticed(_float if name == "__float__" else method, raised))
    try:
        yield raised
    finally:
        for name, method in before.items():
            setattr(ca.SX, name, method)


def _noticed(method: Callable[..., Any], raised: list[Exception]) -> Callable[..., Any]:
    """A method of a symbol whose errors are kept in a list as well."""

    def call(symbol: ca.SX, *given: Any, **named: Any) -> Any:
        try:
            return method(symbol, *given, **named)
        except Exception as error:
            raised.append(error)
            raise

    return call


_float_of_constant = ca.SX.__float__


def _float(value: ca.SX) -> float:
    if not value.is_constant():
        raise TypeError("an SX is no float")
    return _float_of_constant(value)


def as_numpy(value: Any) -> Any:
    """NumPy's array for a matrix of CasADi's numbers, (n,) for a column; anything else as it is."""
    if not isinstance(value, ca.DM):
        return value
    return value.full().ravel() if value.shape[1] == 1 else value.full()


def vector(*entries: Any) -> Array:
    """A vector of scalars, of the kind its entries ask for."""
    if is_symbolic(*entries):
        return ca.vertcat(*entries)
    return np.array([float(entry) for entry in entries])


def matrix(rows: Sequence[Sequence[Any]]) -> Array:
    """A matrix from rows of scalars, of the kind its entries ask for."""
    if any(is_symbolic(*row) for row in rows):
        return ca.vertcat(*(ca.horzcat(*row) for row in rows))
    return np.array([[float(entry) for entry in row] for row in rows])


def diagonal(entries: Any) -> Array:
    """The square matrix with these entries (n,) on its diagonal."""
    return ca.diag(entries) if is_symbolic(entries) else np.diag(entries)


def stack(*parts: Any) -> Array:
    """Vectors and scalars one below the other, as one vector."""
    if is_symbolic(*parts):
        return ca.vertcat(*parts)
    return np.concatenate([np.atleast_1d(np.asarray(part, dtype=float)) for part in parts])


def clip(value: Any, low: Any, high: Any) -> Any:
    """`value` held between `low` and `high`, entry by entry."""
    if is_symbolic(value, low, high):
        return ca.fmin(ca.fmax(value, low), high)
    return np.clip(value, low, high)


def within(value: Any, low: Any, high: Any) -> Any:
    """1 where every entry lies between `low` and `high`, else 0; what is no number lies nowhere."""
    if not is_symbolic(value, low, high):
        return float(np.all((value >= low) & (value <= high)))
    inside = ca.vec(ca.logic_and(value >= low, value <= high))
    return functools.reduce(operator.mul, ca.vertsplit(inside), ca.SX(1.0))


def exp(value: Any) -> Any:
    """The exponential, entry by entry."""
    return ca.exp(value) if is_symbolic(value) else np.exp(value)


def sin(value: Any) -> Any:
    """The sine, entry by entry."""
    return ca.sin(value) if is_symbolic(value) else np.sin(value)


def cos(value: Any) -> Any:
    """The cosine, entry by entry."""
    return ca.cos(value) if is_symbolic(value) else np.cos(value)


def tan(value: Any) -> Any:
    """The tangent, entry by entry."""
    return ca.tan(value) if is_symbolic(value) else np.tan(value)


def tanh(value: Any) -> Any:
    """The hyperbolic tangent, entry by entry: a smooth step from -1 to 1."""
    return ca.tanh(value) if is_symbolic(value) else np.tanh(value)


def log(value: Any) -> Any:
    """The natural logarithm, entry by entry."""
    return ca.log(value) if is_symbolic(value) else np.log(value)


def abs(value: Any) -> Any:
    """The size without its sign, entry by entry."""
    return ca.fabs(value) if is_symbolic(value) else np.abs(value)


def sign(value: Any) -> Any:
    """-1, 0 or 1, entry by entry."""
    return ca.sign(value) if is_symbolic(value) else np.sign(value)


def min(first: Any, *others: Any) -> Any:
    """The least of several values, entry by entry; of one vector, its least entry."""
    if not others:
        return ca.mmin(first) if is_symbolic(first) else np.min(first)
    least = ca.fmin if is_symbolic(first, *others) else np.minimum
    return functools.reduce(least, others, first)


def max(first: Any, *others: Any) -> Any:
    """The greatest of several values, entry by entry; of one vector, its greatest entry."""
    if not others:
        return ca.mmax(first) if is_symbolic(first) else np.max(first)
    greatest = ca.fmax if is_symbolic(first, *others) else np.maximum
    return functools.reduce(greatest, others, first)


def sqrt(value: Any) -> Any:
    """The square root, entry by entry."""
    return ca.sqrt(value) if is_symbolic(value) else np.sqrt(value)


def low_pass(before: Any, value: Any, rate: Any, dt: Any) -> Any:
    """One step of a first-order low pass, exact for a value that is held over the step.

    Args:
        before: filtered value of the last step.
        value: to be filtered.
        rate: the pole, 1/s: the inverse of the time constant, 2 pi times a cutoff in Hz.
        dt: length of the step, s.
    """
    decay = exp(-rate * dt)
    return decay * before + (1.0 - decay) * value


def arctan2(y: Any, x: Any) -> Any:
    """The angle of (x, y)."""
    return ca.atan2(y, x) if is_symbolic(y, x) else np.arctan2(y, x)


atan2 = arctan2


def floor(value: Any) -> Any:
    """The greatest whole number that is not above `value`, entry by entry."""
    return ca.floor(value) if is_symbolic(value) else np.floor(value)


def where(condition: Any, if_true: Any, if_false: Any) -> Any:
    """`if_true` where the condition holds, else `if_false`; both sides are always evaluated."""
    if is_symbolic(condition, if_true, if_false):
        return ca.if_else(condition, if_true, if_false)
    return np.where(condition, if_true, if_false)


def between(rows: Sequence[Any], index: Any) -> Any:
    """What rows hold at an index that may lie between two, on the straight line; beyond the ends, nothing.

    Args:
        rows: numbers, vectors or matrices of one size.
        index: a scalar.
    """
    # Without a branch: each row weighs in with a hat of one index's width.
    hats = [clip(1.0 - abs(index - place), 0.0, 1.0) for place in range(len(rows))]
    return sum((row * hat for row, hat in zip(rows[1:], hats[1:], strict=True)), start=rows[0] * hats[0])


def interp(value: Any, points: Sequence[float], values: Any) -> Any:
    """What stands at `value` on straight lines between points; beyond the ends, what stands there.

    Args:
        value: a scalar.
        points: (n,), rising; plain numbers.
        values: at the points, (n,); numbers or symbols.
    """
    if not is_symbolic(value, values):
        return np.interp(value, points, values)
    found = values[0]
    for k in range(len(points) - 1):
        low, high = points[k], points[k + 1]
        found = found + (clip(value, low, high) - low) * ((values[k + 1] - values[k]) / (high - low))
    return found


def repeat(step: Callable[[Any], Any], state: Any, going: Callable[[Any], Any], most: int) -> Any:
    """A loop that ends: `state = step(state)` while `going(state)` holds, at most `most` times.

    Args:
        step: the next state.
        state: a scalar, a vector or a matrix.
        going: a condition.
        most: on symbols as many steps are computed, whether they count or not.
    """
    for _ in range(most):
        state = where(going(state), step(state), state)
    return state


def cross(a: Array, b: Array) -> Array:
    """The cross product of two 3-vectors."""
    return vector(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Array, b: Array) -> Any:
    """The scalar product of two vectors."""
    count = a.shape[0] if is_symbolic(a) else len(a)
    return functools.reduce(operator.add, (a[k] * b[k] for k in range(count)))


def norm(value: Array) -> Any:
    """The length of a vector."""
    return ca.norm_2(value) if is_symbolic(value) else np.linalg.norm(value)


def right_inverse(A: Array) -> Array:
    """The Moore-Penrose inverse of a wide matrix of full row rank: A^T (A A^T)^-1, or A^-1 when square.

    Minor expansion keeps the symbolic form free of pivoting, so it is the same few hundred operations at
    every call.
    """
    if not is_symbolic(A):
        return np.linalg.pinv(A)
    if A.shape[0] == A.shape[1]:
        return ca.inv_minor(A)
    return A.T @ ca.inv_minor(A @ A.T)


def solve_positive(M: Array, right: Array) -> Array:
    """The solution x (n,) of M x = right for a symmetric positive definite M (n, n).

    In symbols by the factors L D L^T, of which only the lower half of M is read: free of pivots and roots,
    so it is the same operations at every call.
    """
    if not is_symbolic(M, right):
        return np.linalg.solve(M, right)
    n = M.shape[0]
    L: list[list[Any]] = []
    inverse: list[Any] = []  # of D
    for i in range(n):
        scaled: list[Any] = []  # row i of L D
        for j in range(i):
            scaled.append(M[i, j] - sum(scaled[k] * L[j][k] for k in range(j)))
        L.append([entry * inverse[k] for k, entry in enumerate(scaled)])
        inverse.append(1.0 / (M[i, i] - sum(entry * L[i][k] for k, entry in enumerate(scaled))))
    x = [right[i] for i in range(n)]
    for i in range(n):
        x[i] = x[i] - sum(L[i][k] * x[k] for k in range(i))
    for i in reversed(range(n)):
        x[i] = x[i] * inverse[i] - sum(L[k][i] * x[k] for k in range(i + 1, n))
    return ca.vertcat(*x)
