"""A controller under its supervisor, as one traced step: for the compiled tick and for exported C."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, NamedTuple

import numpy as np

from skylimb.base.packing import Layout
from skylimb.base.split_function import Asked
from skylimb.control.controller import TraceableController
from skylimb.control.estimation.gates import BEYOND
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.clock import limited_pace
from skylimb.control.missions.reference import Reference
from skylimb.control.needs import PACE
from skylimb.control.records import Command
from skylimb.control.supervisor.descents import descents_of
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Watch, initial_watch
from skylimb.control.supervisor.suited_gains import suited_gains
from skylimb.control.supervisor.supervisor import after, before
from skylimb.control.supervisor.table import RETREAT, TABLE
from skylimb.symbolic import Array, dot, where, within

MODE, BITS = "supervisor_mode", "supervisor_bits"
SHARES, LATENESS, SLOWNESS = "rotor_shares_estimate", "lateness_estimate", "rotor_slowness_estimate"
"""Signals: the mode's number, the bits of the table as one whole number, the first one lowest; what is left
of each rotor, and how much later than assumed measurements are."""


def word_of(bits: Any) -> Any:
    """The bits of the table, in its order, as one whole number."""
    return dot(bits, [float(1 << place) for place in range(bits.shape[0])])


def bit_of(words: Array, name: str) -> Array:
    """Whether a bit of the table is set in such numbers: 0 or 1 each."""
    return np.asarray(words).astype(int) >> list(TABLE.bits).index(name) & 1


class State(NamedTuple):
    """State of the controller, what the supervisor remembers, and the pace of the mission."""

    own: Any
    watch: Watch
    pace: Any = 1.0


class Supervised:
    """Follows `TraceableController` around another one.

    Args:
        controller: what flies.
        limits: when the supervisor acts.
    """

    def __init__(self, controller: TraceableController, limits: Limits) -> None:
        self._controller, self._limits = controller, limits
        self._descents = descents_of(controller.robot, controller.needs.vectoring, limits)
        self.name, self.robot, self.needs = controller.name, controller.robot, controller.needs
        self.gains, self.key_tables = controller.gains, controller.key_tables

    def require(self, dt: float) -> None:
        """Raise a `ConfigError` where controller or supervisor cannot work at a control period of `dt` s."""
        self._controller.require(dt)
        self._limits.require(dt)

    def initial_state(self) -> State:
        """The controller's own, and a supervisor that knows nothing yet."""
        return State(self._controller.initial_state(), initial_watch(self.robot, self.needs.imu))

    def structure(self) -> Hashable:
        """Everything that ends up in the traced function rather than in its arguments."""
        return type(self), self._limits, self._controller.structure()

    def opened(self) -> tuple[Supervised, list[Asked]]:
        """The same to be traced; see `Cascade.opened`."""
        controller, asked = self._controller.opened()
        return Supervised(controller, self._limits), asked

    def flagged(self, state: State, late: Any, pose: Any) -> State:
        """The state of a supervisor that knows whether this tick comes too late, and the pose is new."""
        watch = state.watch
        return state._replace(watch=watch._replace(flags=watch.flags._replace(late=late, pose=pose)))

    def step(
        self, gains: Any, state: State, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[State, Command, dict[str, Any]]:
        """One tick: look, let the controller fly or not, and keep to the limits."""
        watch, sight = before(
            self.robot, self._limits, self._descents, state.watch, measurement, reference, dt
        )
        named = Layout(gains)
        known = watch.late.late, watch.late.slow, watch.clocks.back
        gains = named.unpack(suited_gains(named, named.pack(gains), *known))
        new, wanted, signals = self._controller.step(gains, state.own, sight.measurement, sight.reference, dt)
        layout = Layout(state.own)
        made_state, old_state = layout.pack(new), layout.pack(state.own)
        whole = within(made_state, -BEYOND, BEYOND) if layout.size else 1.0
        watch, command, made = after(
            self.robot, self._limits, self._descents, watch, sight, wanted, whole, dt
        )
        own = layout.unpack(where(made > 0.5, made_state, old_state))
        signals = dict(signals)
        # A controller that was not asked goes on from the pace that it knows: it would take a path that
        # stood still for one that it may not follow. A flight that is broken off has no mission.
        pace = state.pace * within(watch.mode, 0.0, RETREAT - 0.5)
        if PACE in signals:
            # Who moves a mission's clock by it, in C too, gets a number though gains or memory are spoilt.
            pace = signals[PACE] = limited_pace(where(made > 0.5, signals[PACE], pace))
        shares = watch.loss.left[: self.robot.n_rotors]  # of pairs, those along stand first
        return (
            State(own, watch, pace),
            command,
            {
                **signals,
                MODE: watch.mode,
                BITS: word_of(sight.bits),
                SHARES: shares,
                LATENESS: watch.late.late,
                SLOWNESS: watch.late.slow,
            },
        )
