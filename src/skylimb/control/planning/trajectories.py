"""Reference paths in the sliding plane: position, velocity and acceleration as functions of time.

A path lives in two coordinates (u, v) about the middle of the task, m; for the paper's board u is y, v is z.
Every path is twice continuously differentiable inside its duration and rests at its end points outside of it.

All timing is made from one primitive, a rate that grows smoothly from zero to one (`smooth_step`). A circle
turns its phase at such a rate; a line, a lawnmower pattern or waypoints are a sum of such steps, one a
change of velocity: straight at constant speed between the corners, round at them, at rest at both ends.
A drawing has its own timing, `skylimb.control.planning.pen_motion`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from skylimb.base.keys import refused
from skylimb.control.planning.drawing import Strokes, fitted, nearest_first
from skylimb.control.planning.drawing_sources import svg_strokes, text_strokes
from skylimb.control.planning.pen_motion import pen_motion
from skylimb.control.planning.smooth_step import STEEPEST, quintic, smooth_step
from skylimb.control.planning.trajectory_config import TrajectoryConfig
from skylimb.control.planning.user_path import USER, Samples, user_path

FINE = 0.09
"""Larger side below which a stroke of a drawing is fine, m: letters, dashes, small shapes."""

_SHORTEST_RAMP = 1e-9
"""A shorter ramp is none, s; rates over it would be no numbers."""


@dataclass(frozen=True)
class Trajectory:
    """A path on the clock.

    Attributes:
        duration: s.
        inside: (position, velocity, acceleration) at times within the duration.
        lifts: for each way without touch when the pen starts to leave and when it starts to come back, s.
        lift_time: how long leaving takes, and coming back, s; the path rests meanwhile.
        pressed: wanted normal force at times within the duration, N, (k,); None where the path has none.
        small: of each stroke of a drawing, whether it is smaller than `FINE`; none of any other path.
    """

    duration: float
    inside: Callable[[np.ndarray], Samples]
    lifts: tuple[tuple[float, float], ...] = ()
    lift_time: float = 0.0
    pressed: Callable[[np.ndarray], np.ndarray] | None = None
    small: tuple[bool, ...] = ()

    def sample(self, t: np.ndarray | float) -> Samples:
        """The path at times t; before the start and after the end it rests at its end points.

        Args:
            t: times in s, (k,).

        Returns:
            Position (k, 2) in m, velocity in m/s and acceleration in m/s^2, in the sliding plane (u, v).
        """
        t = np.asarray(t, dtype=float)
        position, velocity, acceleration = self.inside(np.clip(t, 0.0, self.duration))
        moving = ((t >= 0.0) & (t <= self.duration))[..., None]
        return position, velocity * moving, acceleration * moving

    def force(self, t: np.ndarray) -> np.ndarray:
        """Wanted normal force at times t (k,), s, in N, (k,); 0 where it is the controller's to say."""
        return np.zeros(t.shape) if self.pressed is None else self.pressed(np.clip(t, 0.0, self.duration))

    def fine(self, t: np.ndarray) -> np.ndarray:
        """1 at times t (k,), s, at which the stroke at hand is small, else 0; a lift goes to the next one."""
        if not self.small:
            return np.zeros(t.shape)
        stroke = np.searchsorted([back for _, back in self.lifts], t, side="right")
        return np.asarray(self.small, dtype=float)[stroke]

    def touching(self, t: np.ndarray | float) -> np.ndarray:
        """Whether the pen is wanted on the surface at times t (k,), s; always, except between two strokes.

        It turns false when the pen starts to leave and true when it starts to come back; for `lift_time`
        after either the path rests, so that the pen has time to do so.
        """
        t = np.asarray(t, dtype=float)
        touching = np.ones(t.shape, dtype=bool)
        for leave, back in self.lifts:
            touching &= (t < leave) | (t >= back)
        return touching

    def lifted(self, t: np.ndarray | float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """How far the pen is lifted, smoothly from 0 (on the surface) to 1 and back within `lift_time`.

        Args:
            t: times in s, (k,).

        Returns:
            The part of the lift, its rate in 1/s and its second derivative in 1/s^2, (k,) each.
        """
        t = np.asarray(t, dtype=float)
        part, rate, bend = np.zeros(t.shape), np.zeros(t.shape), np.zeros(t.shape)
        for moment, sign in [(m, s) for lift in self.lifts for m, s in zip(lift, (1.0, -1.0), strict=True)]:
            s = np.clip((t - moment) / self.lift_time, 0.0, 1.0)
            value, slope, curvature = quintic(s)
            part += sign * value
            rate += sign * slope / self.lift_time
            bend += sign * curvature / self.lift_time**2
        return part, rate, bend


def trajectory(config: TrajectoryConfig) -> Trajectory:
    """The path that a configuration describes."""
    path = _SHAPES[config.shape](config)
    if config.force is None or path.pressed is not None:
        return path
    low, high = config.force
    return replace(path, pressed=lambda t: low + (high - low) * t / max(path.duration, 1e-9))


def _hold(config: TrajectoryConfig) -> Trajectory:
    def inside(t: np.ndarray) -> Samples:
        zero = np.zeros((*t.shape, 2))
        return zero, zero, zero

    return Trajectory(config.duration, inside)


def _circle(config: TrajectoryConfig) -> Trajectory:
    phase, duration = _phase(config)

    def inside(t: np.ndarray) -> Samples:
        angle, rate, bend = phase(t)
        out = config.radius * np.concatenate([np.cos(angle), np.sin(angle)], axis=-1)
        along = config.radius * np.concatenate([-np.sin(angle), np.cos(angle)], axis=-1)
        return out, along * rate, along * bend - out * rate**2

    return Trajectory(duration, inside)


def _lemniscate(config: TrajectoryConfig) -> Trajectory:
    """Gerono's figure eight, u = a sin(phase), v = a sin(phase) cos(phase): twice as wide as high."""
    phase, duration = _phase(config)

    def inside(t: np.ndarray) -> Samples:
        angle, rate, bend = phase(t)
        position = config.radius * np.concatenate([np.sin(angle), 0.5 * np.sin(2 * angle)], axis=-1)
        first = config.radius * np.concatenate([np.cos(angle), np.cos(2 * angle)], axis=-1)
        second = config.radius * np.concatenate([-np.sin(angle), -2 * np.sin(2 * angle)], axis=-1)
        return position, first * rate, first * bend + second * rate**2

    return Trajectory(duration, inside)


def _line(config: TrajectoryConfig) -> Trajectory:
    half = 0.5 * config.length
    return _polyline(_turned(np.array([[-half, 0.0], [half, 0.0]]), config.angle), config)


def _lawnmower(config: TrajectoryConfig) -> Trajectory:
    half = 0.5 * config.length
    levels = (np.arange(config.strokes) - 0.5 * (config.strokes - 1)) * config.spacing
    ends = [
        (side * half, level)
        for i, level in enumerate(levels)
        for side in ((-1, 1) if i % 2 == 0 else (1, -1))
    ]
    return _polyline(_turned(np.array(ends), config.angle), config)


def _waypoints(config: TrajectoryConfig) -> Trajectory:
    return _polyline(np.array(config.waypoints, dtype=float), config)


def drawing_strokes(config: TrajectoryConfig) -> Strokes:
    """The lines of a drawing in the sliding plane, m, as they are to be drawn; with `force`, N, as widths.

    Raises:
        ConfigError: where the configuration describes no drawing, or the drawing cannot be had.
    """
    if config.shape != "drawing":
        raise refused(config, "shape", "is no drawing")
    drawn = (
        svg_strokes(config.sources[0], config.file) if config.file else text_strokes(config.text, config.font)
    )
    strokes = fitted(drawn, config.width, config.height)
    if config.center is not None:
        strokes = replace(strokes, lines=tuple(line + np.asarray(config.center) for line in strokes.lines))
    if config.order == "nearest":
        strokes = nearest_first(strokes)
    strokes = strokes.reversed() if config.direction < 0 else strokes
    return replace(strokes, widths=()) if config.force is None else strokes.pressed(*config.force)


def _drawing(config: TrajectoryConfig) -> Trajectory:
    strokes = drawing_strokes(config)
    motion = pen_motion(strokes, config.speed, config.acceleration, config.lift_time)
    parts = motion.position, motion.position.derivative(1), motion.position.derivative(2)

    def inside(t: np.ndarray) -> Samples:
        position, velocity, acceleration = (np.asarray(part(t))[..., :2] for part in parts)
        return position, velocity, acceleration

    pressed = None if config.force is None else lambda t: np.asarray(motion.position(t))[..., 2]
    small = tuple(bool(np.ptp(line, axis=0).max() < FINE) for line in strokes.lines)
    return Trajectory(motion.duration, inside, motion.lifts, config.lift_time, pressed, small)


def _user(config: TrajectoryConfig) -> Trajectory:
    inside = user_path(
        config.file, config.function, config.duration, config.direction, config.speed, config.acceleration
    )
    return Trajectory(config.duration, inside)


_SHAPES: dict[str, Callable[[TrajectoryConfig], Trajectory]] = {
    "hold": _hold,
    "line": _line,
    "circle": _circle,
    "lemniscate": _lemniscate,
    "lawnmower": _lawnmower,
    "waypoints": _waypoints,
    "drawing": _drawing,
    USER: _user,
}


def _turned(points: np.ndarray, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def _phase(config: TrajectoryConfig) -> tuple[Callable[[np.ndarray], Samples], float]:
    """Angle, its rate and its second derivative over time, each (k, 1), and how long it takes."""
    full_rate = config.direction * 2.0 * math.pi / config.period
    laps_time = config.laps * config.period

    def phase(t: np.ndarray) -> Samples:
        if config.ramp < _SHORTEST_RAMP:
            turned = config.start_angle + full_rate * t[..., None]
            return turned, np.full_like(turned, full_rate), np.zeros_like(turned)
        # Up to speed at 0, down again one lap time later: each ramp covers half its time's worth of angle.
        up, down = smooth_step(t, config.ramp), smooth_step(t - laps_time, config.ramp)
        angle, rate, bend = (full_rate * (a - b)[..., None] for a, b in zip(up, down, strict=True))
        return config.start_angle + angle, rate, bend

    return phase, laps_time + config.ramp


def _polyline(corners: np.ndarray, config: TrajectoryConfig) -> Trajectory:
    """Straight from corner to corner (n, 2) at constant speed, smooth at each corner, at rest at both ends.

    Every change of velocity takes the same `blend` time, chosen so that the sharpest keeps to the allowed
    acceleration; a side too short for that is flown more slowly, so that two changes never overlap.
    """
    if config.direction < 0:
        corners = corners[::-1]
    sides = np.diff(corners, axis=0)
    lengths = np.linalg.norm(sides, axis=1)
    at_rest = np.zeros((1, 2))
    velocities = np.diff(np.concatenate([at_rest, config.speed * sides / lengths[:, None], at_rest]), axis=0)
    blend = STEEPEST * float(np.linalg.norm(velocities, axis=1).max()) / config.acceleration
    times = np.maximum(lengths / config.speed, blend)
    velocities = sides / times[:, None]
    changes = np.diff(np.concatenate([at_rest, velocities, at_rest]), axis=0)
    starts = np.concatenate([[0.0], np.cumsum(times)])

    def inside(t: np.ndarray) -> Samples:
        way, rate, bend = (part @ changes for part in smooth_step(t[..., None] - starts, blend))
        return corners[0] + way, rate, bend

    return Trajectory(float(starts[-1]) + blend, inside)
