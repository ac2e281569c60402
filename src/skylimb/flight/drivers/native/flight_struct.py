"""The record that the control callback flies from, and the arrays that it points to."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np

from skylimb.control.loop.loop import CHECK_INTERVAL
from skylimb.control.loop.terminations import watched_columns
from skylimb.flight.drivers.hooks import bound_places, friction_writer, written_plant
from skylimb.flight.events import Timeline
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.c_struct import address
from skylimb.simulation.contact_keys import PAIR_NAME
from skylimb.simulation.plant import Plant
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.surfaces.pair_friction import FrictionTable, friction_table

MARK = 1936419121.0
"""Second word of `data.userdata` of a flight; the first is its record's address."""

_SLACK, _CLOSE = 1e-6, 0.01  # the callback stops only flights that `find_loss` is sure to call lost
_Word, _Number = ctypes.c_int64, ctypes.c_double
_Numbers, _Given, _Words = address("double*"), address("const double*"), address("const int64_t*")
_WARNINGS = int(mujoco.mjtWarning.mjNWARNING)


class Written(ctypes.Structure):
    """Numbers of the model that events write; `Written` of flight.c.

    to: where they stand. count: how many. column: of the first one in a row of what is written. actuators: 1
    for numbers of actuators, which the engine reads after the callback of a step, 0 for what it reads before.
    """

    _fields_ = (("to", _Numbers), ("count", _Word), ("column", _Word), ("actuators", _Word))


class _Inputs(NamedTuple):
    """What the fields of a `FlightStruct` are read from; the plant has a model that may be written."""

    takeoff: Takeoff
    function: int
    plant: Plant
    events: Timeline
    log: np.ndarray
    watched: np.ndarray
    friction: FrictionTable | None
    written: list[Written]


class _Field(NamedTuple):
    """A field of a `FlightStruct`: its name, its type in C, and where its value comes from.

    An array is kept alive and its address stored; None leaves zeros. A field without a source is the
    callback's own, and begins with zero.
    """

    name: str
    kind: Any
    source: Callable[[_Inputs], Any] = lambda _: None


def _limits(flight: _Inputs) -> tuple[float, float, float]:
    limits = flight.takeoff.experiment.terminations
    tilt = math.cos(min(limits.tilt, math.pi))
    return tilt - _SLACK, limits.distance + _CLOSE, limits.height - _SLACK


def _gains(name: str) -> Callable[[_Inputs], Any]:
    return lambda flight: None if flight.events.gains is None else getattr(flight.events.gains, name)


def _friction(source: Callable[[FrictionTable], Any]) -> Callable[[_Inputs], Any]:
    return lambda flight: None if flight.friction is None else source(flight.friction)


def _of_model(source: Callable[[mujoco.MjModel], Any]) -> Callable[[_Inputs], Any]:
    return lambda flight: None if flight.friction is None else source(flight.plant.model)


def _states(flight: _Inputs) -> tuple[np.ndarray, np.ndarray]:
    return flight.takeoff.tick.state.copy(), flight.takeoff.tick.state.copy()


FIELDS = (
    # The compiled function, and how many ticks, physics steps in each, and numbers there are.
    _Field("tick", address("Tick"), lambda f: f.function),
    _Field("count", _Word, lambda f: f.takeoff.count),
    _Field("substeps", _Word, lambda f: f.plant.substeps),
    _Field("n_row", _Word, lambda f: f.takeoff.tick.rows.size),
    _Field("n_signals", _Word, lambda f: f.takeoff.tick.signals.size),
    _Field("interval", _Word, lambda f: CHECK_INTERVAL),
    _Field("n_reference", _Word, lambda f: f.takeoff.rows.references.shape[1]),
    # The mission's last tick; where in the state its clock is, -1 where it goes with the flight's; the tick
    # that comes next; 1 when the mission is over.
    _Field("last", _Word, lambda f: f.takeoff.rows.last),
    _Field("clock", _Word, lambda f: -1 if f.takeoff.tick.clock is None else f.takeoff.tick.clock),
    _Field("at", _Word),
    _Field("finished", _Word),
    # What is known beforehand, and what is made: a row a tick. States before and after a tick change places.
    _Field("rows", _Given, lambda f: f.takeoff.rows.ticks),
    _Field("references", _Given, lambda f: f.takeoff.rows.references),
    _Field("log", _Numbers, lambda f: f.log),
    _Field("state", _Numbers * 2, _states),
    _Field("gains", _Numbers, lambda f: f.takeoff.tick.gains.copy()),
    _Field("rotors", _Given, lambda f: f.takeoff.tick.rotors),
    _Field("n_changing", _Word, lambda f: 0 if f.events.gains is None else len(f.events.gains.columns)),
    _Field("changing", _Words, _gains("columns")),
    _Field("changing_values", _Given, _gains("values")),
    _Field("work", _Numbers, lambda f: np.zeros(max(1, f.takeoff.tick.function.sz_w()))),
    # Beyond which a flight is surely lost: position of the root's reference, (last + 1, 3), m; columns of the
    # log that must be finite; cosine of the tilt, distance (m) and height (m).
    _Field("position", _Given, lambda f: f.takeoff.mission.reference.position),
    _Field("watched", _Words, lambda f: f.watched),
    _Field("n_watched", _Word, lambda f: len(f.watched)),
    _Field("limits", _Number * 3, _limits),
    # Physics steps made; 1 when nothing is flown any more; 1 when the engine's warnings must be counted anew,
    # as data may have served another flight; 1 when the engine went on after the last tick, and its warnings
    # were looked at before; ticks flown when a warning was found, or -1; how many warnings of each kind
    # there had been before this flight was continued, then how many new.
    _Field("done", _Word),
    _Field("stopped", _Word),
    _Field("fresh", _Word, lambda f: 1),
    _Field("closed", _Word),
    _Field("warned", _Word, lambda f: -1),
    _Field("warnings", _Word * _WARNINGS),
    # A moving surface: its joint, or -1, and displacement and speed at every tick, (count, 2).
    _Field("wall_qpos", _Word, lambda f: (f.plant.wall_joint or (-1, -1))[0]),
    _Field("wall_dof", _Word, lambda f: (f.plant.wall_joint or (-1, -1))[1]),
    _Field("wall", _Given, lambda f: np.stack(f.plant.surface.motion(f.takeoff.times), axis=1)),
    _Field("n_wrenches", _Word, lambda f: len(f.events.wrenches)),
    _Field("wrenches", address("const Wrench*"), lambda f: _structs(f.events.wrenches)),
    # Friction that varies, with the numbers of `friction_function`; null where it is constant. The model is
    # of this flight alone. The binding's address of the engine's own structure is nowhere public.
    _Field("model", address("mjModel*"), _of_model(lambda model: model._address)),
    _Field("pair", _Word, _of_model(lambda model: model.pair(PAIR_NAME).id)),
    _Field("site", _Word, _of_model(lambda model: model.site(TIP_SITE).id)),
    _Field("friction_numbers", _Given, _friction(lambda table: table.numbers)),
    _Field("frictions", _Given, _friction(lambda table: table.frictions)),
    _Field("adhesions", _Given, _friction(lambda table: table.adhesions)),
    _Field("stiffness", _Number, _friction(lambda table: table.stiffness)),
    # Places of the model's numbers that events write, and those numbers at every tick, (count, n_written).
    _Field("n_places", _Word, lambda f: len(f.written)),
    _Field("places", address("const Written*"), lambda f: _structs(f.written)),
    _Field("n_written", _Word, lambda f: 0 if f.events.model is None else f.events.model.values.shape[1]),
    _Field("written", _Given, lambda f: None if f.events.model is None else f.events.model.values),
)
"""All that the callback reads and writes, in the order of the C structure."""


