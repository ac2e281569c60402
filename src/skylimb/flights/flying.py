"""Fly a take-off: choose the driver that suits it, and run the loop."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Callable
from contextlib import suppress

import casadi as ca

from skylimb.control.own_controller import OwnController
from skylimb.errors import CompileError
from skylimb.flights.drivers.compiled import CompiledDriver
from skylimb.flights.drivers.free import FreeDriver
from skylimb.flights.drivers.native import fly_native, machine_code, native_available, worth_building
from skylimb.flights.takeoff import Takeoff
from skylimb.loop.flight import Flight
from skylimb.loop.loop import Driver, Loop
from skylimb.simulation.engine_timer import without_timer
from skylimb.simulation.interventions import interventions
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
    limits = takeoff.experiment.terminations
    return Loop(simulated_driver(takeoff), takeoff.mission, limits, len(takeoff.times))


def fastest_tick(takeoff: Takeoff) -> CompiledTick:
    """The compiled tick as machine code where that pays, else on CasADi's virtual machine; same bits."""
    return dataclasses.replace(takeoff.tick, function=fastest(takeoff.tick.function))


def fastest(function: ca.Function) -> ca.Function:
    """A function as machine code where that pays, else as it is; same bits."""
    if worth_building(function) and native_available():
        with suppress(CompileError):  # nowhere to build it
            return machine_code(function)
    return function


def simulated_driver(takeoff: Takeoff) -> Driver:
    """`compiled` for a controller that can be traced, else `free` on the simulated vehicle."""
    plant, data, rows = takeoff.plant, takeoff.data(), takeoff.rows
    outside = interventions(plant, data, takeoff.times, takeoff.pushes)
    if takeoff.traceable:
        return CompiledDriver(fastest_tick(takeoff), plant, data, rows, outside)
    vehicle = SimulatedVehicle(
        plant, data, rows.ticks, takeoff.experiment.sensors, takeoff.period, outside, fastest
    )
    return FreeDriver(takeoff.controller, vehicle, plant.robot, takeoff.mission, len(rows))
