"""What acts on a simulated plant before a tick's physics: events, a moving surface, varying friction."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable

import mujoco
import numpy as np

from skylimb.flight.events import ModelRows, Timeline
from skylimb.simulation.plant import Plant
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.surfaces import PairFriction, Surface

Hook = Callable[[int], None]
"""Called before the physics of a tick, with its number."""


def with_own_model(plant: Plant) -> Plant:
    """The plant with a model that no other flight has, for what is written into it."""
    return dataclasses.replace(plant, model=copy.copy(plant.model))


def written_plant(plant: Plant, events: Timeline) -> Plant:
    """The plant itself, or one with a model of its own where a flight writes into the model."""
    writes = events.model is not None or plant.surface.friction_varies
    return with_own_model(plant) if writes else plant


def hooks(plant: Plant, data: mujoco.MjData, times: np.ndarray, events: Timeline) -> tuple[Hook, ...]:
    """All that acts on a flight's plant, in the order in which it acts.

    Args:
        plant: what flies (`written_plant`).
        data: its state.
        times: of every tick that the flight may have, s.
        events: what happens at each.
    """
    return (*writing(plant, events), *standing(plant, data, times), *pushing(plant, data, events))


def standing(plant: Plant, data: mujoco.MjData, times: np.ndarray) -> list[Hook]:
    """What the surface does by itself: it moves, and its friction varies."""
    found: list[Hook] = []
    if plant.wall_joint is not None:
        at, dof = plant.wall_joint
        motion = moving(plant.surface, times)

        def move_wall(k: int) -> None:
            data.qpos[at], data.qvel[dof] = motion(k)

        found.append(move_wall)
    if plant.surface.friction_varies:
        found.append(friction_writer(plant, data, times))
    return found


def moving(surface: Surface, times: np.ndarray) -> Callable[[int], tuple[float, float]]:
    """Displacement and velocity of a surface at any tick; of those behind `times` as many at once."""
    count, at, motion = len(times), 0, surface.motion(times)
    span = count * float(times[1] - times[0]) if count > 1 else 0.0

    def now(k: int) -> tuple[float, float]:
        nonlocal at, motion
        lap, row = divmod(k, count)
        if lap != at:
            at, motion = lap, surface.motion(times + lap * span)
        return motion[0][row], motion[1][row]

    return now


def bound_places(model: mujoco.MjModel, rows: ModelRows) -> list[tuple[np.ndarray, slice]]:
    """The engine's memory of every place that is written, and its columns in a row."""
    found = []
    for place in rows.places:
        part, _, what = place.field.partition("_")
        if what in ("pos", "quat", "ipos", "iquat"):
            # The engine takes a short cut for what stands as its body does.
            getattr(model, f"{part}_sameframe")[place.row] = 0
        numbers = getattr(model, place.field)[place.row : place.row + 1].reshape(-1)[: place.entries]
        found.append((numbers, slice(place.column, place.column + place.entries)))
    return found


def writing(plant: Plant, events: Timeline) -> list[Hook]:
    """What events write into the plant's model: a row where it is not what the row before was."""
    rows = events.model
    if rows is None:
        return []
    places, values = bound_places(plant.model, rows), rows.values
    new = np.concatenate([[True], np.any(values[1:] != values[:-1], axis=1)])
    begun = False

    def write(k: int) -> None:
        nonlocal begun
        if new[k] or not begun:
            for numbers, columns in places:
                numbers[:] = values[k, columns]
            begun = True

    return [write]


def friction_writer(plant: Plant, data: mujoco.MjData, times: np.ndarray) -> Hook:
    """Writes into the plant's model the friction of the place and the slip speed that the tip has."""
    model = plant.model
    friction = PairFriction(model, plant.surface)
    site = model.site(TIP_SITE).id
    position, velocity = data.site_xpos[site], np.zeros(6)
    motion = moving(plant.surface, times)

    def write(k: int) -> None:
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
        friction.update(position, velocity[3:], *map(float, motion(k)))

    return write


def pushing(plant: Plant, data: mujoco.MjData, events: Timeline) -> list[Hook]:
    """What pushes the robot: all wrenches are added to the joint forces before the steps of a tick."""
    wrenches, model = events.wrenches, plant.model
    if not wrenches:
        return []
    numbers = [(w.begin, w.end, w.body, *map(np.array, (w.force, w.torque))) for w in wrenches]
    points = [tuple(wrench.point) for wrench in wrenches]

    def push(k: int) -> None:
        moved = False
        for (begin, end, body, force, torque), point in zip(numbers, points, strict=True):
            if not begin <= k < end:
                continue
            if not moved:
                # Positions of the step before last are at hand; the wrench must act where the robot is now.
                mujoco.mj_kinematics(model, data)
                mujoco.mj_comPos(model, data)
                moved = True
            x, R = data.xpos[body], data.xmat[body]
            # Term by term, as in C: a matrix product may round otherwise.
            at = np.array(
                [
                    x[i] + (R[3 * i] * point[0] + R[3 * i + 1] * point[1] + R[3 * i + 2] * point[2])
                    for i in range(3)
                ]
            )
            mujoco.mj_applyFT(model, data, force, torque, at, body, data.qfrc_applied)

    return [push]
