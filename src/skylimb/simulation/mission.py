"""The paper's flight as a table: what the controller is asked to do at every tick.

Phases: hover, tare (the observer's bias is averaged), approach along the contact axis, settle in contact,
slide along the path, retreat, hover. Between two strokes of a drawing the slide is interrupted by a lift: the
pen leaves, goes to the next stroke and comes back. Phases follow the clock alone, so the whole table is known
before take-off.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from skylimb.config import require_non_negative, require_positive, require_range
from skylimb.control.records import Reference
from skylimb.errors import ConfigError
from skylimb.planning.trajectories import Trajectory, TrajectoryConfig, trajectory
from skylimb.simulation.surfaces.placement import base_rotation
from skylimb.spatial import rot_z

PHASES = ("hover", "tare", "approach", "settle", "slide", "retreat", "hover_end", "lift")
_TOUCHING = ("approach", "settle", "slide")
"""Phases in which the tip is to touch, or to go on until it does; in a lift from the way back on."""

_WAITING = ("settle", "slide")
"""Phases that make no sense without touch."""

_RAMP = 0.5
"""Time in s over which approach and retreat reach their speed."""
_LEVEL = 0.5
"""Level part of a contact axis above which the arm can reach along it."""


@dataclass(frozen=True)
class PhaseConfig:
    """Lengths of the phases that wait, s; approach, slide and retreat last as long as their paths.

    Attributes:
        hover: s.
        tare: s.
        settle: s.
        hover_end: s.
        patience: how many times the mission's time a flight may take whose controller holds the mission's
            clock back.
    """

    hover: float = 3.0
    tare: float = 4.0
    settle: float = 5.0
    hover_end: float = 3.0
    patience: float = 2.5

    def __post_init__(self) -> None:
        require_range("phases", "patience", self.patience, 1.0, 20.0)
        for name in ("hover", "tare", "settle", "hover_end"):
            require_non_negative("phases", name, getattr(self, name), "s")


@dataclass(frozen=True)
class ApproachConfig:
    """How the robot comes to the surface and leaves it.

    Attributes:
        depth: how far beyond the surface the undisturbed tip would stand, at the middle of the path, m.
        standoff: gap between tip and surface before the approach, at the middle of the path, m.
        speed: of the approach, m/s.
        retreat_speed: m/s.
        lift: least gap between tip and surface on the way from one stroke of a drawing to the next, m.
        contact: false to stay at the standoff all the while, for a free flight.
    """

    contact: bool = True
    depth: float = 0.18
    standoff: float = 0.10
    speed: float = 0.05
    retreat_speed: float = 0.10
    lift: float = 0.05

    def __post_init__(self) -> None:
        require_range("approach", "depth", self.depth, 0.0, 0.6, "m")
        require_range("approach", "standoff", self.standoff, 0.0, 2.0, "m")
        require_range("approach", "lift", self.lift, 0.0, 1.0, "m")
        require_positive("approach", "speed", self.speed, "m/s")
        require_positive("approach", "retreat_speed", self.retreat_speed, "m/s")


@dataclass(frozen=True)
class ContactFrame:
    """Axes of the task, right-handed unit vectors in W: the contact axis and two sliding axes."""

    contact: np.ndarray
    sliding_u: np.ndarray
    sliding_v: np.ndarray

    @property
    def heading(self) -> float:
        """Heading of the contact axis about z, rad; zero when it is vertical."""
        return (
            float(np.arctan2(self.contact[1], self.contact[0])) if np.hypot(*self.contact[:2]) > 1e-6 else 0.0
        )


def contact_frame(axis: tuple[float, float, float]) -> ContactFrame:
    """The frame of a contact axis, as a surface has it.

    For x it is the paper's, u = y and v = z; a ceiling has u = y and v = -x.

    Raises:
        ConfigError: when the axis is no unit vector.
    """
    if not abs(float(np.linalg.norm(axis)) - 1.0) < 1e-3:
        raise ConfigError(
            f"contact_axis = {list(axis)} must be a unit vector; the paper's is [1.0, 0.0, 0.0]"
        )
    return ContactFrame(*base_rotation(axis).T)


@dataclass(frozen=True)
class MissionConfig:
    """What to fly: phases, approach and path."""

    phases: PhaseConfig = field(default_factory=PhaseConfig)
    approach: ApproachConfig = field(default_factory=ApproachConfig)
    trajectory: TrajectoryConfig = field(default_factory=TrajectoryConfig)


@dataclass(frozen=True)
class PosturePlan:
    """The nominal posture over time, counted from the beginning of the slide.

    Attributes:
        reach: r_ref, m.
        tip: from the centre of gravity to the tip in the level robot whose tip link points along x, m, (3,).
        tip_radius: m.
        duration: time that the plan takes, s; 0 for a posture that stays.
        joint_angles: times (k,) -> q (k, nq), rad.
        vectoring_angles: times (k,) -> psi (k, nv), rad.
        tip_heading: times (k,) -> yaw of the tip link in C less that of the first posture, (k,), rad.
    """

    reach: float
    tip: np.ndarray
    tip_radius: float
    duration: float
    joint_angles: Callable[[np.ndarray], np.ndarray]
    vectoring_angles: Callable[[np.ndarray], np.ndarray]
    tip_heading: Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Mission:
    """The table of a flight.

    Attributes:
        times: of the ticks, s, (k,).
        reference: every entry with the ticks as first dimension.
        phase: index into `PHASES`, (k,).
        frame: axes of the task.
        tip_path: where the undisturbed tip would go on the nominal surface, W, m, (k, 3).
        contact: whether the mission touches anything.
        patience: times the mission's time that a flight may take.
    """

    times: np.ndarray
    reference: Reference
    phase: np.ndarray
    frame: ContactFrame
    tip_path: np.ndarray
    contact: bool
    patience: float = 1.0

    def flight_times(self, paced: bool) -> np.ndarray:
        """Times since take-off of every tick that a flight may have, s; a paced one may take longer."""
        if not paced:
            return self.times
        count = math.ceil(self.patience * len(self.times))
        return np.arange(count) * (self.times[1] - self.times[0])

    def along(self, clock: np.ndarray) -> Mission:
        """The mission as it was flown.

        Args:
            clock: where on the mission's own clock each tick of the flight was, in ticks, (k,).
        """
        last = len(self.times) - 1
        here = np.minimum(np.floor(clock).astype(int), last)
        there = np.minimum(here + 1, last)
        part = clock - here

        def between(values: np.ndarray) -> np.ndarray:
            weight = part.reshape(-1, *(1,) * (values.ndim - 1))
            return values[here] + weight * (values[there] - values[here])

        times = np.arange(len(clock)) * (self.times[1] - self.times[0])
        reference = Reference(*(between(entry) for entry in self.reference))
        return dataclasses.replace(
            self, times=times, reference=reference, phase=self.phase[here], tip_path=between(self.tip_path)
        )


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


def ramp_duration(distance: float, speed: float) -> float:
    """Time in s that `ramp` takes; a short way is gone at a lower speed."""
    speed = min(speed, distance / _RAMP) if distance > 0.0 else speed
    return distance / speed + _RAMP if distance > 0.0 else 0.0


def ramp(distance: float, speed: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Way, speed and acceleration at times t: a trapezoid of speed from t = 0, still before and after."""
    if distance <= 0.0:
        return np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    speed = min(speed, distance / _RAMP)
    bend = speed / _RAMP
    total = ramp_duration(distance, speed)
    t = np.clip(t, 0.0, total)
    rising, falling = t < _RAMP, t > total - _RAMP
    left = total - t
    way = np.where(
        rising,
        0.5 * bend * t**2,
        np.where(falling, distance - 0.5 * bend * left**2, speed * (t - 0.5 * _RAMP)),
    )
    rate = np.where(rising, bend * t, np.where(falling, bend * left, speed))
    inside = (t > 0.0) & (t < total)
    return way, rate, np.where(rising & inside, bend, np.where(falling & inside, -bend, 0.0))
