"""Fly a take-off: choose the driver that suits it, and run the loop."""

from __future__ import annotations

import dataclasses
import functools
import logging
from collections.abc import Callable, Sequence
from contextlib import suppress

import casadi as ca
import mujoco

from skylimb.control.own_controller import OwnController
from skylimb.errors import CompileError
from skylimb.flights.drivers.compiled import CompiledDriver
from skylimb.flights.drivers.free import FreeDriver
from skylimb.flights.drivers.native import (
    fly_native,
    is_built,
    machine_code,
    native_available,
    worth_building,
)
from skylimb.flights.takeoff import Takeoff
from skylimb.loop.flight import Flight
from skylimb.loop.loop import Loop
from skylimb.simulation.engine_timer import without_timer
from skylimb.simulation.interventions import interventions
from skylimb.simulation.rows import FlightRows
from skylimb.simulation.tick import CompiledTick
from skylimb.simulation.vehicle import SimulatedVehicle

_log = logging.getLogger(__name__)

Progress = Callable[[int, int], None]
"""Called now and then with (ticks flown, ticks in all)."""


def fly(takeoff: Takeoff, progress: Progress | None = None) -> Flight:
    """Fly to the end with the driver that takes the least time here; every driver gives the same flight."""
    if takeoff.traceable and worth_building(takeoff.tick.function) and native_available():
        with suppress(CompileError):  # nowhere to build it: another driver flies
            return fly_native([takeoff], progress=progress)[0]
    return fly_here(takeoff, progress)


def flew_in_python(takeoff: Takeoff, driver: FreeDriver) -> str:
    """That a controller was not compiled, what a tick of it costs, and why."""
    controller = takeoff.controller
    said = f"controller '{controller.name}' flies in Python, {1e6 * driver.step_time:.0f} us a tick"
    return f"{said}: {controller.untraceable}" if isinstance(controller, OwnController) else said


def fly_here(takeoff: Takeoff, progress: Progress | None = None) -> Flight:
    """Fly to the end in this process, with the compiled driver or the free one."""
    with without_timer():
        loop = begin_loop(takeoff)
        flight = loop.fly(progress)
    if isinstance(loop.driver, FreeDriver):
        _log.warning("%s", flew_in_python(takeoff, loop.driver))
    return flight


def begin_loop(takeoff: Takeoff) -> Loop:
    """The loop of a simulated flight before its first tick, to be stepped from outside."""
    if takeoff.experiment.surface_changes:
        takeoff = takeoff.with_own_model()
    data = takeoff.data()
    outside = interventions(takeoff.plant, data, takeoff.times, takeoff.pushes, takeoff.surface_table)
    driver = simulated_driver(takeoff, data, takeoff.rows, outside)
    return Loop(driver, takeoff.mission, takeoff.experiment.terminations, takeoff.count)


def fastest_tick(takeoff: Takeoff, build: bool = True) -> CompiledTick:
    """The compiled tick as machine code where that pays, else on CasADi's virtual machine; same bits."""
    return dataclasses.replace(takeoff.tick, function=fastest(takeoff.tick.function, build))


def fastest(function: ca.Function, build: bool = True) -> ca.Function:
    """A function as machine code where that pays, else as it is; same bits.

    Args:
        function: of one tick.
        build: whether there is time for a compiler; if not, machine code is taken where it is built already.
    """
    ready = worth_building(function) if build else is_built(function)
    if ready and native_available():
        with suppress(CompileError):  # nowhere to build it
            return machine_code(function)
    return function


def simulated_driver(
    takeoff: Takeoff,
    data: mujoco.MjData,
    rows: FlightRows,
    outside: Sequence[Callable[[int], None]],
    build: bool = True,
) -> CompiledDriver | FreeDriver:
    """`compiled` for a controller that can be traced, else `free` on the simulated vehicle.

    Args:
        takeoff: what is flown.
        data: the plant's state before the first tick; it is advanced.
        rows: what is known of the flight beforehand.
        outside: what acts on the plant from outside before a tick's physics.
        build: whether there is time for a compiler; see `fastest`.
    """
    plant = takeoff.plant
    if takeoff.traceable:
        return CompiledDriver(fastest_tick(takeoff, build), plant, data, rows, outside)
    faster = functools.partial(fastest, build=build)
    sensors = takeoff.experiment.sensors
    vehicle = SimulatedVehicle(plant, data, rows.ticks, sensors, takeoff.period, outside, faster)
    return FreeDriver(takeoff.controller, vehicle, plant.robot, takeoff.mission, len(rows))
