"""The loop around a compiled tick, evaluated straight on MuJoCo's own memory with nothing allocated."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from skylimb.packing import pack_rows
from skylimb.simulation.clock import without_clock
from skylimb.simulation.disturbance import DisturbanceConfig, pusher
from skylimb.simulation.flight import (
    CHECK_INTERVAL,
    Flight,
    engine_loss,
    find_loss,
    unfinished,
)
from skylimb.simulation.gain_changes import GainChange, GainRows, gain_rows
from skylimb.simulation.mission import Mission
from skylimb.simulation.plant import Plant
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.sensors import SensorConfig, draw_noise, frame_ages
from skylimb.simulation.surfaces import PairFriction
from skylimb.simulation.tick import CompiledTick, TickRow, reference_layout, row_layout

Progress = Callable[[int, int], None]
"""Called now and then with (ticks flown, ticks in all)."""


@dataclass(frozen=True)
class FlightRows:
    """What is known of a flight before it begins.

    Attributes:
        ticks: one packed `TickRow` for every tick that the flight may have.
        references: one packed `Reference` for every tick of the mission, and the last one once more.
        gains: those that change in flight, if any do.
    """

    ticks: np.ndarray
    references: np.ndarray
    gains: GainRows | None = None

    def __len__(self) -> int:
        return len(self.ticks)

    def until(self, count: int) -> FlightRows:
        """The first `count` ticks of a flight that goes with the mission's clock."""
        gains = self.gains.until(count) if self.gains is not None else None
        return FlightRows(self.ticks[:count], self.references[: count + 1], gains)

    def with_changes(self, changes: Sequence[GainChange], tick: CompiledTick, dt: float) -> FlightRows:
        """The rows of a flight in which some gains of a tick of `dt` seconds change."""
        times = np.arange(len(self)) * dt
        return dataclasses.replace(self, gains=gain_rows(changes, tick.gains, tick.gains_layout, times))

    @property
    def last(self) -> int:
        """The mission's last tick."""
        return len(self.references) - 2


def mission_rows(
    plant: Plant, mission: Mission, sensors: SensorConfig, seed: int, paced: bool = False
) -> FlightRows:
    """Ages of the frames, noise drawn from `seed`, and references.

    Args:
        plant: what is flown.
        mission: what is asked.
        sensors: rate, latency and noise.
        seed: of the noise.
        paced: whether the controller sets the pace of the mission, so that the flight may take longer.
    """
    description, times = plant.robot.description, mission.flight_times(paced)
    rng = np.random.default_rng(seed)
    noise = draw_noise(sensors, times, len(description.shape_joints), len(description.vectoring_joints), rng)
    ticks = pack_rows(row_layout(plant), TickRow(frame_ages(sensors, times), noise), len(times))
    references = pack_rows(reference_layout(plant), mission.reference, len(mission.times))
    return FlightRows(ticks, np.vstack([references, references[-1:]]))


