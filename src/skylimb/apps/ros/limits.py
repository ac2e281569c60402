"""Thresholds and time-outs of the lab's flight states, and what bounds a user's target."""

from __future__ import annotations

from dataclasses import dataclass, field

from skylimb.apps.ros.pad import Pad
from skylimb.flight.realtime.preflight import StartLimits


@dataclass(frozen=True)
class FlightLimits(StartLimits):
    """Numbers of the lab's navigator for hydrus_xi, where no comment says that they are ours.

    Attributes:
        takeoff_height: of the centre of gravity in W that a take-off goes to, m.
        takeoff_drift: way to any side, or up, since `start` above which `takeoff` stops instead, m.
        settled_xy: distance from the target below which a take-off counts as settled, m.
        settled_z: the same of the height, m.
        settled_time: for which it has to be, s.
        landed_speed: speed down below which it may stand, m/s.
        landed_lead: how far the target has to be below a robot that stands, m; ours, so that none is stopped
            in the air on its way back from a surface.
        landed_sinking: speed down below which such a robot gets less and less thrust, m/s; ours, half of that
            of a landing.
        blind_fall: acceleration with which a blind robot sinks at least, m/s^2; ours.
        blind_margin: time beyond that of the fall after which it is down in any case, s; ours.
        idle: share of its weight below which motors carry no robot, whatever is seen of it; ours.
        sinks: share of its weight below which it sinks, also with rotors that give a fifth more: one that
            does not stands. A forced landing ends with 0.7 on the lab's; ours.
        disarmed: time in which a flight controller that was disarmed may still say otherwise, s; ours.
        nav_speed: of a step on `uav/nav`, m/s.
        fastest: of a velocity on `uav/nav`, m/s.
        nav_timeout: after which a velocity on `uav/nav` ends, s.
        pose_speed: of a way to `target_pose`, m/s.
        turn_speed: of a turn there, rad/s.
        shortest_way: time that any such way takes at least, s.
        joint_speed: of shape joints that a user moves, rad/s; ours.
        farthest: distance to a target beyond which it is refused, m; ours.
        lowest: height of a target below which it is refused, m; ours.
        acknowledged: time in which arming has to be acknowledged, s; ours.
        tilt: beyond which a flight is broken off, rad; the flight controller's.
        astray: distance from the reference beyond which it is, m; ours.
        speed: of the centre of gravity beyond which a flight is broken off, m/s; ours.
        adopt: what becomes of a flight that somebody else began: "land" or "hover"; ours.
        pad: which buttons and axes of a radio mean what.
        radio: silence of a radio that was heard after which the robot lands, s; ours.
    """

    takeoff_height: float = 0.6
    takeoff_drift: float = 0.3
    settled_xy: float = 0.15
    settled_z: float = 0.05
    settled_time: float = 1.0
    landed_speed: float = 0.05
    landed_lead: float = 0.1
    landed_sinking: float = 0.15
    blind_fall: float = 0.4
    blind_margin: float = 2.0
    idle: float = 0.5
    sinks: float = 0.8
    disarmed: float = 0.3
    nav_speed: float = 0.3
    fastest: float = 0.5
    nav_timeout: float = 0.5
    pose_speed: float = 0.5
    turn_speed: float = 0.3
    shortest_way: float = 2.0
    joint_speed: float = 0.2
    farthest: float = 10.0
    lowest: float = 0.3
    acknowledged: float = 5.0
    tilt: float = 1.0
    astray: float = 2.0
    speed: float = 3.0
    adopt: str = "land"
    pad: Pad = field(default_factory=Pad)
    radio: float = 1.0
