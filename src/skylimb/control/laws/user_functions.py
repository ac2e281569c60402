"""Laws and functions in a user's file, as the tick calls them: errors are one line, symbols are checked."""

from __future__ import annotations

import functools
import inspect
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from skylimb.base.errors import UserCodeError
from skylimb.base.keys.fields import fields_of
from skylimb.base.keys.settings import settings_class
from skylimb.base.packing import with_floats
from skylimb.base.record_tree import below, children_of, is_leaf
from skylimb.base.signals import declared_signals
from skylimb.base.user_code import Place, UserCode, guarded
from skylimb.base.user_modules import sources_of_module
from skylimb.symbolic import is_symbolic, matrix, symbols_are_no_numbers, vector

_LAW = "law"
"""Key of a slot's table in a preset that names its law."""

_OTHERS: Mapping[str, Sequence[str]] = {
    "initial_state": ("gains", "start"),
    "needs": ("gains",),
    "require": ("gains", "dt"),
    "prepare": ("gains", "robot"),
}
"""How functions of a law are called that do not end up in the tick."""


class Prepared(NamedTuple):
    """Gains of a law that prepares something of them, and what it has prepared."""

    gains: Any
    made: Any


class UserLaw:
    """A law in a user's file: what its module defines, with errors described in a line.

    Args:
        module: defines what the law of the slot has to.
        what: what it is called in messages, for example "translation law 'spring.py'".
        called: how its functions are called that end up in the tick: the names of their arguments.

    Attributes:
        module: see above.
        what: see above.
        plain: those functions for numbers alone.
    """

    def __init__(self, module: ModuleType, what: str, called: Mapping[str, Sequence[str]]) -> None:
        self.Gains = settings_class(module.Gains, "Gains", what)
        if _LAW in fields_of(self.Gains):
            raise UserCodeError(f"{what}: a gain cannot be called '{_LAW}', which names the law in a preset")
        self.__doc__, self.module, self.what = module.__doc__, module, what
        self.signals = declared_signals(module, what)
        self.sources = sources_of_module(module)
        self.plain: dict[str, Callable[..., Any]] = {}
        others = {name: arguments for name, arguments in _OTHERS.items() if hasattr(module, name)}
        for name, arguments in {**others, **called}.items():
            prepared = ("prepared",) if name in called and "prepare" in others else ()
            _require_function(getattr(module, name), name, (*arguments, *prepared), what)
        for name in called:
            function = getattr(module, name)
            if "prepare" in others:
                function = _handed(function)
            self.plain[name] = guarded(function, what)
            setattr(self, name, with_floats_of(traceable(function, what)))
        for name in others:
            setattr(self, name, guarded(getattr(module, name), what))
        self.initial_state = _of_floats(guarded(module.initial_state, what), what)
        for name in ("PROVIDES", "REQUIRES", "OPTIONAL"):
            if hasattr(module, name):
                setattr(self, name, getattr(module, name))


def _require_function(function: Any, name: str, arguments: Sequence[str], what: str) -> None:
    """A `UserCodeError` unless a function of a law can be called as it will be."""
    if not callable(function):
        raise UserCodeError(f"{what}: {name} is no function, but one {type(function).__name__}")
    try:
        signature = inspect.signature(function)
    except ValueError:  # of a function in C nothing is known
        return
    try:
        signature.bind(*arguments)
    except TypeError:
        code = getattr(function, "__code__", None)
        place = f" in {Place(code.co_filename, code.co_firstlineno)}" if code else ""
        raise UserCodeError(
            f"{what}{place}: {name}({', '.join(signature.parameters)}) is called as "
            f"{name}({', '.join(arguments)})"
        ) from None


def _handed(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of a law that is handed what `prepare` made, behind its other arguments."""

    @functools.wraps(function)
    def call(prepared: Prepared, *given: Any) -> Any:
        return function(prepared.gains, *given, prepared.made)

    return call


def _of_floats(initial_state: Callable[..., Any], what: str) -> Callable[..., Any]:
    """A law's `initial_state`; what it returns is refused where a number in it is no float, or no number."""

    @functools.wraps(initial_state)
    def call(*given: Any) -> Any:
        state = initial_state(*given)
        for path, odd in _no_floats(state, ""):
            raise UserCodeError(
                f"{what}: initial_state returns {odd!r}{path and f' as {path}'}, expected floats and arrays, "
                "0.0 and not 0"
            )
        return state

    return call


def _no_floats(record: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Dotted name and value of all in a record that is no record itself and has no room in a flat vector."""
    if is_leaf(record):
        if not is_symbolic(record) and np.asarray(record).dtype.kind not in "fiub":
            yield path, record
        return
    children = list(children_of(record))
    if not children and record is not None and record not in ((), {}):
        yield path, record
    for name, child in children:
        yield from _no_floats(child, below(path, name))


def with_floats_of(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of a law that may give whole numbers, truth values, and lists and arrays of symbols."""

    @functools.wraps(function)
    def call(*given: Any) -> Any:
        result = function(*given)
        if not isinstance(result, tuple | list) or len(result) != 3 or hasattr(result, "_fields"):
            return symbolic_record(result)
        state, *others = map(symbolic_record, result)
        return state, *map(with_floats, others)

    return call


def traceable(function: Callable[..., Any], what: str) -> Callable[..., Any]:
    """A user's function that is called with numbers or symbols; errors are described in a line.

    A symbol that was asked for its number is an error even where the function catches it: what it does then
    is what it does after an error, and not what it does with numbers.
    """

    @functools.wraps(function)
    def call(*given: Any) -> Any:
        # CasADi warns of each NumPy function that meets its symbols, which do what they should here.
        with UserCode(what, function), warnings.catch_warnings(), symbols_are_no_numbers() as raised:
            warnings.simplefilter("ignore", FutureWarning)
            result = function(*given)
            if raised:
                raise raised[0]
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
