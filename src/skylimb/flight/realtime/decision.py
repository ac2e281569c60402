"""What a guarded flight does at a tick: a table without memory, so that every case can be tested.

    what is seen                                    flying          broken off
    ----------------------------------------------------------------------------------
    measurements too old for long, or overdue       -> broken off, see there
      nothing measured for long (judged RETREAT)                    DESCEND
      overdue, and still nothing to go on                           DESCEND
    a tick missed, or a measurement not good        HOLD            HOLD
    no measurement was good yet                     HOLD            HOLD
    else                                            FLY             GO_BACK

From broken off there is no way back. Where no command can be repeated yet, at a first tick, the controller is
asked: its command is checked before it is given.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from skylimb.flight.realtime.watchdog import State


class Action(Enum):
    """What is commanded at a tick."""

    FLY = "what the controller wants on its mission"
    GO_BACK = "what the controller wants on the way back from the surface and down"
    HOLD = "the command of the tick before"
    DESCEND = "a little less than hover thrusts, without any measurement"


class Evidence(NamedTuple):
    """What is known at a tick.

    Attributes:
        judged: what the watchdog says of the measurements.
        missed: the tick begins when the next one is due already.
        overdue: too many ticks in a row were without a new command, or the flight is to be broken off.
        measured: some measurement was good.
        commanded: there is a command to be repeated.
    """

    judged: State
    missed: bool
    overdue: bool
    measured: bool
    commanded: bool


class Decision(NamedTuple):
    """What follows.

    Attributes:
        broken_off: whether the flight is broken off from here on.
        action: what is commanded.
        held: whether the tick counts as held in the log.
    """

    broken_off: bool
    action: Action
    held: bool


def decide(broken_off: bool, seen: Evidence) -> Decision:
    """The row of the table for a flight that was broken off before this tick, or was not."""
    before, broken_off = broken_off, broken_off or seen.overdue or seen.judged == State.RETREAT
    held = seen.missed or seen.judged == State.HOLD
    # A command that is held for long loses the robot.
    blind = seen.judged == State.RETREAT or (before and seen.overdue and held)
    if seen.commanded and seen.measured and blind:
        action = Action.DESCEND
    elif seen.commanded and (held or not seen.measured):
        action = Action.HOLD
    else:
        action = Action.GO_BACK if broken_off else Action.FLY
    return Decision(broken_off, action, held)
