"""How late measurements are, and how slow the rotors: what of a bank makes commands and turning fit best.

The torque that the rotors make shows in the measured turning one latency later. For each latency of the bank
what is left of the one, once the other is taken off, is low-passed alike; what acts from outside changes
slowly, and is taken off as a mean. So the right one leaves least as soon as the robot makes any motion of its
own, in hover too.

Rotors that are slower than they are believed to be, T for T_0, turn the robot late as well. With x the torque
of the believed ones, theirs is

    y = (1 + s T_0) / (1 + s T) x = (T_0 / T) x + (1 - T_0 / T) x / (1 + s T),

one latency later. A latency of 25 ms and a lag of 50 ms look much alike, so rotors are believed to be slow
only where the stamps say that frames are in time, and a latency that no stamp tells of is believed later.

Where nobody looks at the turning, stamps are all there is (`stamped`). A clock that was set says of frames in
time that they are late. But no frame is made before the one that was seen before it: an age grows with time
while frames stay away, and whatever it grows by beside that is the clock's.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.base.packing import chosen
from skylimb.control.estimation.records import BodyState
from skylimb.control.estimation.stamps import AHEAD
from skylimb.symbolic import (
    Array,
    abs,
    between,
    clip,
    dot,
    low_pass,
    max,
    min,
    right_inverse,
    vector,
    where,
    within,
)

UNSEEN = 1e6
"""Age of a frame that is not seen, s."""

BANK = (0.0, 0.025, 0.05, 0.075, 0.1)
"""Latencies that are tried, beyond the assumed one, s."""

SLOW = (0.0, 0.05, 0.075)
"""Lags of the rotors that are tried, beyond the assumed one, s."""

_DEPTH = 26
_RATE, _MEAN, _MEMORY = 30.0, 5.0, 5.0
"""Rates of the low pass of torques, of the mean of what acts from outside, and at which it is forgotten how
well a latency fitted, 1/s."""

FITS, PLAIN = 0.75, 0.015
"""Share of the square that a better latency leaves at most, and by how much at least it is less,
(rad/s^2)^2: flights whose frames are in time differ by less."""

SAID, SAID_FITS, SAID_PLAIN = 0.0125, 0.9, 0.004
"""By how much what the stamps say may be off a latency of the bank, s, and what then takes the place of
`FITS` and `PLAIN` on the way to more latency. Stamps alone prove nothing: a clock that was set says the like
of frames that are in time."""

IN_TIME = 0.02
"""By how much at most the stamps say that frames are late where slow rotors are believed, s."""

BENDS = 0.02
"""What arms that bend and servos that give way add to the lateness of what turns the robot, s."""

WARM, HEARD, PATIENT = 0.5, 0.2, 0.7
"""Time for which the means are formed before anything counts, and then for which it counts before anything is
judged, and before a latency is of which the stamps say nothing, s: by chance one moment fits any."""

STEP = 0.051
"""By how much more than before is believed at a time, s."""

_SMOOTH = 10.0
"""Rate at which the ages of frames are smoothed where stamps alone count, 1/s."""


class Lateness(NamedTuple):
    """What is remembered.

    Attributes:
        made: low-passed torques of the rotors, as they are believed to lag, newest first, C, N m.
        turned: the low-passed change of angular momentum, C, N m, (3,).
        momentum: of the last tick, C, kg m^2/s, (3,).
        slowed: torque that the stamps say to be seen, low-passed by each lag of `SLOW`, C, N m, (3,) each.
        outside: mean of what the assumed latency, and then each lag, leaves, C, N m, (3,) each.
        misfits: mean square of the rest, (rad/s^2)^2.
        late: how much later than assumed measurements are, s.
        slow: by how much more than assumed the rotors lag, s.
        touched: 1 once the tip was to touch.
        time: for which the means have been formed, and then for which it has been counted, s.
    """

    made: tuple[Array, ...] = (np.zeros(3),) * _DEPTH
    turned: Array = np.zeros(3)
    momentum: Array = np.zeros(3)
    slowed: tuple[Array, ...] = (np.zeros(3),) * len(SLOW)
    outside: tuple[Array, ...] = (np.zeros(3),) * (1 + len(SLOW))
    misfits: Array = np.zeros(len(BANK) + len(SLOW))
    late: Any = 0.0
    slow: Any = 0.0
    touched: Any = 0.0
    time: Any = 0.0


class Stamped(NamedTuple):
    """What stamps alone say.

    Attributes:
        age: of the frame that was seen last, s; before the first one of none.
        since: when that was, s ago.
        least: age of a frame that is in time, as the clocks stand, s.
        said: by how much the last one that came was older, s.
        mean: of that, s.
    """

    age: Any = UNSEEN
    since: Any = 0.0
    least: Any = UNSEEN
    said: Any = 0.0
    mean: Any = 0.0


def stamped(state: Stamped, age: Any, good: Any, dt: float) -> tuple[Stamped, Any]:
    """One step, and the latency beyond the usual one that is believed, s.

    Args:
        state: of the last tick.
        age: of the frame that is seen, as its stamp says, s.
        good: 1 where its pose is believed.
        dt: control period, s.
    """
    since = state.since + dt
    known = good * within(age, -UNSEEN, UNSEEN) > 0.5
    grown = age - state.age
    # Of a clock that is set, frames go on to be as late as they were, to less than the time between two.
    least = where(grown > since + AHEAD, age - state.said, min(state.least, age))
    said = where(grown < since - 0.5 * dt, age - least, state.said)
    found = Stamped(age, 0.0, least, said, low_pass(state.mean, said, _SMOOTH, dt))
    kept = chosen(known, found, state._replace(since=since))
    late = 0.0 * kept.mean
    for each in BANK[2:]:  # a controller bears less
        late = where(kept.mean > each - SAID, each, late)
    return kept, late


def lateness(
    state: Lateness,
    body: BodyState,
    torque: Array,
    latency: float,
    lag: float,
    said: Any,
    fresh: Any,
    touch: Any,
    dt: float,
) -> Lateness:
    """One step.

    Args:
        state: of the last tick.
        body: as measured.
        torque: of the rotors less the gyroscopic one, over the last tick, as they are believed to lag, C,
            N m, (3,).
        latency: that is assumed, s.
        lag: of the rotors that is assumed, s.
        said: by how much later than that the stamps say that the body is measured, s.
        fresh: 1 where the body is measured, and was so for a while.
        touch: 1 while the tip is to touch.
        dt: control period, s.
    """
    momentum = body.model.inertia_C @ body.angular_velocity
    change = (momentum - state.momentum) * (1.0 / dt)
    turned = low_pass(state.turned, change, _RATE, dt)
    made = (low_pass(state.made[0], torque, _RATE, dt), *state.made[:-1])
    seen = [between(made, clip((latency + late) / dt, 0.0, _DEPTH - 1.0)) for late in BANK]
    off = where(within(said, -IN_TIME, IN_TIME) > 0.5, said, 0.0)  # also of a stamp that is no number
    stamped = between(made, clip((latency + BENDS + off) / dt, 0.0, _DEPTH - 1.0))
    slowed, others = [], [lag + slow for slow in SLOW]
    for was, other in zip(state.slowed, others, strict=True):
        slowed.append(low_pass(was, stamped, 1.0 / other, dt))
        share = (lag + state.slow) / other
        seen.append(share * stamped + (1.0 - share) * slowed[-1])
    left = [turned - each for each in seen]
    averaged = (left[0], *left[len(BANK) :])
    outside = tuple(low_pass(was, each, _MEAN, dt) for was, each in zip(state.outside, averaged, strict=True))
    inverse = right_inverse(body.model.inertia_C)
    # A latency that does not fit would take away with its own mean what it should be seen by.
    means = (outside[0],) * len(BANK) + outside[1:]
    rests = [inverse @ (each - mean) for each, mean in zip(left, means, strict=True)]
    # An error of the model, such as a centre of gravity that lies elsewhere, has to be in the mean first.
    warm = within(state.time, WARM, np.inf)
    fresh = fresh * warm
    time = clip(state.time + where(warm > 0.5, fresh * dt, dt), 0.0, WARM + PATIENT + dt)
    squares = vector(*(dot(rest, rest) for rest in rests))
    misfits = low_pass(state.misfits, squares, _MEMORY * fresh, dt)
    found = state._replace(
        made=made,
        turned=turned,
        momentum=momentum,
        slowed=tuple(slowed),
        outside=outside,
        misfits=misfits,
        touched=max(state.touched, touch),
        time=time,
    )
    slow = _slow(found, said)
    other = abs(slow - state.slow) > 1e-6
    # With other rotors all is heard anew.
    late, time = where(other, 0.0, _late(found, said)), where(other, WARM, time)
    return found._replace(late=late, slow=slow, time=time)


def _late(state: Lateness, said: Any) -> Any:
    """The latency that is believed next."""
    misfits = state.misfits
    best, late, present = misfits[0], 0.0 * misfits[0], misfits[0]
    for index, each in enumerate(BANK):
        # What is far from what was believed is believed in steps: the first moments are ambiguous.
        near = where(each < state.late + STEP, 1.0, within(said - each, -SAID, SAID))
        better = where(misfits[index] < best, 1.0, 0.0) * near
        late, best = where(better > 0.5, each, late), where(better > 0.5, misfits[index], best)
        present = where(abs(state.late - each) < 1e-6, misfits[index], present)
    # Back to less, stamps ease nothing: rotors that are slow turn the robot late, and no stamp says so.
    agreed = within(said - late, -SAID, SAID) * where(late > state.late, 1.0, 0.0) > 0.5
    fits, plain = where(agreed, SAID_FITS, FITS), where(agreed, SAID_PLAIN, PLAIN)
    clear = where(best < fits * present, 1.0, 0.0) * where(present - best > plain, 1.0, 0.0)
    heard = where(within(said, -IN_TIME, IN_TIME) > 0.5, PATIENT, HEARD)
    return where(clear * within(state.time - heard, WARM, np.inf) > 0.5, late, state.late)


def _slow(state: Lateness, said: Any) -> Any:
    """The lag of the rotors that is believed next, beyond the assumed one."""
    misfits = state.misfits[len(BANK) :]
    best, slow, present = misfits[0], 0.0 * misfits[0], misfits[0]
    for index, each in enumerate(SLOW):
        better = misfits[index] < best
        slow, best = where(better, each, slow), where(better, misfits[index], best)
        present = where(abs(state.slow - each) < 1e-6, misfits[index], present)
    clear = where(best < FITS * present, 1.0, 0.0) * where(present - best > PLAIN, 1.0, 0.0)
    # Rotors stay as slow as they are, and a touch turns a robot otherwise than any of them.
    heard = within(state.time, WARM + HEARD, np.inf) * within(said, -IN_TIME, IN_TIME) * (1.0 - state.touched)
    return where(clear * heard > 0.5, slow, state.slow)
