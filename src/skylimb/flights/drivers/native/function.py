"""A compiled tick as machine code: written as C by CasADi, built once, kept in the cache."""

from __future__ import annotations

import ctypes
from collections import OrderedDict
from dataclasses import dataclass

import casadi as ca

from skylimb.c_code import c_source
from skylimb.errors import CompileError, ConfigError
from skylimb.simulation.compiling import built_before, built_library, load_library, met_before
from skylimb.simulation.plant import Plant
from skylimb.simulation.scene import USER_WORDS
from skylimb.simulation.tick import CompiledTick

_MOST_ARGUMENTS, _MOST_RESULTS = 512, 128  # as in flight.c
_FOLDER = "native"


@dataclass(frozen=True)
class NativeTick:
    """A tick as machine code.

    Attributes:
        tick: what it was made of; its gains and first state are data and may be replaced.
        library: the loaded code.
        address: of its function.
    """

    tick: CompiledTick
    library: ctypes.CDLL
    address: int


_loaded: OrderedDict[int, tuple[ca.Function, ctypes.CDLL, int]] = OrderedDict()
_MOST_LOADED = 64


def compile_native(tick: CompiledTick, plant: Plant) -> NativeTick:
    """Build the tick, or take it from the cache; gains, seeds and first states share one build.

    Raises:
        CompileError: when there is no compiler that builds it.
        ConfigError: when the plant's scene has no room for the driver's words.
    """
    if plant.model.nuserdata < USER_WORDS:
        raise ConfigError(
            f"the native driver needs {USER_WORDS} words of userdata; the scene has {plant.model.nuserdata}"
        )
    # The function is kept with its library, so that no other one can get its hash.
    key = hash(tick.function)
    if key not in _loaded:
        _loaded[key] = (tick.function, *_build(tick.function))
        while len(_loaded) > _MOST_LOADED:
            _loaded.popitem(last=False)
    _, library, address = _loaded[key]
    return NativeTick(tick, library, address)


def worth_building(function: ca.Function) -> bool:
    """Whether a single flight should use machine code: it is loaded, in the cache, or flown again.

    Building takes as long as it saves over some ten flights, so a function that is met for the first time on
    this machine is evaluated by CasADi.
    """
    return hash(function) in _loaded or met_before(_FOLDER, function.name(), c_source(function))


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
    if function.sz_arg() > _MOST_ARGUMENTS or function.sz_res() > _MOST_RESULTS or function.sz_iw():
        raise CompileError(f"function '{function.name()}' needs more work space than the native driver has")
    library = load_library(built_library(_FOLDER, function.name(), c_source(function)))
    address = ctypes.cast(getattr(library, function.name()), ctypes.c_void_p).value
    assert address is not None
    return library, address
