"""How late measurements are: which of a bank of latencies makes commands and measured turning fit best.

The torque that the rotors make shows in the measured turning one latency later. For each latency of the bank
what is left of the one, once the other is taken off, is low-passed alike; what acts from outside is the same
in all of them. So the right one leaves least as soon as the robot makes any motion of its own, in hover too.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.control.estimation.records import BodyState
from skylimb.symbolic import Array, abs, between, clip, dot, low_pass, right_inverse, vector, where, within

BANK = (0.0, 0.025, 0.05, 0.075, 0.1)
"""Latencies that are tried, beyond the assumed one, s."""

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

WARM, HEARD = 0.5, 0.2
"""Time for which the mean is formed before anything counts, and then for which it counts before anything is
judged, s: by chance one moment fits any latency."""

STEP = 0.051
"""By how much more than before is believed at a time, s."""


class Lateness(NamedTuple):
    """What is remembered.

    Attributes:
        made: low-passed torques of the rotors, newest first, C, N m.
        turned: the low-passed change of angular momentum, C, N m, (3,).
        momentum: of the last tick, C, kg m^2/s, (3,).
        outside: mean of what the assumed latency leaves, C, N m, (3,).
        misfits: mean square of what each latency leaves, (rad/s^2)^2.
        late: how much later than assumed measurements are, s.
        time: for which the mean has been formed, and then for which it has been counted, s.
    """

    made: tuple[Array, ...] = (np.zeros(3),) * _DEPTH
    turned: Array = np.zeros(3)
    momentum: Array = np.zeros(3)
    outside: Array = np.zeros(3)
    misfits: Array = np.zeros(len(BANK))
    late: Any = 0.0
    time: Any = 0.0


def lateness(
    state: Lateness, body: BodyState, torque: Array, latency: float, said: Any, fresh: Any, dt: float
) -> Lateness:
    """One step.

    Args:
        state: of the last tick.
        body: as measured.
        torque: of the rotors less the gyroscopic one, over the last tick, C, N m, (3,).
        latency: that is assumed, s.
        said: by how much later than that the stamps say that the body is measured, s.
        fresh: 1 where the body is measured, and was so for a while.
        dt: control period, s.
    """
    momentum = body.model.inertia_C @ body.angular_velocity
    change = (momentum - state.momentum) * (1.0 / dt)
    turned = low_pass(state.turned, change, _RATE, dt)
    made = (low_pass(state.made[0], torque, _RATE, dt), *state.made[:-1])
    inverse = right_inverse(body.model.inertia_C)
    left = [turned - between(made, clip((latency + late) / dt, 0.0, _DEPTH - 1.0)) for late in BANK]
    outside = low_pass(state.outside, left[0], _MEAN, dt)
    squares = []
    for each in left:
        rest = inverse @ (each - outside)
        squares.append(dot(rest, rest))
    # An error of the model, such as a centre of gravity that lies elsewhere, has to be in the mean first.
    warm = within(state.time, WARM, np.inf)
    fresh = fresh * warm
    time = clip(state.time + where(warm > 0.5, fresh * dt, dt), 0.0, WARM + HEARD + dt)
    misfits = low_pass(state.misfits, vector(*squares), _MEMORY * fresh, dt)
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
    clear = clear * within(time, WARM + HEARD, np.inf)
    return Lateness(made, turned, momentum, outside, misfits, where(clear > 0.5, late, state.late), time)
