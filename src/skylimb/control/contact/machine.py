r"""The contact's state machine: free, approach, settle, slide, lost, recontact, retreat.

    free ---wanted--> approach ---touched---> settle ---calm---> slide
     ^                   |                      ^  \               |
     |                   | nothing there        |   \--no force----+---> lost ---rested---> recontact
   clear                 v                   touched                                            |
     +--------------- retreat <-----------------+--------------- nothing there -----------------+

A pen that rests after a loss and is touched meanwhile settles as well: it need not look again.

Every transition has a reason that is recorded with it. Whatever the state, the robot retreats once the
mission wants no touch. All of it is arithmetic on numbers, so that it compiles into the tick.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from skylimb.base.keys import Key, configuration
from skylimb.symbolic import where

STATES = ("free", "approach", "settle", "slide", "lost", "recontact", "retreat")
FREE, APPROACH, SETTLE, SLIDE, LOST, RECONTACT, RETREAT = (float(i) for i in range(len(STATES)))

REASONS = (
    "start",
    "the mission wants touch",
    "touched",
    "the force is calm",
    "no force",
    "rested",
    "nothing there",
    "the mission wants no touch",
    "clear of the surface",
)
START, WANTED, TOUCHED, CALM, NO_FORCE, RESTED, NOTHING, OVER, CLEAR = (float(i) for i in range(len(REASONS)))


@configuration
class MachineGains:
    """When the machine changes its state.

    Before the first slide a touch may have been a false one, far from the surface: then the search after a
    loss goes on as far as the first one would.
    """

    touch_force: Annotated[float, Key("N", "force that counts as touch", above=0.0, high=100.0)] = 0.5
    touch_time: Annotated[float, Key("s", "how long that force has to last", low=0.0, high=10.0)] = 0.015
    lost_force: Annotated[float, Key("N", "force below which the touch may be lost", low=0.0, high=10.0)] = (
        0.25
    )
    lost_time: Annotated[float, Key("s", "how long the force has to be that low", above=0.0, high=60.0)] = 0.2
    settle_time: Annotated[float, Key("s", "how long a touch lasts before the slide", low=0.0, high=60.0)] = (
        1.0
    )
    rest_time: Annotated[
        float, Key("s", "rest before the surface is looked for again", low=0.0, high=60.0)
    ] = 0.5
    search: Annotated[
        float, Key("m", "how far beyond its nominal place the surface is looked for", above=0.0, high=10.0)
    ] = 0.25
    search_again: Annotated[
        float, Key("m", "how far beyond the place of a loss the surface is looked for", above=0.0, high=10.0)
    ] = 0.10


class MachineState(NamedTuple):
    """State and the reason of the last transition (indices of `STATES`, `REASONS`), and clocks.

    Without arguments it is free.

    Attributes:
        state: index of `STATES`.
        reason: index of `REASONS`.
        since: time in the state, s.
        weak: time for which the force has been too low, s.
        strong: time for which the force has been that of a touch, s.
        given_up: 1 once no surface could be found, until the mission wants no touch any more.
        slid: 1 once the pen has slid, until the mission wants no touch any more.
    """

    state: Any = FREE
    reason: Any = START
    since: Any = 0.0
    weak: Any = 0.0
    strong: Any = 0.0
    given_up: Any = 0.0
    slid: Any = 0.0


class Cues(NamedTuple):
    """What transitions depend on.

    Attributes:
        touch: 1 while the mission wants touch.
        force: against the tip, N.
        smooth_force: what it is behind a low pass, N.
        beyond: of the tip beyond the surface's nominal place, along the contact axis, m.
        sunk: of the tip beyond the place of the last loss, m.
        clear: 1 when the tip is back where the mission wants it without touch.
    """

    touch: Any
    force: Any
    smooth_force: Any
    beyond: Any
    sunk: Any
    clear: Any


def is_in(state: Any, *which: float) -> Any:
    """1 while the machine is in one of the states, else 0."""
    return sum((where(state == one, 1.0, 0.0) for one in which), start=0.0)


def advance(gains: Any, machine: MachineState, cues: Cues, dt: float) -> MachineState:
    """One tick of the machine; at most one transition."""
    now = machine.state
    weak = where(cues.smooth_force < gains.lost_force, machine.weak + dt, 0.0) * is_in(now, SETTLE, SLIDE)
    strong = where(cues.force > gains.touch_force, machine.strong + dt, 0.0)
    touched = strong > gains.touch_time - 0.5 * dt
    given_up = where(cues.touch > 0.5, machine.given_up, 0.0)
    slid = where(cues.touch > 0.5, where(is_in(now, SLIDE) > 0.5, 1.0, machine.slid), 0.0)
    far = where(cues.sunk > gains.search_again, 1.0, 0.0)
    far = far * where(slid + where(cues.beyond > gains.search, 1.0, 0.0) > 0.5, 1.0, 0.0)
    # Each rule: in which states, on what condition, where to, why. The first that holds is taken.
    rules = (
        ((APPROACH, SETTLE, SLIDE, LOST, RECONTACT), cues.touch < 0.5, RETREAT, OVER),
        ((FREE,), cues.touch * (1.0 - given_up) > 0.5, APPROACH, WANTED),
        ((APPROACH, LOST, RECONTACT), touched, SETTLE, TOUCHED),
        ((APPROACH,), cues.beyond > gains.search, RETREAT, NOTHING),
        ((RECONTACT,), far > 0.5, RETREAT, NOTHING),
        ((SETTLE, SLIDE), weak > gains.lost_time, LOST, NO_FORCE),
        ((SETTLE,), machine.since > gains.settle_time, SLIDE, CALM),
        ((LOST,), machine.since > gains.rest_time, RECONTACT, RESTED),
        ((RETREAT,), cues.clear > 0.5, FREE, CLEAR),
    )
    state, reason = now, machine.reason
    for states, condition, target, why in reversed(rules):
        holds = is_in(now, *states) * where(condition, 1.0, 0.0) > 0.5
        state, reason = where(holds, target, state), where(holds, why, reason)
    changed = where(state == now, 0.0, 1.0)
    given_up = where(changed * is_in(reason, NOTHING) > 0.5, 1.0, given_up)
    stay = 1.0 - changed
    since = (machine.since + dt) * stay
    return MachineState(state, reason, since, weak * stay, strong * stay, given_up, slid)
