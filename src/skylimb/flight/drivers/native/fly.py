"""Many flights at once on the engine's own threads, with no Python in the loop."""

from __future__ import annotations

import ctypes
import warnings
from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError

from skylimb.control.loop.flight import Flight, Interrupted, stopped_cause, unfinished
from skylimb.control.loop.loop import CHECK_INTERVAL, Loop, Progress, fault_cause
from skylimb.control.loop.terminations import find_loss
from skylimb.flight.drivers.compiled import CompiledDriver
from skylimb.flight.drivers.machine_code import compile_native
from skylimb.flight.drivers.native.flight_struct import MARK, NativeFlight, begin_flight
from skylimb.flight.drivers.native.library import control_callback, unavailable
from skylimb.flight.drivers.world import world
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.engine_timer import without_timer
from skylimb.simulation.engine_warnings import raised_warnings

CHUNK = 20 * CHECK_INTERVAL
"""Ticks after which lost flights are taken out, and Ctrl-C is heard."""

_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)
_USERDATA = int(mujoco.mjtState.mjSTATE_USERDATA)


def fly_native(
    takeoffs: Sequence[Takeoff], threads: int = 1, progress: Progress | None = None
) -> list[Flight]:
    """Make every flight; the results are those of the compiled driver, to the bit at any number of threads.

    Flights whose scenes have the same structure fly together; friction, masses, rotors, surfaces' places,
    controllers, gains, seeds and lengths may differ. Memory grows by the rows and the log of every
    flight: some 10 MB for one of the paper's, so hand over a few dozen at a time. Without a C compiler, and
    those with a law in Python, they fly one after the other, with the compiled driver.

    Args:
        takeoffs: in any order and mixture; their controllers can be traced.
        threads: that fly at the same time, the caller's included.
        progress: called with (ticks flown, ticks in all), over all flights.
    """
    flights, groups = dict[int, Flight](), dict[tuple[int, ...], list[int]]()
    total, behind = sum(takeoff.count for takeoff in takeoffs), 0
    reason = unavailable()
    if reason:
        warnings.warn(f"flying one by one, with the compiled driver: {reason}", UserWarning, stacklevel=2)
    for index, takeoff in enumerate(takeoffs):
        groups.setdefault(structure_of(takeoff), []).append(index)
    for members in groups.values():

        def report(flown: int, behind: int = behind) -> None:
            if progress is not None:
                progress(behind + flown, total)

        group = [takeoffs[index] for index in members]
        one_by_one = reason or not group[0].compiled
        made = [_fly_compiled(one) for one in group] if one_by_one else _fly_group(group, threads, report)
        flights |= zip(members, made, strict=True)
        behind += sum(takeoff.count for takeoff in group)
        report(0, behind)
    return [flights[index] for index in range(len(takeoffs))]


def structure_of(takeoff: Takeoff) -> tuple[int, ...]:
    """What flights that fly together have in common."""
    model = takeoff.plant.model
    return takeoff.compiled, int(model.signature), int(model.nbuffer), takeoff.plant.substeps


def _fly_compiled(takeoff: Takeoff) -> Flight:
    here = world(takeoff)
    parts = here.plant, here.data, takeoff.rows, here.hooks, here.events.gains
    driver = CompiledDriver(takeoff.tick, *parts, advance=here.advance)
    with without_timer():
        return Loop(driver, takeoff.mission, takeoff.experiment.terminations, takeoff.count).fly()


def _fly_group(takeoffs: Sequence[Takeoff], threads: int, report: Callable[[int], None]) -> list[Flight]:
    """Flights of one structure."""
    flights = [begin_flight(takeoff, compile_native(takeoff.tick.function)[1]) for takeoff in takeoffs]
    substeps, first = takeoffs[0].plant.substeps, takeoffs[0].plant.model
    batch = Batch(first, len(flights), min(threads, len(flights)))
    batch.set_models([flight.model for flight in flights])
    for index, flight in enumerate(flights):
        seat(batch, index, flight)
    ids = [index for index, flight in enumerate(flights) if flight.count > 0]
    with control_callback(), without_timer():
        while ids:  # Ctrl-C is heard in between
            # Pauses fall between two windows of the look-out for losses. The engine goes on with a flight
            # that ends in between, without a controller: that takes time and may make it warn.
            least = max(1, min(flights[index].left for index in ids))
            ticks = min(CHUNK, -(-least // CHECK_INTERVAL) * CHECK_INTERVAL)
            try:
                step_flights(batch, flights, ids, ticks * substeps)
                report(sum(flight.flown for flight in flights))
            except KeyboardInterrupt as stop:
                raise (Interrupted(_stopped(flights[0])) if len(flights) == 1 else stop) from None
            ids = [index for index in ids if not flights[index].record.stopped]
    return [_finish(flight) for flight in flights]


def seat(batch: Batch, index: int, flight: NativeFlight) -> None:
    """Put a flight before its first tick into a place of a batch."""
    model = flight.takeoff.plant.model
    mujoco.mj_getState(model, flight.takeoff.data(), batch.state[index], _STATE)
    # A state's parts stand in the order of their bits.
    words = mujoco.mj_stateSize(model, _STATE & (_USERDATA - 1))
    # An address has fewer bits than a float's 53, so that it crosses unharmed.
    batch.state[index, words : words + 2] = (float(ctypes.addressof(flight.record)), MARK)


def step_flights(batch: Batch, flights: Sequence[NativeFlight], ids: list[int], steps: int) -> None:
    """Continue some flights, and note what the engine warned of since the callback last looked."""
    before = batch.warning[..., 1].copy()
    for index in ids:
        flights[index].record.fresh = 1
    try:
        batch.step(np.array(ids), steps)
    except SimulationError as error:
        # What the engine does with a flight that was lost before is of no interest.
        if any(not flights[index].record.stopped for index in error.ids):
            raise
    new = batch.warning[..., 1] - before
    for index in ids:
        flight, record = flights[index], flights[index].record
        at_hand = not record.stopped or (flight.over and not record.closed)
        if record.warned < 0 and at_hand and new[index].any():
            record.warned, record.stopped = flight.flown, 1
            record.warnings[:] = new[index].tolist()


def _stopped(flight: NativeFlight) -> Flight:
    """A flight that ends in the middle, with that as its cause."""
    cause = stopped_cause(flight.flown, flight.takeoff.mission)
    return Flight(flight.log, flight.takeoff.tick.signals, flight.flown, cause)


def _finish(flight: NativeFlight) -> Flight:
    """The verdict on a flight that has ended."""
    mission, layout, flown = flight.takeoff.mission, flight.takeoff.tick.signals, flight.flown
    made = Flight(flight.log, layout, flown, "")
    lost = find_loss(made, mission, flight.takeoff.experiment.terminations)
    warned = int(flight.record.warned)
    if warned >= 0 and (lost is None or lost[0] >= warned):
        lost = warned - 1, fault_cause(raised_warnings(list(flight.record.warnings)), warned, mission)
    if lost is not None:
        return Flight(flight.log, layout, lost[0] + 1, lost[1])
    if not flight.over:
        raise RuntimeError(f"the flight stopped at tick {flown} without being lost")
    # A pace above 1 may leap over the mission's last tick.
    return made if flight.record.at > flight.record.last else unfinished(mission, made)
