"""The control callback as a library, installed into the engine while flights are on their way."""

from __future__ import annotations

import contextlib
import ctypes
import functools
from collections.abc import Iterator
from pathlib import Path

import mujoco

from skylimb.base.c_code import c_source
from skylimb.base.errors import CompileError
from skylimb.base.shared import shared
from skylimb.flight.drivers.native.flight_struct import FlightStruct, Written
from skylimb.flight.events import Wrench
from skylimb.simulation.c_struct import c_declaration
from skylimb.simulation.compiling import built_library, engine_library, load_library
from skylimb.simulation.surfaces.pair_friction import friction_function

_SOURCE = Path(__file__).with_name("flight.c")
_CONTROL = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)


class _Engine(ctypes.Structure):
    """`Engine` of flight.c."""

    _fields_ = tuple(
        (name, ctypes.c_void_p)
        for name in ("forward_position", "forward_velocity", "apply", "velocity", "previous")
    )


def unavailable() -> str:
    """Why the native driver cannot be used on this machine, in one line; empty where it can."""
    try:
        callback_library()
    except CompileError as error:
        return str(error)
    return ""


def native_available() -> bool:
    """Whether the native driver can be used on this machine; `unavailable` says why not."""
    return not unavailable()


@functools.cache
def callback_library() -> ctypes.CDLL:
    """The compiled callback.

    Raises:
        CompileError: when it cannot be built or loaded.
    """
    source = _SOURCE.read_text("utf-8")
    for mark, text in (
        ("@WRENCH@", c_declaration(Wrench)),
        ("@WRITTEN@", c_declaration(Written)),
        ("@FLIGHT@", c_declaration(FlightStruct, "Flight")),
        ("@FRICTION@", c_source(friction_function())),
    ):
        source = source.replace(mark, text)
    return load_library(built_library("native", "flight", source))


@shared
@contextlib.contextmanager
def control_callback() -> Iterator[None]:
    """Keep the callback installed; the one that was there before serves data that carries no flight."""
    library, before = callback_library(), mujoco.get_mjcb_control()
    engine = _Engine(*_functions(), ctypes.c_void_p.in_dll(_engine(), "mjcb_control").value)
    library.skylimb_set_engine(ctypes.byref(engine))
    mujoco.set_mjcb_control(_CONTROL(("skylimb_control", library)))
    try:
        yield
    finally:
        mujoco.set_mjcb_control(before)


@functools.cache
def _engine() -> ctypes.CDLL:
    return ctypes.CDLL(str(engine_library()))


@functools.cache
def _functions() -> tuple[int | None, ...]:
    """Addresses of the engine's functions, in the order of `Engine`."""
    names = ("mj_fwdPosition", "mj_fwdVelocity", "mj_applyFT", "mj_objectVelocity")
    return tuple(ctypes.cast(getattr(_engine(), name), ctypes.c_void_p).value for name in names)
