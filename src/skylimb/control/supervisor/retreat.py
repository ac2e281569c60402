"""What is to be flown: the mission, or where it is broken off, away from the surface and down."""

from __future__ import annotations

from typing import Any

from skylimb.base.packing import Layout, chosen
from skylimb.base.rotations import rpy_from_rotation
from skylimb.control.estimation.gates import BEYOND
from skylimb.control.estimation.records import BodyState
from skylimb.control.missions.reference import Reference, untasked
from skylimb.control.posture import heading_of
from skylimb.control.supervisor.records import Watch
from skylimb.control.supervisor.table import CUT, RETREAT
from skylimb.robots.model import Robot
from skylimb.symbolic import arctan2, clip, cos, dot, max, min, sin, vector, where, within

BACK, BACK_SPEED = 0.3, 0.2
"""Way back along the contact axis, m, and its speed, m/s."""

DESCENT = 0.3
"""Speed down, m/s: that of the lab's own landing."""

CHANGE = 0.5
"""Greatest change of either speed, m/s^2. A step of .2 or .3 m/s is up to 13 N at once for a controller: it
takes thrusts to their limits, where a robot that is broken off may have few left."""

TURN = 0.3
"""Greatest way to the heading that a robot that is broken off turns to, rad: yaw has the least torque, and
what it takes of the thrusts roll and pitch have not."""


def aimed(
    watch: Watch, mode: Any, reference: Reference, floor: float, dt: float
) -> tuple[Watch, Reference, Any]:
    """What is to be flown in a mode: the mission, or from where it was broken off the way back.

    Args:
        watch: in the mode of the tick before.
        mode: that follows.
        reference: of the mission.
        floor: height of the centre of gravity at which a descent ends, m.
        dt: control period, s.

    Returns:
        What is remembered, the reference, and 1 where that is one.
    """
    was_broken = watch.mode > RETREAT - 0.5
    broken = where(was_broken, watch.clocks.broken + dt, 0.0)
    aims = within(Layout(reference).pack(reference), -BEYOND, BEYOND)
    kept = where(was_broken, 1.0, 0.0) + (1.0 - aims) > 0.5
    asked = chosen(kept, watch.asked, reference._replace(ahead=()))
    back = retreat(asked, broken, floor)
    broken_off = within(mode, RETREAT - 0.5, CUT)
    flown = chosen(broken_off > 0.5, back._replace(ahead=(back,) * len(reference.ahead)), reference)
    # A flight that was never given a reference has none to be broken off at.
    aims = within(dot(flown.contact_axis, flown.contact_axis), 0.5, 2.0) * where(broken_off > 0.5, 1.0, aims)
    return watch._replace(asked=asked, clocks=watch.clocks._replace(broken=broken)), flown, aims


def turned_to(robot: Robot, body: BodyState, flown: Reference) -> Reference:
    """The reference of a retreat with a heading that is near: what is far away is turned to slowly.

    Args:
        robot: the model.
        body: as it is believed.
        flown: what is to be flown.
    """
    yaw, wanted = rpy_from_rotation(body.R_WC)[2], heading_of(robot, body.model.tip_heading, flown)
    way = arctan2(sin(wanted - yaw), cos(wanted - yaw))
    return flown._replace(heading=flown.heading - (way - clip(way, -TURN, TURN)))


def retreat(last: Reference, time: Any, floor: Any = 0.0, back: float = BACK) -> Reference:
    """Back along the contact axis, then straight down, in the posture that the robot has.

    Args:
        last: the reference at which the flight was broken off.
        time: since then, s.
        floor: height of the centre of gravity at which the descent ends, m.
        back: way back, m; 0 where the robot touches nothing.
    """
    turns = back / BACK_SPEED
    begun, ended, sunk = (
        _ramp(time, BACK_SPEED),
        _ramp(time - turns, BACK_SPEED),
        _ramp(time - turns, DESCENT),
    )
    height = last.position[2]
    # Where there is nothing to go back from, what begins ends at once.
    gone, speed, push = (a - b for a, b in zip(begun, ended, strict=True))
    lowest = min(height, floor)
    sinking = where(height - sunk[0] > lowest, 1.0, 0.0)
    axis = last.contact_axis
    moved = -gone * axis + vector(0.0, 0.0, max(height - sunk[0], lowest) - height)
    velocity = -speed * axis - vector(0.0, 0.0, sinking * sunk[1])
    change = -push * axis - vector(0.0, 0.0, sinking * sunk[2])
    return untasked(
        last,
        position=last.position + moved,
        velocity=velocity,
        acceleration=change,
        tip_position=last.tip_position + moved,
        tip_velocity=velocity,
        tip_acceleration=change,
    )


def retreat_time(height: float) -> float:
    """Time in which a retreat from a height has come to the floor, s."""
    rise = DESCENT / CHANGE
    return BACK / BACK_SPEED + (height / DESCENT + 0.5 * rise if height > 0.5 * rise * DESCENT else rise)


def _ramp(time: Any, speed: float) -> tuple[Any, Any, Any]:
    """Way, speed and its change, of what sets off at time 0 and comes to a speed."""
    rising = clip(time, 0.0, speed / CHANGE)
    way = CHANGE * rising * (max(time, 0.0) - 0.5 * rising)
    return way, CHANGE * rising, CHANGE * where(time > 0.0, 1.0, 0.0) * where(time < speed / CHANGE, 1.0, 0.0)
