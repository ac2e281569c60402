"""Many flights at once on the engine's own threads, with no Python in the loop."""

from __future__ import annotations

import ctypes
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError

from skylimb.simulation.clock import without_clock
from skylimb.simulation.disturbance import DisturbanceConfig
from skylimb.simulation.drivers import FlightRows, fly_compiled, interventions
from skylimb.simulation.flight import CHECK_INTERVAL, Flight, engine_loss, find_loss, unfinished
from skylimb.simulation.mission import Mission
from skylimb.simulation.native.function import NativeTick, compile_native
from skylimb.simulation.native.library import control_callback, unavailable
from skylimb.simulation.native.record import MARK, Aloft, begin_flight
from skylimb.simulation.plant import Plant
from skylimb.simulation.tick import CompiledTick

CHUNK = 20 * CHECK_INTERVAL
"""Ticks after which lost flights are taken out, and Ctrl-C is heard."""

Progress = Callable[[int, int], None]
"""Called now and then with (ticks flown, ticks in all), over all flights."""

_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)
_USERDATA = int(mujoco.mjtState.mjSTATE_USERDATA)


@dataclass(frozen=True)
class NativeJob:
    """One flight to make: what `fly_compiled` and `interventions` take.

    Attributes:
        tick: compiled or native; its gains and first state are this flight's.
        plant: what is flown. Jobs may share one, and its model is left as it is.
        data: the plant's state before the first tick; left as it is.
        mission: what to fly.
        rows: what is known of it before.
        disturbance: a push.
    """

    tick: CompiledTick | NativeTick
    plant: Plant
    data: mujoco.MjData
    mission: Mission
    rows: FlightRows
    disturbance: DisturbanceConfig = field(default_factory=DisturbanceConfig)

    @property
    def compiled(self) -> CompiledTick:
        """The tick with its layouts, gains and first state."""
        return self.tick.tick if isinstance(self.tick, NativeTick) else self.tick


def fly_native(jobs: Sequence[NativeJob], threads: int = 1, progress: Progress | None = None) -> list[Flight]:
    """Make every flight; the results are those of `fly_compiled`, to the bit at any number of threads.

    Flights whose scenes have the same structure fly together; friction, masses, rotors, surfaces' places,
    controllers, gains, seeds and lengths may differ. Memory grows by the rows and the log of every job: some
    10 MB for one of the paper's, so hand over a few dozen at a time. Without a C compiler the Python driver
    flies, one after the other.

    Args:
        jobs: in any order and mixture.
        threads: that fly at the same time, the caller's included.
        progress: told how far all the flights are.
    """
    total, behind = sum(len(job.rows) for job in jobs), 0
    flights: list[Flight | None] = [None] * len(jobs)
    reason = unavailable()
    if reason:
        warnings.warn(f"flying one by one, with the Python driver: {reason}", UserWarning, stacklevel=2)
    groups: dict[tuple[int, ...], list[int]] = {}
    for index, job in enumerate(jobs):
        model = job.plant.model
        groups.setdefault((int(model.signature), int(model.nbuffer), job.plant.substeps), []).append(index)
    for members in groups.values():

        def report(flown: int, behind: int = behind) -> None:
            if progress is not None:
                progress(behind + flown, total)

        group = [jobs[index] for index in members]
        made = [_fly_python(job) for job in group] if reason else _fly_group(group, threads, report)
        for index, flight in zip(members, made, strict=True):
            flights[index] = flight
        behind += sum(len(job.rows) for job in group)
        report(0, behind)
    return [flight for flight in flights if flight is not None]


def _fly_python(job: NativeJob) -> Flight:
    data = mujoco.MjData(job.plant.model)
    mujoco.mj_copyData(data, job.plant.model, job.data)
    times = job.mission.flight_times(job.compiled.clock is not None)
    outside = interventions(job.plant, data, times, job.disturbance)
    return fly_compiled(job.compiled, job.plant, data, job.mission, job.rows, outside)


def _fly_group(jobs: Sequence[NativeJob], threads: int, report: Callable[[int], None]) -> list[Flight]:
    """Flights of one structure."""
    flights = [_begin(job) for job in jobs]
    substeps, first = jobs[0].plant.substeps, jobs[0].plant.model
    batch = Batch(first, len(jobs), min(threads, len(jobs)))
    # A state's parts stand in the order of their bits.
    words = mujoco.mj_stateSize(first, _STATE & (_USERDATA - 1))
    batch.set_models([flight.model for flight in flights])
    for index, (job, flight) in enumerate(zip(jobs, flights, strict=True)):
        mujoco.mj_getState(job.plant.model, job.data, batch.state[index], _STATE)
        # An address has fewer bits than a float's 53, so that it crosses unharmed.
        batch.state[index, words : words + 2] = (float(ctypes.addressof(flight.record)), MARK)
    ids = [index for index, flight in enumerate(flights) if flight.count > 0]
    with control_callback(), without_clock():
        while ids:
            # Pauses fall between two windows of the look-out for losses; a flight that ends earlier waits.
            least = min(flights[index].count - flights[index].flown for index in ids)
            ticks = min(CHUNK, -(-least // CHECK_INTERVAL) * CHECK_INTERVAL)
            _step(batch, flights, ids, ticks * substeps)
            report(sum(flight.flown for flight in flights))
            ids = [index for index in ids if not flights[index].record.stopped]
    return [_finish(flight) for flight in flights]


def _begin(job: NativeJob) -> Aloft:
    tick = compile_native(job.compiled, job.plant)
    return begin_flight(tick.tick, tick.address, job.plant, job.data, job.mission, job.rows, job.disturbance)


def _step(batch: Batch, flights: Sequence[Aloft], ids: list[int], steps: int) -> None:
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


def _finish(flight: Aloft) -> Flight:
    """The verdict on a flight that has ended."""
    flown = flight.flown
    made = Flight(flight.log, flight.layout, flown, "")
    lost = find_loss(made, flight.mission)
    warned = int(flight.record.warned)
    if warned >= 0 and (lost is None or lost[0] >= warned):
        lost = engine_loss(flight.mission, warned, flight.record.warnings)
    if lost is not None:
        return Flight(flight.log, flight.layout, lost[0] + 1, lost[1])
    if not flight.over:
        raise RuntimeError(f"the flight stopped at tick {flown} without being lost")
    # A pace above 1 may leap over the mission's last tick.
    return made if flight.record.at > flight.record.last else unfinished(flight.mission, made)
