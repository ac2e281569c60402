"""The native driver: ticks as machine code on the engine's own threads, and C for a flight computer."""

from skylimb.simulation.native.export import export_c
from skylimb.simulation.native.fly import NativeJob, fly_native
from skylimb.simulation.native.function import NativeTick, compile_native
from skylimb.simulation.native.library import native_available, unavailable

__all__ = [
    "NativeJob",
    "NativeTick",
    "compile_native",
    "export_c",
    "fly_native",
    "native_available",
    "unavailable",
]
