"""How fast the mission may go on: no faster than body and arm follow the surface, and the pen its path.

The pace is 1, less where the surface would come toward the pen faster than body and arm can follow,

    pace = min(1, axis_speed / |s . v|),        v the velocity of the path, s the slope,

less where the pen stays behind its path, and 0 while the mission waits for touch.
"""

from __future__ import annotations

from typing import Any

from skylimb.control.contact.machine import SLIDE, MachineState, is_in
from skylimb.control.missions.reference import Reference
from skylimb.symbolic import abs, clip, max, min, where


def pace_of(
    gains: Any,
    before: Any,
    path_speed: Any,
    machine: MachineState,
    reference: Reference,
    speed: Any,
    surface_velocity: Any,
    behind: Any,
    dt: float,
) -> tuple[Any, Any]:
    """The pace of the mission, and the speed of the path at it, m/s.

    Args:
        gains: of the law.
        before: pace of the last tick.
        path_speed: of the path at it, as it was meant, m/s.
        machine: of this tick.
        reference: of this tick, at the pace of the last one.
        speed: of the path, m/s, at the pace of the last tick.
        surface_velocity: at which the surface comes, m/s, at the same pace.
        behind: distance of the pen from its path, m.
        dt: control period, s.
    """
    # Speeds are those of the present pace; divided by it, they are those of the mission's own.
    own = clip(before, 0.05, 1.0)
    allowed = clip(gains.axis_speed * own / (abs(surface_velocity) + 1e-6), gains.least_pace, 1.0)
    slow = max(gains.least_pace, gains.waiting_speed * own / (speed + 1e-6))
    waiting = min(gains.waiting_pace, slow)
    allowed = allowed * clip((gains.wait_beyond - behind) / (0.5 * gains.wait_beyond), waiting, 1.0)
    halted = reference.wait * (1.0 - machine.given_up) * (1.0 - is_in(machine.state, SLIDE))
    faster = (path_speed + gains.path_acceleration * dt) * own / (speed + 1e-6)
    slower = before - gains.path_acceleration * dt * own / (speed + 1e-6)
    pace = clip(allowed, where(slower < faster, slower, faster), faster)
    pace = clip(where(halted > 0.5, 0.0, where(reference.wait > 0.5, pace, 1.0)), 0.0, 1.0)
    return pace, pace / own * speed
