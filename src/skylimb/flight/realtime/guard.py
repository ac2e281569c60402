"""The supervisor around a controller that flies here: clock, exceptions, and what people are warned of."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Any

import numpy as np

from skylimb.control.controller import Controller
from skylimb.control.estimation.gates import FAULTS
from skylimb.control.estimation.records import Measurement, Taken
from skylimb.control.missions.reference import Reference
from skylimb.control.needs import PACE, needs_of
from skylimb.control.records import Command
from skylimb.control.supervisor.halves import Halves
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Flags
from skylimb.control.supervisor.suited_gains import MOST, RETURNED, suited_gains
from skylimb.control.supervisor.supervised import BITS, LATENESS, MODE, SLOWNESS, word_of
from skylimb.control.supervisor.table import RETREAT, TABLE
from skylimb.flight.realtime.faults import Faults
from skylimb.flight.realtime.own_signals import at_rest, kept_signals, unknown_signals
from skylimb.flight.realtime.pacer import Pacer
from skylimb.flight.realtime.watchdog import shaped
from skylimb.robots.model import Robot

_log = logging.getLogger(__name__)

FAILED = "the controller failed"
"""Why a flight is broken off whose controller raises."""

STALLED = "this computer stood still"
"""Why one is broken off that had no tick for longer than its limit of overruns."""

SLOW = "commands take too long"
"""Why one is broken off whose robot gets them too late."""

WORDS = {
    "stop": "motors off were ordered",
    "land": "a landing was ordered",
    "lost": "attitude unknown for too long",
    "blind": "no pose for long",
    "stale": "pose too old",
    "dead": "a rotor is dead",
    "doomed": "a rotor is dead that it cannot do without",
    "lossy": "a rotor is weak",
    "pushed": "something pushes it",
    "astray": "a joint is not where its servo turned it",
    "behind": "measurements come too late",
    "numb": "no joint angles for long",
    "deaf": "the IMU is silent",
    "silent": "no command for long",
    "late": "no command in time",
    "spent": "the descent takes too long",
    "unfit": "velocity or rates do not fit the poses",
    "upset": "tipped over",
}
"""What a pilot reads of each bit of the supervisor's table."""

COUNTED = ("stale", "blind", "numb")
"""Bits that are counted among the faults of a flight."""

FRESH = 0.1
"""Seconds for which a measurement shows where a robot is that nobody has commanded for a while."""

_MARGIN = 1e-6
"""Radians, or parts of a newton, by which a command may be off its limits by rounding."""


