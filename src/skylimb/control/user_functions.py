"""Laws and functions in a user's file, as the tick calls them: errors are one line, symbols are checked."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Iterable
from types import ModuleType
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.errors import UserCodeError
from skylimb.base.packing import Layout
from skylimb.base.signals import declared_signals
from skylimb.base.user_code import UserCode, guarded
from skylimb.base.user_modules import sources_of_module
from skylimb.symbolic import is_symbolic, matrix, vector


class UserLaw:
    """A law in a user's file: what its module defines, with errors described in a line.

    Args:
        module: defines what the law of the slot has to.
        what: what it is called in messages, for example "translation law 'spring.py'".
        traced: names of its functions that end up in the tick.
    """

    def __init__(self, module: ModuleType, what: str, traced: Iterable[str]) -> None:
        self.Gains, self.__doc__ = module.Gains, module.__doc__
        self.signals = declared_signals(module, what)
        self.sources = sources_of_module(module)
        for name in traced:
            setattr(self, name, traceable(getattr(module, name), what))
        for name in ("initial_state", "needs", "require"):
            if hasattr(module, name):
                setattr(self, name, guarded(getattr(module, name), what))
        for name in ("PROVIDES", "REQUIRES", "OPTIONAL"):
            if hasattr(module, name):
                setattr(self, name, getattr(module, name))


def traceable(function: Callable[..., Any], what: str) -> Callable[..., Any]:
    """A user's function that is called with numbers or symbols; errors are described in a line.

    Python turns a symbol into NaN without a word where a plain number is needed. What comes of it is refused.
    """

    @functools.wraps(function)
    def call(*given: Any) -> Any:
        # CasADi warns of each NumPy function that meets its symbols, which do what they should here.
        with UserCode(what), warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)
            result = function(*given)
        lost = lost_symbols(result)
        if lost:
            raise UserCodeError(
                f"{what} makes a constant NaN of {', '.join(lost)}: float(), the functions of math and "
                "writing into a NumPy array need numbers, this is known only in flight; use skylimb.symbolic"
            )
        return result

    return call


def symbolic_record(record: Any) -> Any:
    """A record whose lists and arrays of symbols are symbolic vectors and matrices; the rest as it stands."""
    if isinstance(record, dict):
        return {name: symbolic_record(part) for name, part in record.items()}
    if isinstance(record, tuple) and hasattr(record, "_fields"):
        return type(record)(*map(symbolic_record, record))
    if isinstance(record, list | tuple) and any(map(is_symbolic, record)):
        scalar = all(not is_symbolic(part) or part.shape == (1, 1) for part in record)
        return vector(*record) if scalar else tuple(map(symbolic_record, record))
    if isinstance(record, tuple):
        return tuple(map(symbolic_record, record))
    if isinstance(record, np.ndarray) and record.dtype == object:
        return matrix(list(record)) if record.ndim == 2 else vector(*record.ravel())
    return record


def lost_symbols(record: Any) -> list[str]:
    """What a constant NaN goes into, of what a law or a controller returns; nothing where it holds numbers.

    Args:
        record: new state, output, signals.
    """
    layout = Layout(record)
    flat = layout.pack(record)
    if not is_symbolic(flat) or not _has_nan(flat):
        return []
    found = [name.partition(".") for name, part in layout.slices.items() if _has_nan(flat[part])]
    parts = {"0": "state", "1": "output", "2": ""}
    return [".".join(filter(None, (parts.get(part, part), name))) for part, _, name in found]


def _has_nan(expression: Any) -> bool:
    function = ca.Function("symbols", ca.symvar(expression), [expression])
    constants = (
        function.instruction_constant(k)
        for k in range(function.n_instructions())
        if function.instruction_id(k) == ca.OP_CONST
    )
    return any(np.isnan(constant) for constant in constants)
