"""The record of a flight that its user steers: one row a tick, its whole reference in it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from skylimb.config import put, to_mapping
from skylimb.control.controller import Controller, controller_signals, resolved_tables
from skylimb.flights.record import config_units
from skylimb.flights.replay.whole_reference import REFERENCE_SIGNALS, reference_signals
from skylimb.flights.sources import kept_sources
from skylimb.flights.takeoff import Takeoff
from skylimb.loop.flight import MISSION_TIME, Flight
from skylimb.missions.reference import Reference
from skylimb.packing import Layout
from skylimb.recording.origin import origin_text
from skylimb.recording.run import Run
from skylimb.recording.versions import origin_versions, versions
from skylimb.robots.model import Robot
from skylimb.signals import Signal
from skylimb.simulation.log import log_variable

STATE = "flight_state"
_MORE = {
    STATE: Signal("", "", "flight state, as on the lab's topic", "estimate"),
    MISSION_TIME: Signal(
        "s", "", "where the flight is on its mission's clock; 0 without a mission", "reference"
    ),
}
_CHUNK = 512
"""Rows by which a record grows: what is there already is not copied in flight."""


class FlightRecord:
    """Rows of a flight, from the controller's first tick on.

    Args:
        vehicle: layout of what the vehicle records.
        own: the controller's own signals at that tick.
        reference: of that tick.
        paced: whether the controller sets the pace of missions.
    """

    def __init__(
        self, vehicle: Layout[dict[str, Any]], own: Mapping[str, Any], reference: Reference, paced: bool
    ) -> None:
        zeros = {name: np.zeros(shape) if shape else 0.0 for name, shape in vehicle.shapes.items()}
        mine = {name: np.asarray(value, dtype=float) for name, value in own.items()}
        self._paced, self._own = paced, tuple(mine)
        flown = {**zeros, **mine, **({MISSION_TIME: 0.0} if paced else {})}
        self.flown = Layout(flown)
        self.layout = Layout({**flown, STATE: 0.0, **reference_signals(reference)})
        self._chunks, self.ticks = list[np.ndarray](), 0

    def add(
        self,
        vehicle: np.ndarray,
        own: Mapping[str, Any],
        mission_time: float,
        state: int,
        reference: Reference,
    ) -> np.ndarray:
        """One more row; it stays valid until the next one."""
        if self.ticks == len(self._chunks) * _CHUNK:
            self._chunks.append(np.empty((_CHUNK, self.layout.size)))
        row = self._chunks[-1][self.ticks % _CHUNK]
        parts = [vehicle, *(np.ravel(np.asarray(own[name], dtype=float)) for name in self._own)]
        clock = (mission_time,) if self._paced else ()
        values = [np.ravel(value) for value in reference_signals(reference).values()]
        row[:] = np.concatenate([*parts, clock, (float(state),), *values])
        self.ticks += 1
        return row

    def _all(self) -> np.ndarray:
        """Every row so far, (ticks, width)."""
        return np.concatenate([np.empty((0, self.layout.size)), *self._chunks])[: self.ticks]

    def flight(self, first: int, last: int, cause: str = "") -> Flight:
        """Some ticks as the flight of their mission, without the signals that no mission needs."""
        rows = self._all()[first:last, : self.flown.size]
        return Flight(rows, self.flown, last - first, cause)

    def log(self, robot: Robot, controller: Controller, period: float, rows: int | None = None) -> xr.Dataset:
        """The signals with their units; `rows` of them, by default all."""
        count = self.ticks if rows is None else rows
        declared = {**controller_signals(controller), **_MORE, **REFERENCE_SIGNALS}
        values, whole = {}, self._all()
        for name, part in self.layout.slices.items():
            array = whole[:count, part]
            shape = self.layout.shapes[name]
            values[name] = log_variable(name, array.reshape(count, *shape), declared.get(name, Signal()))
        description = robot.description
        return xr.Dataset(
            values,
            {
                "time": ("time", np.arange(count) * period, {"units": "s", "long_name": "time"}),
                "axis": ["x", "y", "z"],
                "quaternion": ["w", "x", "y", "z"],
                "rotor": [rotor.name for rotor in description.rotors],
                "joint": list(description.shape_joints),
                "vectoring": list(description.vectoring_joints),
            },
        )


def run_of(log: xr.Dataset, takeoff: Takeoff) -> Run:
    """A log with all that produced it, as a run without scores.

    Args:
        log: of a flight.
        takeoff: with which it was flown.
    """
    experiment, controller, kept = takeoff.experiment, takeoff.controller, kept_sources(takeoff)
    config = to_mapping({**experiment.to_mapping(), "controller": resolved_tables(controller)})
    config.pop("recorded", None)
    for key, place in kept.places.items():
        put(config, key, place)
    log = log.assign_attrs(
        robot=takeoff.robot.name,
        experiment=experiment.name,
        controller=controller.name,
        status="OK",
        cause="",
        contact_axis=[float(entry) for entry in experiment.contact_axis],
        config=origin_text(config, kept.files, origin_versions(), kept.problems),
        config_units=json.dumps(config_units(experiment, controller)),
        versions=json.dumps(versions()),
    )
    return Run(name=controller.name, controller=controller.name, log=log, sources=kept.files)
