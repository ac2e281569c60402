"""Keeps the engine from reading a clock while it flies, and from writing.

The engine's Python bindings hand it a clock, which it then reads many times in every physics step to fill
timers that nobody here looks at: a tenth of a flight. Without a clock the numbers are the same to the bit.
What it warns of would go to the terminal and into a file of the working folder; a flight's cause says it.
"""

from __future__ import annotations

import ctypes
import functools
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from skylimb.base.errors import CompileError
from skylimb.base.shared import shared
from skylimb.simulation.compiling import engine_library


@shared
@contextmanager
def without_timer() -> Iterator[None]:
    """Take the engine's clock away, and its voice; who leaves last puts them back."""
    engine, slot = sys.modules.get("mujoco"), _slot()  # what flies a real robot has no engine
    with ExitStack() as put_back:
        if engine is not None:
            put_back.callback(engine.set_mju_user_warning, engine.get_mju_user_warning())
            engine.set_mju_user_warning(lambda message: None)
        if slot is not None:
            put_back.callback(setattr, slot, "value", slot.value)
            slot.value = None
        yield


@functools.cache
def _slot() -> ctypes.c_void_p | None:
    """Where the engine keeps the address of its clock; None where its library does not show it."""
    try:
        return ctypes.c_void_p.in_dll(ctypes.CDLL(str(engine_library())), "mjcb_time")
    except (CompileError, OSError, ValueError):
        return None
