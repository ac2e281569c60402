"""Fly a take-off: choose the driver that suits it, and run the loop."""

from __future__ import annotations

import functools
import logging
from contextlib import suppress

from skylimb.base.errors import CompileError
from skylimb.base.split_function import made_faster
from skylimb.control.controller import Controller
from skylimb.control.loop.flight import Flight, Interrupted
from skylimb.control.loop.loop import Loop, Progress
from skylimb.flight.drivers.compiled import CompiledDriver
from skylimb.flight.drivers.free import FreeDriver
from skylimb.flight.drivers.machine_code import fastest, worth_building
from skylimb.flight.drivers.native import fly_native, native_available
from skylimb.flight.drivers.python_time import PythonTime, python_parts
from skylimb.flight.drivers.world import World, world
from skylimb.flight.events.rotor import thrust_scales
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.engine_timer import without_timer
from skylimb.simulation.plant_tick import rotor_scales
from skylimb.simulation.tick import CompiledTick
from skylimb.simulation.vehicle import SimulatedVehicle

_log = logging.getLogger(__name__)


def fly(takeoff: Takeoff, progress: Progress | None = None) -> Flight:
    """Fly to the end with the driver that takes the least time here; every driver gives the same flight.

    Raises:
        Interrupted: with what was flown, on Ctrl-C in flight.
    """
    if takeoff.compiled and worth_building(takeoff.tick.function) and native_available():
        with suppress(CompileError):  # nowhere to build it: another driver flies
            return fly_native([takeoff], progress=progress)[0]
    return fly_here(takeoff, progress)


def flew_in_python(controller: Controller, time: PythonTime) -> str:
    """What of a controller was not compiled, what a tick of it costs, and why; empty where nothing."""
    parts = python_parts(controller)
    if not parts:
        return ""
    names, why = " and ".join(parts), "; ".join(filter(None, parts.values()))
    fly, together = ("fly", " together") if len(parts) > 1 else ("flies", "")
    return f"{names} {fly} in Python, {time}{together}{why and f': {why}'}"


def fly_here(takeoff: Takeoff, progress: Progress | None = None) -> Flight:
    """Fly to the end in this process, with the compiled driver or the free one.

    Raises:
        Interrupted: with what was flown, on Ctrl-C in flight.
    """
    with without_timer():
        loop = begin_loop(takeoff)
        try:
            flight = loop.fly(progress)
        except KeyboardInterrupt as stop:
            raise (Interrupted(loop.stop()) if loop.ticks else stop) from None
    if isinstance(loop.driver, FreeDriver | CompiledDriver) and (time := loop.driver.python_time):
        _log.warning("%s", flew_in_python(takeoff.controller, time))
    return flight


def begin_loop(takeoff: Takeoff) -> Loop:
    """The loop of a simulated flight before its first tick, to be stepped from outside."""
    limits = takeoff.experiment.terminations
    return Loop(simulated_driver(takeoff, world(takeoff)), takeoff.mission, limits, takeoff.count)


def fastest_tick(takeoff: Takeoff, build: bool = True) -> CompiledTick:
    """The compiled tick as machine code where that pays, else on CasADi's virtual machine; same bits."""
    return made_faster(takeoff.tick, functools.partial(fastest, build=build))


def simulated_driver(
    takeoff: Takeoff, world: World, whole: bool = False, build: bool = True
) -> CompiledDriver | FreeDriver:
    """`compiled` for a controller that can be traced, else `free` on the simulated vehicle.

    Args:
        takeoff: what is flown.
        world: the flight's plant and what acts on it.
        whole: whether it has room for the whole mission, whenever the flight is to be stopped.
        build: whether there is time for a compiler; see `fastest`.
    """
    rows = takeoff.fixed_rows if whole else takeoff.rows
    if takeoff.traceable:
        tick = fastest_tick(takeoff, build)
        here = world.plant, world.data, rows, world.hooks, world.events.gains
        return CompiledDriver(tick, *here, advance=world.advance)
    vehicle = simulated_vehicle(takeoff, world, build)
    return FreeDriver(takeoff.controller, vehicle, world.plant.robot, takeoff.mission, len(rows))


def simulated_vehicle(takeoff: Takeoff, world: World, build: bool = True) -> SimulatedVehicle:
    """The flight's plant behind its sensors and actuators, for any controller; it applies plant events.

    Args:
        takeoff: gives sensors and period.
        world: the flight's plant and what acts on it.
        build: whether there is time for a compiler; see `fastest`.
    """
    faster = functools.partial(fastest, build=build)
    sensors = takeoff.remembering
    scales = thrust_scales(rotor_scales(takeoff.plant.model, takeoff.robot.n_rotors), world.events.model)
    here = world.plant, world.data, takeoff.calm_rows.ticks, sensors, takeoff.period, scales
    added = None if world.events.rows is None else world.events.rows.added
    return SimulatedVehicle(*here, world.hooks, faster, world.advance, added)
