"""Many flights that go on together, some ticks at a time, with whatever is done to them in between."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import mujoco
import numpy as np
from mujoco.batch import Batch

from skylimb.base.errors import ConfigError
from skylimb.flight.drivers.machine_code import compile_native
from skylimb.flight.drivers.native.flight_struct import NativeFlight, begin_flight
from skylimb.flight.drivers.native.fly import seat, step_flights, structure_of
from skylimb.flight.drivers.native.library import callback_library, control_callback
from skylimb.flight.drivers.python_time import python_parts
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.engine_timer import without_timer
from skylimb.simulation.robot_bodies import TIP_SITE

_PLACES = tuple(int(getattr(mujoco.mjtState, f"mjSTATE_{name}")) for name in ("QPOS", "QVEL", "ACT"))


class LockStep:
    """Flights of one structure, each in its place, on the engine's own threads.

    What a place flies is that of the native driver to the bit, at any number of threads and places.

    Args:
        takeoffs: what each place flies first.
        ticks: that are flown at once, at most.
        threads: that fly at the same time, the caller's included.

    Attributes:
        rows: signals of the ticks that were flown last, (places, ticks + 1, signals); NaN beyond.
        flights: what is in each place.
        asked: the references of each place's mission, as `FlightRows` has them.
        gains: the gains of each place's controller, flat; what is written there counts from the next tick on.

    Raises:
        ConfigError: when a take-off has laws in Python, or its scene another structure than the first.
        CompileError: when there is no C compiler.
    """

    def __init__(self, takeoffs: Sequence[Takeoff], ticks: int, threads: int = 1) -> None:
        callback_library()
        first = takeoffs[0]
        self._structure, self._substeps = structure_of(first), first.plant.substeps
        signals, places = first.tick.signals.size, len(takeoffs)
        self.rows = np.full((len(takeoffs), ticks + 1, signals), np.nan)
        self._row = signals * self.rows.itemsize
        self._batch = Batch(first.plant.model, places, min(threads, places))
        self._sites = self._batch.bind("site_xpos").reshape(places, -1, 3)
        self._tip = first.plant.model.site(TIP_SITE).id
        self.flights = [self._begun(place, takeoff) for place, takeoff in enumerate(takeoffs)]
        self.asked, self.gains = [np.zeros(0)] * places, [np.zeros(0)] * places
        self._first = [(b"", np.zeros(0))] * places  # record and engine's state before the first tick
        self._parts = [
            (
                begin := mujoco.mj_stateSize(first.plant.model, bit - 1),
                begin + mujoco.mj_stateSize(first.plant.model, bit),
            )
            for bit in _PLACES
        ]
        self._seat(range(places))

    @property
    def tips(self) -> np.ndarray:
        """Where the tip was before the last physics step, W, m, (places, 3)."""
        return self._sites[:, self._tip]

    def restart(self, takeoffs: dict[int, Takeoff]) -> None:
        """Begin other flights in some places."""
        for place, takeoff in takeoffs.items():
            self.flights[place] = self._begun(place, takeoff)
        self._seat(list(takeoffs))

    def fly(self, places: Sequence[int], ticks: int) -> np.ndarray:
        """Fly some ticks in some places; a flight that ends or is lost stays as it is.

        Returns:
            How many ticks each of the places has flown, (places,).
        """
        before = [self.flights[place].flown for place in places]
        for place, flown in zip(places, before, strict=True):
            # The callback writes row k of a log; here the first row is that of the tick that comes next.
            self.flights[place].record.log = self.rows[place].ctypes.data - flown * self._row
        self.rows[list(places)] = np.nan
        going = [place for place in places if not self.flights[place].record.stopped]
        if going:
            with control_callback(), without_timer():
                step_flights(self._batch, self.flights, going, ticks * self._substeps)
        return np.array([self.flights[place].flown for place in places]) - before

    def again(self, place: int, qpos: np.ndarray, qvel: np.ndarray, act: np.ndarray) -> None:
        """Begin a place's flight again, elsewhere: (nq,), (nv,) and (na,) of the engine; not with events.

        Some tens of times sooner than `restart`. References and gains that were written stay as they are.
        """
        flight, (record, first) = self.flights[place], self._first[place]
        asked = flight.record.references.value  # the field itself is a view of the record
        ctypes.memmove(ctypes.byref(flight.record), record, ctypes.sizeof(flight.record))
        flight.record.references = asked
        tick = flight.takeoff.tick.state
        ctypes.memmove(flight.record.state[0], tick.ctypes.data, tick.nbytes)
        state = self._batch.state[place]
        state[:] = first
        for part, (begin, end) in zip((qpos, qvel, act), self._parts, strict=True):
            state[begin:end] = part

    def own_references(self, place: int) -> np.ndarray:
        """What a place's flight reads in place of `asked`: a copy, which may be written."""
        flight, own = self.flights[place], self.asked[place].copy()
        flight.arrays.append(own)
        flight.record.references = own.ctypes.data
        return own

    def _begun(self, place: int, takeoff: Takeoff) -> NativeFlight:
        if not takeoff.compiled:
            said = "; ".join(
                ": ".join(filter(None, part)) for part in python_parts(takeoff.controller).items()
            )
            raise ConfigError(
                f"controller '{takeoff.controller.name}' flies in Python, not in lock-step, which takes "
                f"compiled ones alone ({said})"
            )
        if structure_of(takeoff) != self._structure or takeoff.tick.signals.size != self.rows.shape[2]:
            raise ConfigError(
                f"experiment {takeoff.experiment.name}: flights in lock-step need one robot, one kind of "
                "surface and one controller; this one differs"
            )
        return begin_flight(takeoff, compile_native(takeoff.tick.function)[1], self.rows[place])

    def _seat(self, places: Sequence[int]) -> None:
        self._batch.set_models([flight.model for flight in self.flights])
        for place in places:
            flight = self.flights[place]
            seat(self._batch, place, flight)
            self.asked[place] = flight.takeoff.rows.references
            gains = ctypes.cast(flight.record.gains, ctypes.POINTER(ctypes.c_double))
            self.gains[place] = np.ctypeslib.as_array(gains, (flight.takeoff.tick.gains.size,))
            self._first[place] = bytes(flight.record), self._batch.state[place].copy()