@without_clock()
def fly_compiled(
    tick: CompiledTick,
    plant: Plant,
    data: mujoco.MjData,
    mission: Mission,
    rows: FlightRows,
    outside: Sequence[Callable[[int], None]] = (),
    progress: Progress | None = None,
) -> Flight:
    """Fly a compiled tick from `data` to the end of the mission or the loss of the flight."""
    step, model, substeps = mujoco.mj_step, plant.model, plant.substeps
    count = len(rows)
    log = np.full((count, tick.signals.size), np.nan)
    row, signals = np.zeros(tick.rows.size), np.zeros(tick.signals.size)
    window = 1 if tick.clock is None else 2
    reference = np.zeros((window, rows.references.shape[1]))
    states = (tick.state.copy(), tick.state.copy())
    gains, changing = tick.gains.copy(), rows.gains
    # State and next state change places at every tick, so two evaluations are bound and nothing is copied.
    (_even, evaluate), (_odd, evaluate_next) = (
        _bind(tick, data, states[i], states[1 - i], row, reference, gains, signals) for i in (0, 1)
    )
    known, references, last, clock = rows.ticks, rows.references, rows.last, tick.clock
    at = 0
    for start in range(0, count, CHECK_INTERVAL):
        end = min(start + CHECK_INTERVAL, count)
        for k in range(start, end):
            row[:] = known[k]
            reference[:] = references[at : at + window]
            if changing is not None:
                gains[changing.columns] = changing.values[k]
            evaluate()
            evaluate, evaluate_next = evaluate_next, evaluate
            log[k] = signals
            for act in outside:
                act(k)
            step(model, data, substeps)
            at = k + 1 if clock is None else int(states[(k + 1) % 2][clock])
            if at > last:
                end = k + 1
                break
        flown = Flight(log, tick.signals, end, "")
        lost = lost_flight(flown, mission, start, data)
        if progress is not None:
            progress(at, last + 1)
        if lost is not None:
            return Flight(log, tick.signals, lost[0] + 1, lost[1])
        if at > last:
            return flown
    return unfinished(mission, Flight(log, tick.signals, count, ""))


def _bind(
    tick: CompiledTick,
    data: mujoco.MjData,
    state: np.ndarray,
    next_state: np.ndarray,
    row: np.ndarray,
    reference: np.ndarray,
    gains: np.ndarray,
    signals: np.ndarray,
) -> tuple[Any, Callable[[], None]]:
    """An evaluation on these arrays' own memory, and the buffer that must be kept alive with it."""
    buffer, evaluate = tick.function.buffer()
    given: tuple[Any, ...] = (state, data.qpos, data.qvel, data.act, data.history, row, reference, gains)
    results: tuple[Any, ...] = (next_state, data.ctrl, signals)
    for index, array in enumerate(given):
        buffer.set_arg(index, memoryview(array))  # pyright: ignore[reportCallIssue]
    for index, array in enumerate(results):
        buffer.set_res(index, memoryview(array))  # pyright: ignore[reportCallIssue]
    return buffer, evaluate


def interventions(
    plant: Plant, data: mujoco.MjData, times: np.ndarray, disturbance: DisturbanceConfig
) -> list[Callable[[int], None]]:
    """What acts on the plant from outside before a tick's steps: a moving surface, a push, or nothing.

    Args:
        plant: what is flown.
        data: its state.
        times: of every tick that the flight may have, s.
        disturbance: the push.
    """
    found: list[Callable[[int], None]] = []
    if plant.wall_joint is not None:
        position, velocity = plant.surface.motion(times)
        at, dof = plant.wall_joint

        def move_wall(k: int) -> None:
            data.qpos[at], data.qvel[dof] = position[k], velocity[k]

        found.append(move_wall)
    if plant.surface.friction_varies:
        found.append(friction_writer(plant, data, times, plant.model))
    push = pusher(disturbance, plant.model, data, plant.robot.description.root, times)
    if push is not None:
        found.append(push)
    return found


def friction_writer(
    plant: Plant, data: mujoco.MjData, times: np.ndarray, model: mujoco.MjModel
) -> Callable[[int], None]:
    """Writes into `model` the friction of the place and the slip speed that the tip has at a tick."""
    friction = PairFriction(model, plant.surface)
    site = model.site(TIP_SITE).id
    position, velocity = data.site_xpos[site], np.zeros(6)
    displacement, wall_speed = plant.surface.motion(times)

    def write(k: int) -> None:
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
        friction.update(position, velocity[3:], float(displacement[k]), float(wall_speed[k]))

    return write


def lost_flight(flight: Flight, mission: Mission, start: int, data: mujoco.MjData) -> tuple[int, str] | None:
    """`find_loss` from tick `start` on, and the engine's own warnings."""
    found = find_loss(flight, mission, start)
    return found or engine_loss(mission, flight.ticks, data.warning.number.tolist())
