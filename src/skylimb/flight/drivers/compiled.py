"""The driver for a compiled tick: evaluated straight on the engine's own memory, with nothing allocated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.flight.drivers.hooks import Hook
from skylimb.flight.drivers.python_time import PythonTime, python_time
from skylimb.flight.events import GainRows
from skylimb.simulation.engine_warnings import raised_warnings
from skylimb.simulation.plant import Plant
from skylimb.simulation.rows import FlightRows
from skylimb.simulation.tick import CompiledTick
from skylimb.simulation.vehicle import Advance

ASKED_AGAIN = 51
"""Ticks after which a law in Python is asked once more; an odd number, so that both evaluations are."""


class Saved(NamedTuple):
    """A moment of a flight between two ticks.

    Attributes:
        data: the plant's state.
        states: of sensors, controller and mission clock, of both buffers.
        at: the row of the mission that comes next.
    """

    data: mujoco.MjData
    states: tuple[np.ndarray, np.ndarray]
    at: int


class CompiledDriver:
    """Evaluate the tick, then advance the physics by a control period. It applies events of every kind.

    Args:
        tick: sensors, controller, actuators and record as one function.
        plant: what flies.
        data: its state; it is advanced.
        rows: what is known of the flight beforehand.
        hooks: what acts on the plant before a tick's physics.
        gains: those that change in flight.
        start: the mission's tick of the first row of `rows.references`; above 0 for a flight that goes on
            from its middle.
        advance: advances the physics.

    Attributes:
        tick: flies one tick; gives the whole tick of the mission that comes next.
        layout: where each signal stands in a row of the log.
        log: one row of signals a tick; NaN where nothing has been flown yet.
        gains: of the controller, flat.
    """

    def __init__(
        self,
        tick: CompiledTick,
        plant: Plant,
        data: mujoco.MjData,
        rows: FlightRows,
        hooks: Sequence[Hook] = (),
        gains: GainRows | None = None,
        start: int = 0,
        advance: Advance = mujoco.mj_step,
    ) -> None:
        self.layout, self._model, self._data = tick.signals, plant.model, data
        self.log = np.full((len(rows), tick.signals.size), np.nan)
        # State and next state change places at every tick, so that nothing is copied.
        self._states = (tick.state.copy(), tick.state.copy())
        self.gains = tick.gains.copy()
        # Of laws in Python: how long they took, and which of them gave another result, when and by how much.
        self._took = np.full(len(rows) if tick.calls else 0, np.nan)
        self._odd: dict[str, tuple[int, float]] = {}
        self._period = plant.substeps * plant.model.opt.timestep
        # The row of the mission that comes next: as an array, so that a saved one can be put back.
        self._at = np.zeros(1, dtype=int)
        self.tick = self._bound_tick(tick, plant, rows, tuple(hooks), gains, start, advance)

    def state(self, k: int) -> np.ndarray:
        """The flat state before tick `k`, the next one to be flown; overwritten two ticks later."""
        return self._states[k & 1]

    @property
    def python_time(self) -> PythonTime | None:
        """How long laws in Python take in a tick; None where the whole tick is compiled."""
        return python_time(self._took[np.isfinite(self._took)], self._period)

    def notes(self) -> tuple[str, ...]:
        """Which laws in Python do not give the same for the same arguments, and whether they are too slow."""
        odd = (
            f"this run cannot be repeated: {what} gives another result for the same arguments at "
            f"t = {k * self._period:.3f} s (by {gap:.3g}); what it remembers belongs into its state, and it "
            "draws no random numbers"
            for what, (k, gap) in self._odd.items()
        )
        time = self.python_time
        return *odd, *(time.notes("what flies in Python") if time else ())

    def fault(self) -> str:
        """What the physics engine has warned of."""
        return raised_warnings(self._data.warning.number.tolist())

    def saved(self) -> Saved:
        """All that the next tick depends on, to be put back by `put_back`; the log is not among it."""
        data = mujoco.MjData(self._model)
        mujoco.mj_copyData(data, self._model, self._data)
        return Saved(data, (self._states[0].copy(), self._states[1].copy()), int(self._at[0]))

    def put_back(self, saved: Saved) -> None:
        """Go on from what was saved; rows of the log after it are flown again."""
        mujoco.mj_copyData(self._data, self._model, saved.data)
        for state, before in zip(self._states, saved.states, strict=True):
            state[:] = before
        self._at[0] = saved.at

    def _bound_tick(
        self,
        tick: CompiledTick,
        plant: Plant,
        rows: FlightRows,
        hooks: tuple[Hook, ...],
        changing: GainRows | None,
        start: int,
        advance: Advance,
    ) -> Callable[[int], int]:
        """One tick as a function whose every name is local: the fastest that Python has."""
        data, gains, states, log, next_row = self._data, self.gains, self._states, self.log, self._at
        model, substeps = plant.model, plant.substeps
        row, signals = np.zeros(tick.rows.size), np.zeros(tick.signals.size)
        window = tick.window.rows
        reference = np.zeros((window, rows.references.shape[1]))
        # One evaluation for even ticks and one for odd ones.
        plant_now = data.qpos, data.qvel, data.act, data.history
        bound = self._bound = [
            BoundFunction(
                tick.function,
                (states[i], *plant_now, row, reference, gains, tick.rotors),
                (states[1 - i], data.ctrl, signals, data.qfrc_applied),
                tick.calls,
            )
            for i in (0, 1)
        ]
        evaluations = [one.evaluate for one in bound]
        took, in_python = self._took, bool(tick.calls)
        known, references, clock = rows.ticks, rows.references, tick.clock

        def fly(k: int, keep_alive: Any = bound) -> int:
            at = int(next_row[0])
            row[:] = known[k]
            reference[:] = references[at : at + window]
            if changing is not None:
                gains[changing.columns] = changing.values[k]
            odd = k & 1
            evaluations[odd]()
            if in_python:
                took[k] = bound[odd].spent
                if not k % ASKED_AGAIN:
                    self._ask_again(k)
            log[k] = signals
            for hook in hooks:
                hook(k)
            advance(model, data, substeps)
            at = k + 1 if clock is None else int(states[1 - odd][clock]) - start
            next_row[0] = at
            return at + start

        return fly

    def _ask_again(self, k: int) -> None:
        """Note which laws in Python do not give again what they have just given at tick `k`."""
        for what, gap in self._bound[k & 1].asked_again():
            self._odd.setdefault(what, (k, gap))
