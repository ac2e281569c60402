"""The loop around a compiled tick, evaluated straight on MuJoCo's own memory with nothing allocated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

from skylimb.packing import Layout, pack_rows
from skylimb.simulation.clock import without_clock
from skylimb.simulation.disturbance import DisturbanceConfig, pusher
from skylimb.simulation.flight import CHECK_INTERVAL, Flight, engine_loss, find_loss
from skylimb.simulation.mission import Mission
from skylimb.simulation.plant import Plant
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.sensors import SensorConfig, draw_noise, frame_ages
from skylimb.simulation.surfaces import PairFriction
from skylimb.simulation.tick import CompiledTick, TickRow, row_layout

Progress = Callable[[int, int], None]
"""Called now and then with (ticks flown, ticks in all)."""


def mission_rows(plant: Plant, mission: Mission, sensors: SensorConfig, seed: int) -> np.ndarray:
    """One packed `TickRow` a tick: reference, age of the frame, noise drawn from `seed`."""
    layout, count = row_layout(plant), len(mission.times)
    description = plant.robot.description
    rng = np.random.default_rng(seed)
    noise = draw_noise(
        sensors, mission.times, len(description.shape_joints), len(description.vectoring_joints), rng
    )
    record = TickRow(mission.reference, frame_ages(sensors, mission.times), noise)
    return pack_rows(layout, record, count)


@without_clock()
def fly_compiled(
    tick: CompiledTick,
    plant: Plant,
    data: mujoco.MjData,
    mission: Mission,
    rows: np.ndarray,
    outside: Sequence[Callable[[int], None]] = (),
    progress: Progress | None = None,
) -> Flight:
    """Fly a compiled tick from `data` to the end of the mission or the loss of the flight."""
    step, model, substeps = mujoco.mj_step, plant.model, plant.substeps
    count = len(rows)
    log = np.full((count, tick.signals.size), np.nan)
    row, signals = np.zeros(tick.rows.size), np.zeros(tick.signals.size)
    states = (tick.state.copy(), tick.state.copy())
    # State and next state change places at every tick, so two evaluations are bound and nothing is copied.
    (_even, evaluate), (_odd, evaluate_next) = (
        _bind(tick, data, states[i], states[1 - i], row, signals) for i in (0, 1)
    )
    for start in range(0, count, CHECK_INTERVAL):
        end = min(start + CHECK_INTERVAL, count)
        for k in range(start, end):
            row[:] = rows[k]
            evaluate()
            evaluate, evaluate_next = evaluate_next, evaluate
            log[k] = signals
            for act in outside:
                act(k)
            step(model, data, substeps)
        lost = lost_flight(log, tick.signals, mission, start, end, data)
        if progress is not None:
            progress(end, count)
        if lost is not None:
            return Flight(log, tick.signals, lost[0] + 1, lost[1])
    return Flight(log, tick.signals, count, "")


def _bind(
    tick: CompiledTick,
    data: mujoco.MjData,
    state: np.ndarray,
    next_state: np.ndarray,
    row: np.ndarray,
    signals: np.ndarray,
) -> tuple[Any, Callable[[], None]]:
    """An evaluation on these arrays' own memory, and the buffer that must be kept alive with it."""
    buffer, evaluate = tick.function.buffer()
    arguments: tuple[Any, ...] = (state, data.qpos, data.qvel, data.act, data.history, row, tick.gains)
    results: tuple[Any, ...] = (next_state, data.ctrl, signals)
    for index, array in enumerate(arguments):
        buffer.set_arg(index, memoryview(array))  # pyright: ignore[reportCallIssue]
    for index, array in enumerate(results):
        buffer.set_res(index, memoryview(array))  # pyright: ignore[reportCallIssue]
    return buffer, evaluate


def interventions(
    plant: Plant, data: mujoco.MjData, mission: Mission, disturbance: DisturbanceConfig
) -> list[Callable[[int], None]]:
    """What acts on the plant from outside before a tick's steps: a moving surface, a push, or nothing."""
    found: list[Callable[[int], None]] = []
    if plant.wall_joint is not None:
        position, velocity = plant.surface.motion(mission.times)
        at, dof = plant.wall_joint

        def move_wall(k: int) -> None:
            data.qpos[at], data.qvel[dof] = position[k], velocity[k]

        found.append(move_wall)
    if plant.surface.friction_varies:
        found.append(friction_writer(plant, data, mission, plant.model))
    push = pusher(disturbance, plant.model, data, plant.robot.description.root, mission.times)
    if push is not None:
        found.append(push)
    return found


def friction_writer(
    plant: Plant, data: mujoco.MjData, mission: Mission, model: mujoco.MjModel
) -> Callable[[int], None]:
    """Writes into `model` the friction of the place and the slip speed that the tip has at a tick."""
    friction = PairFriction(model, plant.surface)
    site = model.site(TIP_SITE).id
    position, velocity = data.site_xpos[site], np.zeros(6)
    displacement, wall_speed = plant.surface.motion(mission.times)

    def write(k: int) -> None:
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
        friction.update(position, velocity[3:], float(displacement[k]), float(wall_speed[k]))

    return write


def lost_flight(
    log: np.ndarray, layout: Layout[Any], mission: Mission, start: int, end: int, data: mujoco.MjData
) -> tuple[int, str] | None:
    """`find_loss`, and the engine's own warnings."""
    found = find_loss(log, layout, mission, start, end)
    return found or engine_loss(mission, end, data.warning.number.tolist())
