"""A flight as a dataset: every signal under its name, with units, frame and whether it is truth or belief."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from skylimb.control.contact_machine import REASONS, STATES
from skylimb.errors import ConfigError
from skylimb.loop.flight import Flight, flown_mission
from skylimb.missions.mission import PHASES, Mission
from skylimb.signals import Signal, require_recorded
from skylimb.simulation.plant import Plant
from skylimb.simulation.signals import SIGNALS, SignalInfo
from skylimb.simulation.surface_at import SurfaceAt, changed_surface, turned_valve
from skylimb.simulation.surfaces import Valve
from skylimb.simulation.tool_truth import tool_signals
from skylimb.simulation.truth import contact_truth, flight_kinematics

CONTACT_STATE, CONTACT_REASON = "contact_state", "contact_reason"
"""Signals of a controller whose contact law is a state machine."""

_FLAGS = {"phase": PHASES, CONTACT_STATE: STATES, CONTACT_REASON: REASONS}
"""Variables that count names."""


def flight_log(
    plant: Plant,
    flight: Flight,
    mission: Mission,
    own: Mapping[str, Signal] | None = None,
    surface: np.ndarray | None = None,
) -> xr.Dataset:
    """Assemble the log: recorded signals, the reference, and the truth that follows from the physics' state.

    Every reference is the mission's, at the time on the mission's clock that the flight had reached. What a
    controller made of it is a signal of the controller's own, such as `cog_position_target`.

    Args:
        plant: what flew.
        flight: the raw record.
        mission: what was asked.
        own: what the controller declares of its own signals.
        surface: what the surface was at every tick (`surface_table`); None where it did not change.

    Raises:
        ConfigError: when a user's controller names a signal that the loop records itself, or declares one
            that it does not record.
    """
    own = own or {}
    require_recorded(own, flight.layout.slices, "the controller")
    mission = flown_mission(mission, flight)
    ticks, reference = flight.ticks, mission.reference
    moved = flight_kinematics(plant, flight, mission)
    qpos = flight.signal("configuration")
    values: dict[str, np.ndarray] = {
        name: flight.signal(name) for name in flight.layout.slices if name != "configuration_velocity"
    }
    touched, changed = plant.surface, {}
    if surface is not None:
        touched = changed_surface(plant.surface, surface[:ticks], mission.period)
        changed = _surface_signals(touched, surface[:ticks])
    if plant.hinge is not None and isinstance(plant.surface, Valve):
        at, rate = plant.hinge
        velocity = flight.signal("configuration_velocity")
        touched = turned_valve(
            plant.surface, qpos[:, at], velocity[:, rate], moved.tip_position, mission.period
        )
        changed = {"valve_angle": qpos[:, at]}
    contact, gaps = contact_truth(plant, flight, mission, moved, touched)
    tools = tool_signals(plant, flight, moved.tip_position)
    computed = {
        "cog_position_reference": reference.position[:ticks],
        "cog_velocity_reference": reference.velocity[:ticks],
        "cog_acceleration_reference": reference.acceleration[:ticks],
        "reach_reference": reference.reach[:ticks],
        "tip_position_reference": reference.tip_position[:ticks],
        "phase": mission.phase[:ticks].astype(np.int8),
        "root_position": qpos[:, 0:3],
        "root_quaternion": qpos[:, 3:7],
        "joint_angles": qpos[:, list(plant.joint_qpos)],
        "vectoring_angles": qpos[:, list(plant.vectoring_qpos)],
        **moved._asdict(),
        **contact,
        **changed,
        **tools,
    }
    for name in (CONTACT_STATE, CONTACT_REASON):
        if name in values:
            # Of a flight that diverged the last one may be no number.
            values[name] = np.where(np.isfinite(values[name]), values[name], -1.0).astype(np.int8)
    clash = sorted(values.keys() & computed.keys())
    if clash:
        raise ConfigError(
            f"controller signal '{clash[0]}' is a name that the loop records itself; choose another"
        )
    values |= computed
    attributes = {"contact_gaps": json.dumps([[gap.start, gap.duration] for gap in gaps])}
    if CONTACT_STATE in values and CONTACT_REASON in values:
        attributes["contact_transitions"] = json.dumps(
            contact_transitions(mission.times[:ticks], values[CONTACT_STATE], values[CONTACT_REASON])
        )
    return xr.Dataset(
        {name: log_variable(name, array, own.get(name, Signal())) for name, array in values.items()},
        coords=_coordinates(plant, mission.times[:ticks], values),
        attrs=attributes,
    )


def _surface_signals(moved: SurfaceAt, table: np.ndarray) -> dict[str, np.ndarray]:
    """Where the surface was and what it was made of, at every tick."""
    return {
        "surface_position": moved.position,
        "surface_quaternion": moved.quaternion,
        "surface_friction": table[:, 6],
        "surface_stiffness": table[:, 7],
        "surface_present": table[:, 8],
    }


def contact_transitions(
    times: np.ndarray, state: np.ndarray, reason: np.ndarray
) -> list[tuple[float, str, str, str]]:
    """Every change of the contact's state: when (s), from which state, to which, and why, in words.

    Args:
        times: of the ticks, (k,).
        state: index of `STATES` at every tick, (k,).
        reason: index of `REASONS` of the last change, (k,).
    """
    changed = np.flatnonzero(np.diff(state)) + 1
    return [
        (
            round(float(times[k]), 6),
            _word(STATES, state[k - 1]),
            _word(STATES, state[k]),
            _word(REASONS, reason[k]),
        )
        for k in changed
    ]


def _word(names: tuple[str, ...], index: float) -> str:
    """The name of that number; the number itself where a user's own law counts otherwise."""
    return names[int(index)] if 0.0 <= index < len(names) else f"{index:g}"


def log_variable(name: str, array: np.ndarray, own: Signal) -> xr.Variable:
    """A signal as a variable of the log, with dimensions, unit, frame and meaning.

    Args:
        name: of the signal.
        array: its values, the ticks first.
        own: what its author declares; a signal that everybody knows needs nothing.
    """
    info = SIGNALS.get(name, SignalInfo(_plain_dims(array, name), own.unit, own.frame, own.meaning, own.kind))
    attrs: dict[str, Any] = {
        "units": info.units,
        "frame": info.frame,
        "long_name": info.long_name,
        "kind": info.kind,
    }
    if name in _FLAGS:
        names = [word.replace(" ", "_") for word in _FLAGS[name]]
        attrs |= {"flag_values": np.arange(len(names), dtype=np.int8), "flag_meanings": " ".join(names)}
    return xr.Variable(("time", *info.dims), array.reshape(len(array), *array.shape[1:]), attrs)


def _plain_dims(array: np.ndarray, name: str) -> tuple[str, ...]:
    if array.ndim == 1:
        return ()
    return ("axis",) if array.shape[1:] == (3,) else tuple(f"{name}_{i}" for i in range(array.ndim - 1))


def _coordinates(plant: Plant, times: np.ndarray, values: dict[str, np.ndarray]) -> dict[str, Any]:
    description = plant.robot.description
    return {
        "time": ("time", times, {"units": "s", "long_name": "time"}),
        "axis": ["x", "y", "z"],
        "quaternion": ["w", "x", "y", "z"],
        "unrolled": ["u", "v"],
        "rotor": [rotor.name for rotor in description.rotors],
        "joint": list(description.shape_joints),
        "vectoring": list(description.vectoring_joints),
    }
