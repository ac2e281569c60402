"""CasADi functions as machine code: written as C, built once, kept in the cache. No engine is needed."""

from __future__ import annotations

import ctypes
from collections import OrderedDict
from contextlib import suppress

import casadi as ca

from skylimb.base.c_code import c_source
from skylimb.base.errors import CompileError
from skylimb.simulation.compiling import built_before, built_library, compilers, load_library, met_often

MOST_ARGUMENTS, MOST_RESULTS = 512, 128
"""Room that the native driver has for a function's arguments and results; as in flight.c."""

PAYS_AFTER = 10
"""Flights over which machine code saves as long as it takes to build (7 to 30 were measured)."""

_FOLDER = "native"
_loaded: OrderedDict[int, tuple[ca.Function, ctypes.CDLL, int]] = OrderedDict()
_MOST_LOADED = 64


def compile_native(function: ca.Function) -> tuple[ctypes.CDLL, int]:
    """The library of a function and the address of its code; built or taken from the cache.

    Raises:
        CompileError: when there is no compiler that builds it, or it needs more room than there is.
    """
    # The function is kept with its library, so that no other one can get its hash.
    key = hash(function)
    if key not in _loaded:
        _loaded[key] = (function, *_build(function))
        while len(_loaded) > _MOST_LOADED:
            _loaded.popitem(last=False)
    return _loaded[key][1:]


def worth_building(function: ca.Function) -> bool:
    """Whether a single flight should use machine code: it is loaded, in the cache, or flown often.

    Until then the function is evaluated by CasADi.
    """
    return hash(function) in _loaded or met_often(_FOLDER, function.name(), c_source(function), PAYS_AFTER)


def is_built(function: ca.Function) -> bool:
    """Whether its machine code is loaded or in the cache, so that nobody waits for a compiler."""
    return hash(function) in _loaded or built_before(_FOLDER, function.name(), c_source(function))


def machine_code(function: ca.Function) -> ca.Function:
    """The same function, evaluated as machine code; built or taken from the cache.

    Raises:
        CompileError: when there is no compiler that builds it.
    """
    path = built_library(_FOLDER, function.name(), c_source(function))
    return ca.external(function.name(), str(path))


def _build(function: ca.Function) -> tuple[ctypes.CDLL, int]:
    if function.sz_arg() > MOST_ARGUMENTS or function.sz_res() > MOST_RESULTS or function.sz_iw():
        raise CompileError(f"function '{function.name()}' needs more work space than the native driver has")
    library = load_library(built_library(_FOLDER, function.name(), c_source(function)))
    address = ctypes.cast(getattr(library, function.name()), ctypes.c_void_p).value
    assert address is not None
    return library, address


def fastest(function: ca.Function, build: bool = True, often: bool = False) -> ca.Function:
    """A function as machine code where that pays, else as it is; same bits.

    Args:
        function: of one tick.
        build: whether there is time for a compiler; if not, machine code is taken where it is built already.
        often: whether it is evaluated for so long that building it pays at once.
    """
    ready = (often or worth_building(function)) if build else is_built(function)
    if ready and compilers():
        with suppress(CompileError):  # nowhere to build it
            return machine_code(function)
    return function
