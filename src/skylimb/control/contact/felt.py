"""What the pen feels of the surface under it, and whether that has gone.

A tip cannot go on into a surface that is there. Where it does, and feels little of what it felt before, the
surface has gone from under it: nothing is learnt of it there, and the laws that press know it (`gone`).
It is no alarm, and nothing has to be taken back: a pen that falls off a step lands more gently.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.control.estimation.surface import SurfaceState, follow_surface
from skylimb.control.records import LawInput
from skylimb.symbolic import Array, clip, low_pass, vector, where

SUNK = 0.003, 0.006
"""Ways of the tip into where the surface should be from which it may have gone, and has, m."""

FELT = 0.33, 0.55
"""Shares of the force that was felt before below which it has gone, and may have."""

FORGETS = 1.0
"""Rate at which that way and that force are forgotten, 1/s: errors of the slope add up."""


class Felt(NamedTuple):
    """What the pen felt of its surface in a tick.

    Attributes:
        surface: under the pen.
        ways: from where it touched last, in the sliding plane, m, (2,).
        touching: 1 where the surface was learnt.
        sunk: how far it has gone on into where the surface should be, lately, m.
        pressed: normal force that was felt lately, N.
        gone: from 0 to 1, how sure it is that the surface has gone.
    """

    surface: SurfaceState
    ways: Array
    touching: Any
    sunk: Any
    pressed: Any
    gone: Any


def felt_by(
    gains: Any,
    state: Any,
    inputs: LawInput,
    place: Array,
    across: Any,
    force: Any,
    engaged: tuple[Any, Any],
) -> Felt:
    """What the pen feels of the surface, and whether that has gone from under it.

    Args:
        gains: of the law.
        state: of the tick before.
        inputs: of this tick.
        place: of the tip in the task's frame, m, (3,).
        across: what is felt across the path; see `seen_across`.
        force: normal force that is felt, N.
        engaged: 1 where the pen is in touch, of this tick and of the one before.
    """
    now, before = engaged
    dt, fresh = inputs.dt, now * (1.0 - before)
    touching = now * where(-inputs.estimate.contact_force > gains.machine.lost_force, 1.0, fresh)
    pressed = low_pass(state.pressed, force, FORGETS, dt) * now
    little = clip((FELT[1] * pressed - force) / ((FELT[1] - FELT[0]) * pressed + 1e-6), 0.0, 1.0)
    touching = touching * (1.0 - little)
    ways = vector(place[1] - state.touched[0], place[2] - state.touched[1])
    surface = follow_surface(
        gains.surface, state.surface, place, touching, fresh, fresh * state.known * ways, across, dt
    )
    slope, way = surface.estimate[1:3], place - state.place
    sunk = low_pass(state.sunk, 0.0, FORGETS, dt) + way[0] - slope[0] * way[1] - slope[1] * way[2]
    sunk = sunk * now * before
    gone = little * clip((sunk - SUNK[0]) / (SUNK[1] - SUNK[0]), 0.0, 1.0)
    return Felt(surface, ways, touching, sunk, pressed, gone)
