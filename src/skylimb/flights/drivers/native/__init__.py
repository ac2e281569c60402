"""The native driver: ticks as machine code on the engine's own threads."""

from skylimb.flights.drivers.native.fly import fly_native
from skylimb.flights.drivers.native.function import (
    NativeTick,
    compile_native,
    is_built,
    machine_code,
    worth_building,
)
from skylimb.flights.drivers.native.library import native_available, unavailable

__all__ = [
    "NativeTick",
    "compile_native",
    "fly_native",
    "is_built",
    "machine_code",
    "native_available",
    "unavailable",
    "worth_building",
]
