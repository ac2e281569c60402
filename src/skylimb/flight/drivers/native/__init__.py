"""The native driver: ticks as machine code on the engine's own threads."""

from skylimb.flight.drivers.machine_code import compile_native
from skylimb.flight.drivers.native.fly import fly_native
from skylimb.flight.drivers.native.library import native_available, unavailable

__all__ = ["compile_native", "fly_native", "native_available", "unavailable"]
