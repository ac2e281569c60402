"""A controller that commands nothing on bad grounds, and never anything out of limits."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Any

import numpy as np

from skylimb.base.errors import SkylimbError
from skylimb.control.controller import Controller
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference
from skylimb.control.needs import needs_of
from skylimb.control.records import Command
from skylimb.flight.realtime.decision import Action, Evidence, decide
from skylimb.flight.realtime.faults import Faults
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.retreat import Retreat
from skylimb.flight.realtime.watchdog import Limits, State, Watchdog
from skylimb.robots.model import Robot

_log = logging.getLogger(__name__)

BLIND = 0.95
"""Share of the hover thrusts with which a robot descends that has nothing measured any more."""

_MARGIN = 1e-6
"""Radians, or parts of a newton, by which a command may be off its limits by rounding."""

_INSTANT = 1e-6
"""Least time between two ticks, s."""


class GuardedController:
    """Follows `Controller` around another one.

    At every tick it either flies, holds the command of the tick before, or retreats from the surface and
    descends level. It holds a tick that begins when the next one is due, a measurement that is too old or not
    believed, and a command that is no number. It retreats once the last good measurement is too old, or after
    too many ticks in a row without a new command. From a retreat there is no way back.

    Args:
        controller: what flies.
        robot: gives the limits of a command.
        pacer: tells how late a tick is; None for a flight without a wall clock.
        limits: when to hold and when to retreat.
        floor: height of the centre of gravity at which the descent of a retreat ends, m.

    Attributes:
        flown: the reference that the controller was last given: the mission's, or that of the retreat.
        counts: how often each fault was met.
    """

    def __init__(
        self,
        controller: Controller,
        robot: Robot,
        pacer: Pacer | None = None,
        limits: Limits | None = None,
        floor: float = 0.0,
    ) -> None:
        self._controller, self._pacer, self._floor = controller, pacer, floor
        self._robot, self._limits = robot, limits or Limits()
        self.name, self.needs = controller.name, needs_of(controller)
        self.watchdog = Watchdog(robot, self._limits)
        self._bounds = (robot.thrust_limits(), robot.joint_limits(), robot.vectoring_limits())
        # What was commanded and recorded last; set at the first tick.
        self._last: tuple[Command, dict[str, Any]] = Command(*(low for low, _ in self._bounds)), {}
        self._retreat: Retreat | None = None
        self._retreated_at = self._ticks = self._without = 0
        self._taken: float | None = None
        self._now = -_INSTANT
        self.flown: Reference | None = None
        self.counts = Faults()

    @property
    def retreating(self) -> bool:
        """Whether the flight was broken off."""
        return self._retreat is not None

    def taken(self, time: float) -> None:
        """When the next tick's measurement was taken, s since the first tick; by default at that tick."""
        self._taken = time

    def retreat(self, why: str = "") -> None:
        """Break the flight off at the next tick, for a fault if there is a reason, else to land."""
        if why:
            self.counts.note("guard", why)
        self._without = self._limits.overruns + 1

    def gains(self) -> Any:
        """The controller's own."""
        return self._controller.gains()

    def initial_state(self) -> Any:
        """The controller's own."""
        return self._controller.initial_state()

    def step(
        self, gains: Any, state: Any, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[Any, Command, Mapping[str, Any]]:
        """Look, decide (`decision.py`), and do what was decided."""
        judged, missed = self._judged(measurement, dt), self._pacer is not None and self._pacer.missed
        measured = self.watchdog.good is not None
        believed = self.watchdog.good or measurement
        if self._ticks == 0:
            self._last = self._still(reference), {}
        if missed:
            self.counts.note("guard", "missed tick")
        if self._ticks == 0 and not measured:
            # The signals' names come from a tick that is not flown.
            _, _, own = self._controller.step(gains, state, _at_rest(reference), reference, dt)
            self._last = self._last[0], {name: np.full(np.shape(own[name]), np.nan) for name in own}
        overdue = self._without > self._limits.overruns
        seen = Evidence(judged, missed, overdue, measured, self._ticks > 0 or not measured)
        decision = decide(self.retreating, seen)
        if decision.broken_off and self._retreat is None:
            _log.warning("retreat at %.3f s", self._now)
            self._retreat, self._retreated_at = Retreat(reference, self._floor), self._ticks
        new, held = state, decision.held
        if decision.action in (Action.FLY, Action.GO_BACK):
            self.flown = self._asked(reference, dt)
            made, wanted, own = self._controller.step(gains, state, believed, self.flown, dt)
            command = self._within(wanted)
            if command is None:  # nothing of this tick is remembered
                held, self._without = True, self._without + 1
                self._last = self._last[0], self._last[1] or dict(own)
            else:
                new, self._without = made, 0
                self._last = command, dict(own)
        elif decision.action == Action.DESCEND:
            self._last = self._descent(believed), self._last[1]
        else:
            self._without += 1
        self._ticks += 1
        command, own = self._last
        return new, command, {**own, **self._signals(held)}

    def _judged(self, measurement: Measurement, dt: float) -> State:
        """What the watchdog says of a measurement at the time of this tick."""
        now = self._ticks * dt if self._pacer is None else self._pacer.time()
        # A late tick and the one that catches up may read the same time; their measurements are two.
        self._now = max(now, self._now + _INSTANT)
        taken, self._taken = self._now if self._taken is None else self._taken, None
        return self.watchdog.judge(measurement, taken, self._now)

    def _asked(self, reference: Reference, dt: float) -> Reference:
        """The reference of this tick: the mission's, or on the way back that of the retreat."""
        if self._retreat is None:
            return reference
        back = self._retreat.at((self._ticks - self._retreated_at) * dt)
        return back._replace(ahead=(back,) * len(self.needs.preview))

    def _signals(self, held: bool) -> dict[str, float]:
        late, latency = (0.0, 0.0) if self._pacer is None else (self._pacer.late, self._pacer.elapsed())
        return {
            "tick_late": late,
            "tick_latency": latency,
            "tick_held": float(held),
            "retreating": float(self.retreating),
        }

    def _within(self, command: Command) -> Command | None:
        """The command within the robot's limits; None where it is no command."""
        parts = []
        for given, (low, high) in zip(command, self._bounds, strict=True):
            part = np.asarray(given, dtype=float).reshape(-1)
            if part.shape != low.shape or not np.isfinite(part).all():
                self.counts.note(
                    "guard", "command is no number" if part.shape == low.shape else "command of wrong size"
                )
                return None
            if np.any(part < low - _MARGIN) or np.any(part > high + _MARGIN):
                self.counts.note("guard", "command out of limits")
                part = np.clip(part, low, high)
            parts.append(part)
        return Command(*parts)

    def _still(self, reference: Reference) -> Command:
        """The least that the actuators can do, in the nominal posture: for a first tick that fails."""
        (low, _), (q_low, q_high), (psi_low, psi_high) = self._bounds
        joints = np.clip(reference.joint_angles, q_low, q_high)
        return Command(low, joints, np.clip(reference.vectoring_angles, psi_low, psi_high))

    def _descent(self, known: Measurement) -> Command:
        """A little less than hover thrusts in the last known posture: level, if the robot was level.

        Nobody holds an attitude without measuring it. A flight controller with a loop of its own does.
        """
        try:
            hover = self._robot.at(known.joint_angles, known.vectoring_angles).hover_thrusts
        except SkylimbError:  # a posture in which the rotors cannot carry the robot
            hover = self._bounds[0][0]
        return self._last[0]._replace(thrusts=np.clip(BLIND * hover, *self._bounds[0]))


def _at_rest(reference: Reference) -> Measurement:
    """A measurement of a robot that hovers level near its reference."""
    z3, level = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    return Measurement(
        np.array(reference.position), level, z3, z3, reference.joint_angles, reference.vectoring_angles
    )
