"""What a simulated flight's raw record says: its signals, and the truth that follows from its states."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.control.loop.flight import Flight, mission_signals
from skylimb.control.missions.mission import Mission
from skylimb.simulation.clearance import Clearance, least_clearance
from skylimb.simulation.plant import Plant
from skylimb.simulation.surface_at import SurfaceAt, changed_surface, turned_valve
from skylimb.simulation.surfaces import Valve
from skylimb.simulation.tool_truth import tool_signals
from skylimb.simulation.truth import contact_truth, flight_kinematics


class FlightTruth(NamedTuple):
    """What follows from a flight's raw record.

    Attributes:
        signals: by name, the ticks first.
        gaps: start and duration, s, of every time without touch.
        clearance: of all but the tool from the surface.
    """

    signals: dict[str, np.ndarray]
    gaps: list[list[float]]
    clearance: Clearance


def flight_truth(
    plant: Plant, flight: Flight, mission: Mission, surface: np.ndarray | None = None
) -> FlightTruth:
    """Recorded signals, and the truth that follows from the physics' state.

    Args:
        plant: what flew.
        flight: the raw record.
        mission: what was asked, as the flight went through it (`flown_mission`).
        surface: what the surface was at every tick (`surface_table`); None where it did not change.
    """
    ticks = flight.ticks
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
    computed = {
        **mission_signals(mission, ticks),
        "root_position": qpos[:, 0:3],
        "root_quaternion": qpos[:, 3:7],
        "joint_angles": qpos[:, list(plant.joint_qpos)],
        "vectoring_angles": qpos[:, list(plant.vectoring_qpos)],
        **moved._asdict(),
        **contact,
        **changed,
        **tool_signals(plant, flight, moved.tip_position),
    }
    clearance = least_clearance(plant, qpos, mission.times[:ticks], touched)
    return FlightTruth(values | computed, gaps, clearance)


def _surface_signals(moved: SurfaceAt, table: np.ndarray) -> dict[str, np.ndarray]:
    """Where the surface was and what it was made of, at every tick."""
    return {
        "surface_position": moved.position,
        "surface_quaternion": moved.quaternion,
        "surface_friction": table[:, 6],
        "surface_stiffness": table[:, 7],
        "surface_present": table[:, 8],
    }
