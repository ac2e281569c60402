"""Keeps the engine from reading a clock while it flies, and from writing.

The engine's Python bindings hand it a clock, which it then reads many times in every physics step to fill
timers that nobody here looks at: a tenth of a flight. Without a clock the numbers are the same to the bit.
What it warns of would go to the terminal and into a file of the working folder; a flight's cause says it.
"""

from __future__ import annotations

import ctypes
import functools
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from skylimb.base.errors import CompileError
from skylimb.simulation.compiling import engine_library

_lock = threading.Lock()
_users = 0
_clock: int | None = None
_warning: Any = None
_engine: ModuleType | None = None


@contextmanager
def without_timer() -> Iterator[None]:
    """Take the engine's clock away, and its voice; who comes last puts them back."""
    global _users, _clock, _engine, _warning  # noqa: PLW0603 - the engine has one of each for the whole process
    slot = _slot()
    with _lock:
        if _users == 0:
            _engine = sys.modules.get("mujoco")  # what flies a real robot has none
            if _engine is not None:
                _warning = _engine.get_mju_user_warning()
                _engine.set_mju_user_warning(lambda message: None)
            if slot is not None:
                _clock, slot.value = slot.value, None
        _users += 1
    try:
        yield
    finally:
        with _lock:
            _users -= 1
            if _users == 0:
                if _engine is not None:
                    _engine.set_mju_user_warning(_warning)
                if slot is not None:
                    slot.value = _clock


@functools.cache
def _slot() -> ctypes.c_void_p | None:
    """Where the engine keeps the address of its clock; None where its library does not show it."""
    try:
        return ctypes.c_void_p.in_dll(ctypes.CDLL(str(engine_library())), "mjcb_time")
    except (CompileError, OSError, ValueError):
        return None