class FlightStruct(ctypes.Structure):
    """One flight as the callback sees it; `Flight` of flight.c is declared from these fields."""

    _fields_ = tuple((field.name, field.kind) for field in FIELDS)


@dataclass
class NativeFlight:
    """A flight on its way.

    Attributes:
        record: what the callback reads and writes.
        takeoff: what is flown.
        model: the flight's own where something is written into it, else the plant's.
        log: one row of signals a tick; NaN where nothing was flown.
        arrays: that the record points to.
    """

    record: FlightStruct
    takeoff: Takeoff
    model: mujoco.MjModel
    log: np.ndarray
    arrays: list[np.ndarray]

    @property
    def count(self) -> int:
        """Ticks that the flight may have."""
        return int(self.record.count)

    @property
    def over(self) -> bool:
        """Whether every tick has been flown."""
        return bool(self.record.finished) or int(self.record.done) == self.count * int(self.record.substeps)

    @property
    def flown(self) -> int:
        """Ticks begun; the last one's row is in the log."""
        return min(self.count, -(-int(self.record.done) // int(self.record.substeps)))

    @property
    def left(self) -> int:
        """Ticks that it needs at least until its mission is over, at the mission's own pace."""
        left = self.count - self.flown
        if self.record.clock < 0:
            return left
        # A mission that waited needs more of them; its last tick is flown too.
        return min(left, int(self.record.last) + 1 - int(self.record.at))


def begin_flight(takeoff: Takeoff, function: int, log: np.ndarray | None = None) -> NativeFlight:
    """A flight before its first tick.

    Args:
        takeoff: what is flown.
        function: address of the tick's compiled function.
        log: where its rows go; by default an array of its own for all of them.
    """
    signals, events = takeoff.tick.signals, takeoff.timeline(takeoff.times)
    plant = written_plant(takeoff.plant, events)
    varies = plant.surface.friction_varies
    if varies:
        friction_writer(plant, takeoff.data(), takeoff.times)(0)
    log = np.full((takeoff.count, signals.size), np.nan) if log is None else log
    written = list[Written]()
    if events.model is not None:
        places = bound_places(plant.model, events.model)
        for (numbers, columns), place in zip(places, events.model.places, strict=True):
            numbers[:] = events.model.values[0, columns]
            actuators = place.field.startswith("actuator_")
            written.append(Written(numbers.ctypes.data, numbers.size, columns.start, actuators))
    friction = friction_table(plant.surface) if varies else None
    inputs = _Inputs(takeoff, function, plant, events, log, watched_columns(signals), friction, written)
    record, arrays = FlightStruct(), list[np.ndarray]()
    for field in FIELDS:
        value = field.source(inputs)
        if value is not None:
            setattr(record, field.name, _in_c(value, field.kind, arrays))
    return NativeFlight(record, takeoff, plant.model, log, arrays)


def _in_c(value: Any, kind: Any, arrays: list[np.ndarray]) -> Any:
    """A value as its field takes it: of an array the address, in the form that C reads."""
    if isinstance(value, tuple) and kind is _Numbers * 2:
        return kind(*(_in_c(one, _Numbers, arrays) for one in value))
    if not isinstance(value, np.ndarray):
        return value
    if value.dtype != np.uint8:  # the bytes of structures
        value = np.ascontiguousarray(value, dtype=np.int64 if kind is _Words else np.float64)
    arrays.append(value)
    return value.ctypes.data


def _structs(structs: Sequence[ctypes.Structure]) -> np.ndarray:
    """Structures one behind the other, as bytes."""
    return np.frombuffer(b"".join(map(bytes, structs)) or bytes(1), np.uint8)
