"""A controller that commands nothing on bad grounds, and never anything out of limits."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from skylimb.base.errors import SkylimbError
from skylimb.control.controller import Controller
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference
from skylimb.control.needs import needs_of
from skylimb.control.records import Command
from skylimb.control.thrusts import thrust_limits
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
        joints, vectoring = robot.joint_limits(), _vectoring_limits(robot)
        self._bounds = (thrust_limits(robot), joints, vectoring)
        self._last: tuple[Command, dict[str, Any]] | None = None
        self._broken: tuple[Retreat, int] | None = None
        self._ticks = self._without = 0
        self._taken: float | None = None
        self._now = -_INSTANT
        self._flown: Reference | None = None
        self.counts: Counter[str] = Counter()

    @property
    def retreating(self) -> bool:
        """Whether the flight was broken off."""
        return self._broken is not None

    @property
    def flown(self) -> Reference | None:
        """The reference that the controller was last given: the mission's, or that of the retreat."""
        return self._flown

    def taken(self, time: float) -> None:
        """When the next tick's measurement was taken, s since the first tick; by default at that tick."""
        self._taken = time

    def retreat(self, why: str = "") -> None:
        """Break the flight off at the next tick, for a fault if there is a reason, else to land."""
        if why:
            self._note(why)
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
        """Fly, hold or retreat."""
        now = self._ticks * dt if self._pacer is None else self._pacer.time()
        # A late tick and the one that catches up may read the same time; their measurements are two.
        self._now = now = max(now, self._now + _INSTANT)
        taken, self._taken = now if self._taken is None else self._taken, None
        judged = self.watchdog.judge(measurement, taken, now)
        if self._broken is None and (judged == State.RETREAT or self._without > self._limits.overruns):
            _log.warning("retreat at %.3f s", now)
            self._broken = Retreat(reference, self._floor), self._ticks
        held = judged == State.HOLD or (self._pacer is not None and self._pacer.missed)
        if held and self._pacer is not None and self._pacer.missed:
            self._note("missed tick")
        known = self.watchdog.good
        if known is None and self._last is None:
            # Nothing is known yet: the signals' names come from a tick that is not flown.
            _, _, own = self._controller.step(gains, state, _at_rest(reference), reference, dt)
            self._last = self._still(reference), {name: np.full(np.shape(own[name]), np.nan) for name in own}
        if judged == State.RETREAT and known is not None and self._last is not None:
            new, (command, own) = state, (self._blind(known), self._last[1])
        elif self._last is not None and (held or known is None):
            new, (command, own) = state, self._last
            self._without += 1
        else:
            if self._broken is not None:
                reference = self._broken[0].at((self._ticks - self._broken[1]) * dt)
                reference = reference._replace(ahead=(reference,) * len(self.needs.preview))
            given = measurement if known is None else known
            self._flown = reference
            new, command, own = self._controller.step(gains, state, given, reference, dt)
            command, own = self._within(command), dict(own)
            if command is None:
                held = True
                new, (command, own) = state, self._last or (self._still(reference), own)
                self._without += 1
            else:
                self._without = 0
        self._last = command, own
        self._ticks += 1
        return new, command, {**own, **self._signals(held)}

    def _signals(self, held: bool) -> dict[str, float]:
        late, latency = (0.0, 0.0) if self._pacer is None else (self._pacer.late, self._pacer.elapsed())
        return {
            "tick_late": late,
            "tick_latency": latency,
            "tick_held": float(held),
            "retreating": float(self.retreating),
        }

    def _note(self, what: str) -> None:
        self.counts[what] += 1
        if self.counts[what] == 1:
            _log.warning("guard: %s", what)

    def _within(self, command: Command) -> Command | None:
        """The command within the robot's limits; None where it is no command."""
        parts = []
        for given, (low, high) in zip(command, self._bounds, strict=True):
            part = np.asarray(given, dtype=float).reshape(-1)
            if part.shape != low.shape or not np.isfinite(part).all():
                self._note("command is no number" if part.shape == low.shape else "command of wrong size")
                return None
            if np.any(part < low - _MARGIN) or np.any(part > high + _MARGIN):
                self._note("command out of limits")
                part = np.clip(part, low, high)
            parts.append(part)
        return Command(*parts)

    def _still(self, reference: Reference) -> Command:
        """The least that the actuators can do, in the nominal posture: for a first tick that fails."""
        (low, _), (q_low, q_high), (psi_low, psi_high) = self._bounds
        joints = np.clip(reference.joint_angles, q_low, q_high)
        return Command(low, joints, np.clip(reference.vectoring_angles, psi_low, psi_high))

    def _blind(self, known: Measurement) -> Command:
        """A little less than hover thrusts in the last known posture: level, if the robot was level.

        Nobody holds an attitude without measuring it. A flight controller with a loop of its own does.
        """
        try:
            hover = self._robot.at(known.joint_angles, known.vectoring_angles).hover_thrusts
        except SkylimbError:  # a posture in which the rotors cannot carry the robot
            hover = self._bounds[0][0]
        thrusts = np.clip(BLIND * hover, *self._bounds[0])
        assert self._last is not None  # whoever knows a measurement has flown a tick
        return self._last[0]._replace(thrusts=thrusts)


def _at_rest(reference: Reference) -> Measurement:
    """A measurement of a robot that hovers level near its reference."""
    z3, level = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    return Measurement(
        np.array(reference.position), level, z3, z3, reference.joint_angles, reference.vectoring_angles
    )


def _vectoring_limits(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    joints = [robot.description.joint(name) for name in robot.description.vectoring_joints]
    return np.array([joint.lower for joint in joints]), np.array([joint.upper for joint in joints])
