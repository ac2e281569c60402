"""A compiled tick as machine code, for the control callback."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

from skylimb.base.errors import ConfigError
from skylimb.flight.drivers.machine_code import loaded
from skylimb.simulation.plant import Plant
from skylimb.simulation.scene import USER_WORDS
from skylimb.simulation.tick import CompiledTick


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
    return NativeTick(tick, *loaded(tick.function))
