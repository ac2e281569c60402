"""The paper's flight laid on a clock: the reference of every tick.

Phases: hover, tare (the observer's bias is averaged), approach along the contact axis, settle in contact,
slide along the path, retreat, hover. Between two strokes of a drawing the slide is interrupted by a lift: the
pen leaves, goes to the next stroke and comes back. Phases follow the clock alone, so the whole table is known
before take-off.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skylimb.base.rotations import rot_z
from skylimb.control.missions.configuration import ApproachConfig, MissionConfig
from skylimb.control.missions.excitation import ExcitationConfig, excitation
from skylimb.control.missions.frame import ContactFrame
from skylimb.control.missions.length import tick_count
from skylimb.control.missions.mission import PHASES, Mission
from skylimb.control.missions.posture import PosturePlan
from skylimb.control.missions.ramp import ramp, ramp_duration
from skylimb.control.missions.reference import Reference
from skylimb.control.missions.wrap import Along, require_upright, wrapped, wrapped_points
from skylimb.control.planning.trajectories import Trajectory, trajectory

_TOUCHING = ("approach", "settle", "slide")
"""Phases in which the tip is to touch, or to go on until it does; in a lift from the way back on."""

_WAITING = ("settle", "slide")
"""Phases that make no sense without touch."""

_LASTS = (
    "phases.hover", "phases.tare", "approach.speed", "phases.settle", "trajectory.period and trajectory.laps",
    "approach.retreat_speed", "phases.hover_end",
)  # fmt: skip
"""Keys that say how long each phase of a mission lasts."""


class StandingOut(NamedTuple):
    """What stands out toward the robot under the ways on which the pen is lifted, along the contact axis.

    Attributes:
        nominal: how far the surface does at most, beyond its nominal place, m.
        ways: for each way how far it does beyond its own place and slope where the pen left it, m; empty
            where nobody knows, and a lift goes by the nominal place alone.
    """

    nominal: float = 0.0
    ways: tuple[float, ...] = ()


NOTHING = StandingOut()
"""What stands out where nobody has looked."""

_LEVEL = 0.5
"""Level part of a contact axis above which the arm can reach along it."""


def plan_mission(
    config: MissionConfig,
    frame: ContactFrame,
    center: np.ndarray,
    posture: PosturePlan,
    dt: float,
    standing_out: StandingOut = NOTHING,
) -> Mission:
    """Lay the phases on the clock.

    Args:
        config: phases, approach and path.
        frame: axes of the task.
        center: middle of the path on the nominal surface, W, m, (3,).
        posture: nominal posture over time.
        dt: control period, s.
        standing_out: what the pen has to pass over from stroke to stroke.

    Raises:
        ConfigError: when the mission lasts too long for its log to fit into memory.
    """
    path = trajectory(config.trajectory)
    clock = _lay_on_clock(config, path, posture, dt)
    axis = _along_axis(config, path, clock, standing_out.nominal)
    touching, waiting = _touching_and_waiting(path, clock)
    contact, count = float(config.approach.contact), len(clock.times)
    sliding = clock.is_in("slide", "lift")[:, None]
    uv, uv_rate, uv_bend = path.sample(np.clip(clock.since_slide, 0.0, path.duration))

    # The arm moves in the plane of the joints: it can give way to a wall, not to a floor or a ceiling.
    arm_reaches = float(np.hypot(*frame.contact[:2])) > _LEVEL
    sent = config.trajectory.feedforward
    velocity_sent, acceleration_sent = sent in ("velocity", "full"), sent == "full"
    a, plane = frame.contact, np.stack([frame.sliding_u, frame.sliding_v])
    # Where the centre of gravity is when the tip's ball just touches the middle of the path.
    heading = frame.heading + config.approach.heading
    home = center - a * posture.tip_radius - rot_z(heading) @ posture.tip
    position = home + axis.depth[:, None] * a + uv @ plane
    velocity = axis.speed[:, None] * a + (uv_rate * sliding) @ plane
    acceleration = axis.acceleration[:, None] * a + (uv_bend * sliding) @ plane
    reference = Reference(
        position=position,
        velocity=velocity * velocity_sent,
        acceleration=acceleration * acceleration_sent,
        # The robot keeps its own heading; the tool turns with the posture.
        heading=heading + posture.tip_heading(clock.since_slide),
        reach=np.full(count, posture.reach),
        joint_angles=posture.joint_angles(clock.since_slide),
        vectoring_angles=posture.vectoring_angles(clock.since_slide),
        contact_axis=np.tile(a, (count, 1)),
        tare=clock.is_in("tare").astype(float),
        align=np.full(count, contact * arm_reaches),
        adapt=touching * contact * float(arm_reaches),
        tip_position=center + axis.tip_depth[:, None] * a + uv @ plane - a * posture.tip_radius,
        tip_velocity=axis.tip_speed[:, None] * a + (uv_rate * sliding) @ plane,
        tip_acceleration=(uv_bend * sliding) @ plane,
        touch=touching * contact,
        wait=waiting * contact,
        sliding_axis=np.tile(frame.sliding_u, (count, 1)),
        force=path.force(clock.since_slide) * contact,
        clearance=_clearance(config, path, clock, standing_out.ways),
        fine=path.fine(clock.since_slide) * contact,
    )
    if not config.excitation.empty:
        duration = max(path.duration, posture.duration)
        reference = _excited(reference, config.excitation, clock.since_slide, duration)
    path_points = center + uv @ plane
    if config.wrap.radius is not None:
        require_upright(frame)
        along = Along(uv[:, 0], uv_rate[:, 0] * sliding[:, 0], uv_bend[:, 0] * sliding[:, 0])
        reference = wrapped(reference, frame, center, config.wrap.radius, along)
        path_points = wrapped_points(path_points, frame, center, config.wrap.radius, uv[:, 0])
    patience = config.phases.patience
    touches = config.approach.contact
    return Mission(clock.times, dt, reference, clock.phase, frame, path_points, touches, patience)


@dataclass(frozen=True)
class _Clock:
    """Every tick of the mission, (k,).

    Attributes:
        times: since take-off, s.
        phase: index of `PHASES`.
        since_approach: time since the approach began, s; negative before it.
        since_slide: the same for the slide.
        since_retreat: the same for the retreat.
    """

    times: np.ndarray
    phase: np.ndarray
    since_approach: np.ndarray
    since_slide: np.ndarray
    since_retreat: np.ndarray

    def is_in(self, *names: str) -> np.ndarray:
        """Whether a tick is in one of these phases, (k,)."""
        return np.isin(self.phase, [PHASES.index(name) for name in names])


class _Axis(NamedTuple):
    """References along the contact axis, (k,); 0 where the tip just touches the nominal surface.

    Attributes:
        depth: of the centre of gravity's reference, m.
        speed: its rate, m/s.
        acceleration: its second derivative, m/s^2.
        tip_depth: of the pen's reference, m; it ends on the surface.
        tip_speed: its rate, m/s.
    """

    depth: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    tip_depth: np.ndarray
    tip_speed: np.ndarray


def _excited(
    reference: Reference, config: ExcitationConfig, since_slide: np.ndarray, duration: float
) -> Reference:
    """The references with the sines on top, for centre of gravity and tip alike."""
    extra = excitation(config, since_slide, duration)
    return reference._replace(
        position=reference.position + extra.position,
        velocity=reference.velocity + extra.velocity,
        acceleration=reference.acceleration + extra.acceleration,
        heading=reference.heading + extra.heading,
        tip_position=reference.tip_position + extra.position,
        tip_velocity=reference.tip_velocity + extra.velocity,
        tip_acceleration=reference.tip_acceleration + extra.acceleration,
    )


def _travel(approach: ApproachConfig) -> float:
    """Way of the approach along the contact axis, m."""
    return approach.standoff + approach.depth if approach.contact else 0.0


def _lay_on_clock(config: MissionConfig, path: Trajectory, posture: PosturePlan, dt: float) -> _Clock:
    """The phases one after another, each as long as it takes."""
    approach, phases, travel = config.approach, config.phases, _travel(config.approach)
    durations = (
        phases.hover,
        phases.tare,
        ramp_duration(travel, approach.speed),
        phases.settle,
        max(path.duration, posture.duration),
        ramp_duration(travel, approach.retreat_speed),
        phases.hover_end,
    )
    ends = np.cumsum(durations)
    longest = int(np.argmax(durations))
    most = f"the mission, most of it its {PHASES[longest]} (see {_LASTS[longest]}),"
    times = np.arange(tick_count(float(ends[-1]), dt, most)) * dt
    phase = np.minimum(np.searchsorted(ends, times + 1e-9, side="right"), len(ends) - 1)
    since_slide = times - ends[3]
    if approach.contact:
        phase[_lifting(path, since_slide)] = PHASES.index("lift")
    return _Clock(times, phase, times - ends[1], since_slide, times - ends[4])


def _along_axis(config: MissionConfig, path: Trajectory, clock: _Clock, standing_out: float) -> _Axis:
    """Toward the surface in the approach, away from it in the retreat and in every lift."""
    approach, travel = config.approach, _travel(config.approach)
    into, into_rate, into_bend = ramp(travel, approach.speed, clock.since_approach)
    back, back_rate, back_bend = ramp(travel, approach.retreat_speed, clock.since_retreat)
    depth = -approach.standoff + into - back
    speed, bend = into_rate - back_rate, into_bend - back_bend
    tip_depth, tip_speed = np.minimum(depth, 0.0), speed * (depth < 0.0)
    if path.lifts and approach.contact:
        # Lifted, tip and centre of gravity are as far out as if the robot had not pressed at all.
        part, rate, part_bend = path.lifted(clock.since_slide)
        clear = approach.lift + standing_out
        way = approach.depth + clear
        depth, speed, bend = depth - way * part, speed - way * rate, bend - way * part_bend
        tip_depth, tip_speed = tip_depth - clear * part, tip_speed - clear * rate
    return _Axis(depth, speed, bend, tip_depth, tip_speed)


def _touching_and_waiting(path: Trajectory, clock: _Clock) -> tuple[np.ndarray, np.ndarray]:
    """Whether the tip is to touch, and whether the clock may stand still until it does, (k,)."""
    coming_back = clock.is_in("lift") & path.touching(clock.since_slide)
    touching = clock.is_in(*_TOUCHING) | coming_back
    waiting = clock.is_in(*_WAITING)
    # A clock that is held until the pen is back stands still in the lift, not in the slide that comes next.
    waiting[:-2] |= clock.is_in("lift")[:-2] & waiting[2:]
    return touching, waiting


def _clearance(config: MissionConfig, path: Trajectory, clock: _Clock, ways: tuple[float, ...]) -> np.ndarray:
    """What a lifted pen keeps from a surface that goes on as where it left, m, (k,); 0 where not known."""
    clearance = np.zeros(len(clock.times))
    # Around a post no surface goes on along one axis.
    if ways and config.approach.contact and config.wrap.radius is None:
        for lift, way in zip(_lifts(path, clock.since_slide), ways, strict=True):
            clearance[lift] = config.approach.lift + way
    return clearance


def _lifting(path: Trajectory, t: np.ndarray) -> np.ndarray:
    """Whether the pen leaves, is away or comes back at times t since the beginning of the slide, (k,)."""
    return np.any([np.zeros(t.shape, dtype=bool), *_lifts(path, t)], axis=0)


def _lifts(path: Trajectory, t: np.ndarray) -> list[np.ndarray]:
    """The same for each way from stroke to stroke."""
    return [(t >= leave) & (t < back + path.lift_time) for leave, back in path.lifts]