class GuardedController:
    """Follows `Controller` around another one, which `control.supervisor` watches.

    Args:
        controller: what flies.
        robot: gives the model and the limits of a command.
        pacer: tells how late a tick is; None for a flight without a wall clock.
        limits: when the supervisor acts.

    Attributes:
        limits: the same.
        flown: the reference that was flown last: the mission's, or that of the retreat.
        counts: how often each fault was met.
        failed: what the controller raised first, in words; empty while it has not.
        why: the flight was broken off: what its user ordered or the supervisor saw, in words; empty while it
            was not.
        sees: whether the pose of the last tick was a measured one.
    """

    def __init__(
        self,
        controller: Controller,
        robot: Robot,
        pacer: Pacer | None = None,
        limits: Limits | None = None,
    ) -> None:
        self._controller, self._pacer, self._robot = controller, pacer, robot
        self.limits = limits or Limits()
        self.name, self.needs = controller.name, needs_of(controller)
        limits_of = robot.thrust_limits(), robot.joint_limits(), robot.vectoring_limits()
        self._bounds = [(low - _MARGIN, high + _MARGIN) for low, high in limits_of]
        self._halves: Halves | None = None
        self._mode, self._flags, self._own = 0, Flags(), dict[str, Any]()
        self._taken: tuple[float | None, float | None] = None, None
        self._last = Taken()
        self.flown: Reference | None = None
        self.counts, self.failed, self.why, self.sees = Faults(), "", "", False
        self._delay, self._wakes = 0.0, False

    @property
    def mode(self) -> str:
        """Name of the mode, as in the supervisor's table."""
        return list(TABLE.modes)[self._mode]

    @property
    def retreating(self) -> bool:
        """Whether the flight was broken off."""
        return self._mode >= RETREAT or self._flags.land > 0.0

    @property
    def reason(self) -> str:
        """Why the flight was broken off, in words for people."""
        if self.failed:
            return f"{FAILED}: {self.failed}"
        return f"broken off by the guard ({self.why})" if self.why else "broken off by the guard"

    def taken(self, pose: float, joints: float | None = None) -> None:
        """When the next tick's measurement was taken, s on a clock of its own; by default it is new.

        Args:
            pose: pose and twist.
            joints: its angles; by default they are new.
        """
        self._taken = pose, joints

    def delayed(self, delay: float) -> None:
        """What a link adds to the delay of the loop, s: gains suit it (`suited_gains`), or it is led back.

        A delay of commands does to the loop what one of measurements does, and nothing that is measured
        tells it before the robot swings.
        """
        self._delay = round(delay, 6)  # a difference of stamps
        if self._delay > MOST and not self.retreating:
            self.retreat(SLOW)

    def retreat(self, why: str = "") -> None:
        """Break the flight off at the next tick, for a fault if there is a reason, else to land."""
        if why:
            self.counts.note("guard", why)
            self.why = self.why or why
        self._flags = self._flags._replace(land=1.0)

    def wake(self) -> None:
        """Lead it back after a time without ticks; it is begun anew as soon as a fresh measurement comes.

        What was predicted, observed and integrated before is not true of the robot that is found then: by its
        prediction no pose would be believed.
        """
        self._wakes, self.flown = True, None
        self.retreat(STALLED)

    def stop(self) -> None:
        """Command the least at the next tick and from then on."""
        self._flags = self._flags._replace(stop=1.0)

    def gains(self) -> Any:
        """The controller's own."""
        return self._controller.gains()

    def initial_state(self) -> Any:
        """The controller's own."""
        return self._controller.initial_state()

    def rehearsed(self, reference: Reference, dt: float) -> dict[str, Any]:
        """The signals of a tick near a reference that is not flown; what has to be made for ticks is made."""
        self._made(len(reference.ahead), dt)
        if not self._own:
            still = at_rest(reference, self.needs.imu)
            self._own = unknown_signals(
                self._tried(self.gains(), self.initial_state(), still, reference, dt)[2]
            )
        return {**self._own, **self._signals(False)}

    def step(
        self, gains: Any, state: Any, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[Any, Command, Mapping[str, Any]]:
        """Look, decide (`control/supervisor`), and do what was decided."""
        halves = self._made(len(reference.ahead), dt)
        missed = self._pacer is not None and self._pacer.missed
        if missed:
            self.counts.note("guard", "missed tick")
        (pose, joints), measured = self._fresh(), self._shaped(measurement)
        known = measured is not None
        if self._wakes and known and measurement.capture_age <= FRESH and self.mode != "CUT":
            halves.begin()
            state, pose, joints, missed, self._wakes = self.initial_state(), True, True, False, False
        flags = self._flags._replace(
            pose=float(pose and known), joints=float(joints and known), late=float(missed)
        )
        self._flags = Flags()
        sight = halves.look(flags, measured, reference)
        self._note(halves)
        new, command = state, None
        if halves.started:
            self.flown = sight.reference
        layout = getattr(self._controller, "gain_layout", None)
        if layout is not None and (self._late or halves.slow or halves.back < RETURNED):
            gains = suited_gains(layout, gains, self._late, halves.slow, halves.back)
        if sight.asks > 0.5:
            new, command, own = self._asked(gains, state, sight.measurement, sight.reference, dt)
            if command is not None or not self._own:
                self._own = self._kept(own)
        elif not self._own:  # the signals' names come from a tick that is not flown
            self.rehearsed(reference, dt)
        command, flew = halves.act(command)
        return new, command, {**self._own, **self._signals(flew)}

    def _made(self, ahead: int, dt: float) -> Halves:
        """Both halves of the supervisor."""
        robot, limits, needs = self._robot, self.limits, self.needs
        self._halves = self._halves or Halves(robot, limits, ahead, dt, needs.imu, needs.vectoring)
        return self._halves

    @property
    def _late(self) -> float:
        """How much later than assumed the controller's answers are, s."""
        return max(0.0 if self._halves is None else self._halves.late, self._delay)

    def _signals(self, flew: bool) -> dict[str, float]:
        """How a tick went, whose command is the controller's or not."""
        late, latency = (0.0, 0.0) if self._pacer is None else (self._pacer.late, self._pacer.elapsed())
        sight = None if self._halves is None else self._halves.sight
        return {
            MODE: float(self._mode),
            BITS: 0.0 if sight is None else float(word_of(sight.bits)),
            "tick_late": late,
            "tick_latency": latency,
            "tick_held": float(not flew),
            "loop_delay": self._delay,
            LATENESS: self._late,
            SLOWNESS: 0.0 if self._halves is None else self._halves.slow,
            "retreating": float(self.retreating),
        }

    def _tried(
        self, gains: Any, state: Any, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[Any, Command | None, dict[str, Any]]:
        """State, command and signals that the controller makes of a tick; none where it raises.

        It may be anybody's Python, and a robot in the air comes down all the same.
        """
        try:
            new, command, own = self._controller.step(gains, state, measurement, reference, dt)
            return new, None if command is None else self._checked(command), dict(own)
        except (Exception, SystemExit) as error:
            self.counts.note("guard", FAILED)
            self.failed = self.failed or str(error) or type(error).__name__
            self.retreat()
            return state, None, {}

    def _asked(
        self, gains: Any, state: Any, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[Any, Command | None, dict[str, Any]]:
        """The same, checked; the state of before and no command where that is none."""
        new, command, own = self._tried(gains, state, measurement, reference, dt)
        if isinstance(new, np.ndarray) and not np.isfinite(new).all():
            self.counts.note("guard", "state is no number")
            command = None
        return (state if command is None else new), command, own

    def _kept(self, own: Mapping[str, Any]) -> dict[str, Any]:
        """The signals of its first tick, as they are now; one that is no number of that shape is NaN.

        A column of a log is no reason to drop a robot. A mission that nobody paces any more is broken off.
        """
        kept, odd = kept_signals(own, self._own or own)
        for name in odd:
            self.counts.note("guard", f"signal '{name}' is not what it was")
        if PACE in odd:
            self.retreat(f"its controller no longer says its {PACE}")
        return kept

    def _fresh(self) -> tuple[bool, bool]:
        """Whether pose and angles of this tick were taken after those before."""
        taken, self._taken = self._taken, (None, None)
        stamps = [last if time is None else time for time, last in zip(taken, self._last, strict=True)]
        new = [bool(last < time < np.inf) for time, last in zip(stamps, self._last, strict=True)]
        times = zip(new, stamps, self._last, strict=True)
        self._last = Taken(*(time if one else last for one, time, last in times))
        return taken[0] is None or new[0], taken[1] is None or new[1]

    def _shaped(self, measurement: Measurement) -> Measurement | None:
        """The measurement as arrays of the right sizes; None where it is none."""
        seen = shaped(self._robot, measurement, self.needs.imu)
        if isinstance(seen, str):
            self.counts.note("guard", seen)
            return None
        return seen

    def _note(self, halves: Halves) -> None:
        """Count what was seen, and say once what changed."""
        for fault in {FAULTS[int(number)] for number in halves.sight.faults} - {""}:
            self.counts.note("guard", fault)
        bits = dict(zip(TABLE.bits, halves.sight.bits, strict=True))
        self.sees = bool(bits["stale"] < 0.5)
        for name in COUNTED:
            if bits[name] > 0.5:
                self.counts.note("guard", WORDS[name])
        mode, before = int(halves.mode), self.mode
        if mode != self._mode:
            self._mode = mode
            if mode >= RETREAT:
                words = {**WORDS, "land": self.why or WORDS["land"]}
                seen = ", ".join(words[name] for name, bit in bits.items() if bit > 0.5)
                self.why = self.why or seen
                _log.warning("%s -> %s: %s", before, self.mode, seen)

    def _checked(self, command: Command) -> Command | None:
        """A command as arrays; None where it is none. The supervisor cuts it off at its limits."""
        parts = []
        for given, (low, high) in zip(command, self._bounds, strict=True):
            part = np.asarray(given, dtype=float).reshape(-1)
            if part.shape != low.shape or not np.isfinite(part).all():
                words = "command is no number" if part.shape == low.shape else "command of wrong size"
                self.counts.note("guard", words)
                return None
            if (part < low).any() or (part > high).any():
                self.counts.note("guard", "command out of limits")
            parts.append(part)
        return Command(*parts)
