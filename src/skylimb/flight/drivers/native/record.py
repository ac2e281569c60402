"""The record that the control callback flies from, and the arrays that it points to."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from skylimb.base.packing import Layout
from skylimb.control.loop.loop import CHECK_INTERVAL
from skylimb.control.loop.terminations import Terminations, watched_columns
from skylimb.control.missions.mission import Mission
from skylimb.flight.drivers.acts import bound_places, friction_writer, written_plant
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.c_struct import address
from skylimb.simulation.contact_keys import PAIR_NAME
from skylimb.simulation.plant import Plant
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.surfaces.pair_friction import friction_table

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


class FlightRecord(ctypes.Structure):
    """What the callback reads and writes; `Flight` of flight.c is declared from these fields.

    tick: the compiled function. clock: where in its state the mission's clock is, -1 where it goes with
    the flight's. at, last: the mission's tick that comes next, and its last one. state: before the tick
    at hand and after it; they change places at every tick. position: of the root's reference, (last + 1,
    3), m. watched: columns of the log that must be finite. limits: cosine of the tilt, distance (m) and
    height (m) beyond which a flight is surely lost. done: physics steps made. stopped: 1 when nothing is
    flown any more. finished: 1 when the mission is over. fresh: 1 when the engine's warnings must be
    counted anew, as data may have served another flight. closed: 1 when the engine went on after the last
    tick, and its warnings were looked at before. warned: ticks flown when a warning was found, or -1.
    warnings: how many of each there had been before this flight was continued; then, how many new. wall:
    displacement and speed of a moving surface at every tick, (count, 2). wrenches: on the robot. model: of
    this flight alone, into which friction is written. friction_numbers: of `friction_function`.
    frictions: null where friction is constant. places: of the model's numbers that events write. written:
    those numbers at every tick, (count, n_written).
    """

    _fields_ = (
        ("tick", address("Tick")),
        ("count", _Word), ("substeps", _Word), ("n_row", _Word), ("n_signals", _Word), ("interval", _Word),
        ("n_reference", _Word), ("last", _Word), ("clock", _Word), ("at", _Word), ("finished", _Word),
        ("rows", _Given), ("references", _Given), ("log", _Numbers), ("state", _Numbers * 2),
        ("gains", _Numbers), ("n_changing", _Word), ("changing", _Words), ("changing_values", _Given),
        ("work", _Numbers),
        ("position", _Given), ("watched", _Words), ("n_watched", _Word), ("limits", _Number * 3),
        ("done", _Word), ("stopped", _Word), ("fresh", _Word), ("closed", _Word),
        ("warned", _Word), ("warnings", _Word * _WARNINGS),
        ("wall_qpos", _Word), ("wall_dof", _Word), ("wall", _Given),
        ("n_wrenches", _Word), ("wrenches", address("const Wrench*")),
        ("model", address("mjModel*")), ("pair", _Word), ("site", _Word), ("friction_numbers", _Given),
        ("frictions", _Given), ("adhesions", _Given), ("stiffness", _Number),
        ("n_places", _Word), ("places", address("const Written*")), ("n_written", _Word), ("written", _Given),
    )  # fmt: skip


@dataclass
class Aloft:
    """A flight on its way.

    Attributes:
        record: what the callback reads and writes.
        model: the flight's own where something is written into it, else the plant's.
        log: one row of signals a tick; NaN where nothing was flown.
        mission: what is flown.
        layout: of the log's rows.
        limits: beyond which the flight is lost.
        kept: arrays that the record points to.
    """

    record: FlightRecord
    model: mujoco.MjModel
    log: np.ndarray
    mission: Mission
    layout: Layout[Any]
    limits: Terminations
    kept: list[np.ndarray] = field(default_factory=list)

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

    def keep(self, array: np.ndarray, kind: Any = np.float64) -> int:
        """Address of the array in the form that C reads; kept alive with the flight."""
        kept = np.ascontiguousarray(array, dtype=kind)
        self.kept.append(kept)
        return kept.ctypes.data

    def keep_structs(self, structs: Sequence[ctypes.Structure]) -> int:
        """Address of structures one behind the other; kept alive with the flight."""
        return self.keep(np.frombuffer(b"".join(map(bytes, structs)) or bytes(1), np.uint8), np.uint8)


def begin_flight(takeoff: Takeoff, function: int) -> Aloft:
    """A flight before its first tick.

    Args:
        takeoff: what is flown.
        function: address of the tick's compiled function.
    """
    tick, plant, mission, rows = takeoff.tick, takeoff.plant, takeoff.mission, takeoff.rows
    count, times, events = len(rows), takeoff.times, takeoff.timeline
    limits = takeoff.experiment.terminations
    plant = written_plant(plant, events)
    model = plant.model
    if plant.surface.friction_varies:
        friction_writer(plant, takeoff.data(), times)(0)
    log = np.full((count, tick.signals.size), np.nan)
    flight = Aloft(FlightRecord(), model, log, mission, tick.signals, limits)
    record, keep = flight.record, flight.keep
    record.tick = function
    record.count, record.substeps, record.interval = count, plant.substeps, CHECK_INTERVAL
    record.n_row, record.n_signals = tick.rows.size, tick.signals.size
    record.rows, record.log, record.gains = keep(rows.ticks), keep(log), keep(tick.gains.copy())
    if events.gains is not None:
        record.n_changing = len(events.gains.columns)
        record.changing = keep(events.gains.columns, np.int64)
        record.changing_values = keep(events.gains.values)
    record.references, record.n_reference = keep(rows.references), rows.references.shape[1]
    record.last, record.clock = rows.last, -1 if tick.clock is None else tick.clock
    record.state[0], record.state[1] = keep(tick.state.copy()), keep(tick.state.copy())
    record.work = keep(np.zeros(max(1, tick.function.sz_w())))
    record.position = keep(mission.reference.position)
    watched = watched_columns(tick.signals)
    record.watched, record.n_watched = keep(watched, np.int64), len(watched)
    record.limits = (
        math.cos(min(limits.tilt, math.pi)) - _SLACK,
        limits.distance + _CLOSE,
        limits.height - _SLACK,
    )
    record.fresh, record.warned = 1, -1
    record.wall_qpos, record.wall_dof = plant.wall_joint or (-1, -1)
    record.wall = keep(np.stack(plant.surface.motion(times), axis=1))
    record.n_wrenches, record.wrenches = len(events.wrenches), flight.keep_structs(events.wrenches)
    if events.model is not None:
        places = bound_places(model, events.model)
        for numbers, columns in places:
            numbers[:] = events.model.values[0, columns]
        record.n_written, record.written = events.model.values.shape[1], keep(events.model.values)
        written = [
            Written(to.ctypes.data, to.size, columns.start, place.field.startswith("actuator_"))
            for (to, columns), place in zip(places, events.model.places, strict=True)
        ]
        record.n_places, record.places = len(written), flight.keep_structs(written)
    if plant.surface.friction_varies:
        _add_friction(flight, plant)
    return flight


def _add_friction(flight: Aloft, plant: Plant) -> None:
    record, keep, table = flight.record, flight.keep, friction_table(plant.surface)
    # The binding's address of the engine's own structure; nothing public tells it.
    record.model = flight.model._address
    record.pair, record.site = flight.model.pair(PAIR_NAME).id, flight.model.site(TIP_SITE).id
    record.friction_numbers = keep(table.numbers)
    record.frictions, record.adhesions = keep(table.frictions), keep(table.adhesions)
    record.stiffness = table.stiffness
