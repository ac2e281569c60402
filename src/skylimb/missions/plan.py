"""The paper's flight laid on a clock: the reference of every tick.

Phases: hover, tare (the observer's bias is averaged), approach along the contact axis, settle in contact,
slide along the path, retreat, hover. Between two strokes of a drawing the slide is interrupted by a lift: the
pen leaves, goes to the next stroke and comes back. Phases follow the clock alone, so the whole table is known
before take-off.
"""

from __future__ import annotations

import numpy as np

from skylimb.missions.configuration import MissionConfig
from skylimb.missions.frame import ContactFrame
from skylimb.missions.mission import PHASES, Mission
from skylimb.missions.posture import PosturePlan
from skylimb.missions.ramp import ramp, ramp_duration
from skylimb.missions.reference import Reference
from skylimb.planning.trajectories import Trajectory, trajectory
from skylimb.spatial import rot_z

_TOUCHING = ("approach", "settle", "slide")
"""Phases in which the tip is to touch, or to go on until it does; in a lift from the way back on."""

_WAITING = ("settle", "slide")
"""Phases that make no sense without touch."""

_LEVEL = 0.5
"""Level part of a contact axis above which the arm can reach along it."""


def plan_mission(
    config: MissionConfig,
    frame: ContactFrame,
    center: np.ndarray,
    posture: PosturePlan,
    dt: float,
    standing_out: float = 0.0,
) -> Mission:
    """Lay the phases on the clock.

    Args:
        config: phases, approach and path.
        frame: axes of the task.
        center: middle of the path on the nominal surface, W, m, (3,).
        posture: nominal posture over time.
        dt: control period, s.
        standing_out: how far the surface stands out beyond its nominal place, toward the robot, under the
            ways on which the pen is lifted, m.
    """
    path = trajectory(config.trajectory)
    approach = config.approach
    travel = approach.standoff + approach.depth if approach.contact else 0.0
    in_time, out_time = ramp_duration(travel, approach.speed), ramp_duration(travel, approach.retreat_speed)
    phases = config.phases
    slide = max(path.duration, posture.duration)
    durations = np.array(
        [phases.hover, phases.tare, in_time, phases.settle, slide, out_time, phases.hover_end]
    )
    ends = np.cumsum(durations)
    count = round(float(ends[-1]) / dt) + 1
    times = np.arange(count) * dt
    phase = np.minimum(np.searchsorted(ends, times + 1e-9, side="right"), len(ends) - 1)

    since_slide = times - ends[3]
    if approach.contact:
        phase[_lifting(path, since_slide)] = PHASES.index("lift")
    into, into_rate, into_bend = ramp(travel, approach.speed, times - ends[1])
    back, back_rate, back_bend = ramp(travel, approach.retreat_speed, times - ends[4])
    depth = -approach.standoff + into - back
    tip_depth = np.minimum(depth, 0.0)
    axis_speed, axis_bend = into_rate - back_rate, into_bend - back_bend
    tip_speed = axis_speed * (depth < 0.0)
    if path.lifts and approach.contact:
        # Lifted, tip and centre of gravity are as far out as if the robot had not pressed at all.
        part, rate, bend = path.lifted(since_slide)
        clear = approach.lift + standing_out
        way = approach.depth + clear
        depth, axis_speed, axis_bend = depth - way * part, axis_speed - way * rate, axis_bend - way * bend
        tip_depth, tip_speed = tip_depth - clear * part, tip_speed - clear * rate
    slide_time = np.clip(since_slide, 0.0, path.duration)
    sliding = np.isin(phase, [PHASES.index(name) for name in ("slide", "lift")])[:, None]
    uv, uv_rate, uv_bend = path.sample(slide_time)

    # The arm moves in the plane of the joints: it can give way to a wall, not to a floor or a ceiling.
    arm_reaches = float(np.hypot(*frame.contact[:2])) > _LEVEL
    sent = config.trajectory.feedforward
    velocity_sent, acceleration_sent = sent in ("velocity", "full"), sent == "full"
    a, plane = frame.contact, np.stack([frame.sliding_u, frame.sliding_v])
    # Where the centre of gravity is when the tip's ball just touches the middle of the path.
    home = center - a * posture.tip_radius - rot_z(frame.heading) @ posture.tip
    position = home + depth[:, None] * a + uv @ plane
    velocity = axis_speed[:, None] * a + (uv_rate * sliding) @ plane
    acceleration = axis_bend[:, None] * a + (uv_bend * sliding) @ plane
    coming_back = (phase == PHASES.index("lift")) & path.touching(since_slide)
    touching = np.isin(phase, [PHASES.index(name) for name in _TOUCHING]) | coming_back
    touching = touching * float(approach.contact)
    waiting = np.isin(phase, [PHASES.index(name) for name in _WAITING])
    # A clock that is held until the pen is back stands still in the lift, not in the slide that comes next.
    waiting[:-2] |= (phase[:-2] == PHASES.index("lift")) & waiting[2:]
    reference = Reference(
        position=position,
        velocity=velocity * velocity_sent,
        acceleration=acceleration * acceleration_sent,
        # The robot keeps its own heading; the tip link turns with the posture.
        heading=frame.heading + posture.tip_heading(since_slide),
        reach=np.full(count, posture.reach),
        joint_angles=posture.joint_angles(since_slide),
        vectoring_angles=posture.vectoring_angles(since_slide),
        contact_axis=np.tile(a, (count, 1)),
        tare=(phase == PHASES.index("tare")).astype(float),
        align=np.full(count, float(approach.contact and arm_reaches)),
        adapt=touching * float(arm_reaches),
        tip_position=center + tip_depth[:, None] * a + uv @ plane - a * posture.tip_radius,
        tip_velocity=tip_speed[:, None] * a + (uv_rate * sliding) @ plane,
        tip_acceleration=(uv_bend * sliding) @ plane,
        touch=touching,
        wait=waiting * float(approach.contact),
        sliding_axis=np.tile(frame.sliding_u, (count, 1)),
    )
    return Mission(times, reference, phase, frame, center + uv @ plane, approach.contact, phases.patience)


def _lifting(path: Trajectory, t: np.ndarray) -> np.ndarray:
    """Whether the pen leaves, is away or comes back at times t since the beginning of the slide, (k,)."""
    lifting = np.zeros(t.shape, dtype=bool)
    for leave, back in path.lifts:
        lifting |= (t >= leave) & (t < back + path.lift_time)
    return lifting
