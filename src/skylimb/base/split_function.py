"""A traced function with Python in its middle: what was asked of Python stands in it as symbols.

What the Python code is given is a function of the arguments, and of what other Python code before it made. So
the whole is evaluated in turns: a CasADi function, Python, a CasADi function, ... `base.bound_function` does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

import casadi as ca
import numpy as np

T = TypeVar("T", bound=Any)

Bind = Callable[[np.ndarray, np.ndarray], Callable[[], None]]
"""Of two flat arrays: a function that reads the first and writes the second."""


class Asked(NamedTuple):
    """What a trace asks of Python.

    Attributes:
        given: expression that the Python code is given, a column.
        made: symbols in the place of what it makes.
        bind: runs it.
        what: it is called in messages.
    """

    given: ca.SX
    made: ca.SX
    bind: Bind
    what: str = ""


class PythonCall(NamedTuple):
    """Python that is run before a traced function can be evaluated.

    Attributes:
        before: of the function's arguments and of what other calls before made; gives what this one is given.
        size: of what it makes.
        bind: runs it.
        what: it is called in messages.
    """

    before: ca.Function
    size: int
    bind: Bind
    what: str = ""


def split_function(
    name: str,
    arguments: Sequence[ca.SX],
    results: Sequence[ca.SX],
    names: tuple[Sequence[str], Sequence[str]],
    asked: Sequence[Asked] = (),
) -> tuple[ca.Function, tuple[PythonCall, ...]]:
    """A function of symbols, split where Python is asked.

    The function takes what Python makes behind its arguments, one column a call.

    Args:
        name: of the function.
        arguments: symbols.
        results: expressions of them and of what Python makes.
        names: of arguments and of results.
        asked: of Python, in the order of the trace.
    """
    symbols, labels, calls = list(arguments), list(names[0]), []
    for index, one in enumerate(asked):
        before = ca.Function(
            f"{name}_before_{index}", symbols, [ca.densify(one.given)], labels, ["given"], {"cse": True}
        )
        calls.append(PythonCall(before, one.made.numel(), one.bind, one.what))
        symbols, labels = [*symbols, one.made], [*labels, f"made_{index}"]
    made = [ca.densify(ca.SX(part)) for part in results]
    return ca.Function(name, symbols, made, labels, list(names[1]), {"cse": True}), tuple(calls)


def made_faster(traced: T, faster: Callable[[ca.Function], ca.Function]) -> T:
    """A record with `function` and `calls`, with every traced part made faster; same numbers."""
    calls = tuple(call._replace(before=faster(call.before)) for call in traced.calls)
    return replace(traced, function=faster(traced.function), calls=calls)
