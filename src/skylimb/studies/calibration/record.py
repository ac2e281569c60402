"""A flight as an estimator wants it: frames, angles and thrusts, in pieces in which nothing touches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from skylimb.analysis.recording.run import Run
from skylimb.robots.model import Robot
from skylimb.studies.calibration.log import (
    COMMAND,
    JOINTS,
    POSITION,
    QUATERNION,
    VECTORING,
    columns_of,
    free_pieces,
    fresh_frames,
    require_believable,
)
from skylimb.studies.calibration.mechanics import mechanics
from skylimb.studies.calibration.motors import followed
from skylimb.studies.calibration.smoothing import smoothed
from skylimb.studies.calibration.steps import Steps

_LONGEST_STEP = 0.0101
"""Longest step over which the robot's motion is integrated at once, s, unless a tick takes longer."""

_MOST_REGULAR = 0.95
"""Part of the frames that must keep step with the ticks; the others are not used then."""


@dataclass(frozen=True)
class Record:
    """A flight without contact, or its parts without.

    Attributes:
        robot: as it is described.
        dt: control period, s.
        stride: ticks from one frame of the motion capture to the next, which are one step.
        pieces: first and last tick (not included) of every part.
        position: measured root, W, m, (k, 3).
        attitude: measured root, (k, 3, 3).
        fresh: whether the measurement is a new frame, (k,).
        angles: measured joint and vectoring angles, smoothed, rad, (k, nq + nv).
        rates: of them, rad/s.
        command: commanded thrusts, N, (k, n).
        flat: mechanics at every tick, packed.
        wheels: spin J Omega of every rotor over the root of its thrust, N m s / sqrt(N), (n,); zeros where
            the flight's rotors have no inertia.
        unfollowed: time that is not used because motors could not follow, s; see `followed`.
    """

    robot: Robot
    dt: float
    stride: int
    pieces: tuple[tuple[int, int], ...]
    position: np.ndarray
    attitude: np.ndarray
    fresh: np.ndarray
    angles: np.ndarray
    rates: np.ndarray
    command: np.ndarray
    flat: np.ndarray
    wheels: np.ndarray
    unfollowed: float

    @property
    def step(self) -> float:
        """Time of a step, s."""
        return self.stride * self.dt

    @property
    def duration(self) -> float:
        """Time that is used, s."""
        return float(sum(end - begin for begin, end in self.pieces)) * self.dt

    @property
    def frames(self) -> np.ndarray:
        """Ticks of the frames that are used."""
        used = np.concatenate([np.arange(*piece) for piece in self.pieces])
        return used[self.fresh[used]]

    def roots(self, lag: float) -> tuple[np.ndarray, np.ndarray]:
        """Roots of the thrusts at every tick, which lag as speeds do, sqrt(N), (k, n); also by the lag."""
        a = float(np.exp(-self.dt / lag))
        command = _root(self.command)
        first, beside = command[:1], command - command[:1]
        # w_{k+1} = a w_k + (1 - a) sqrt(command_k), from rest at the first command.
        moved = np.asarray(lfilter([0.0, 1.0 - a], [1.0, -a], beside, axis=0))
        by_a = np.asarray(lfilter([0.0, 1.0], [1.0, -a], moved - beside, axis=0))
        return first + moved, by_a * a * self.dt / lag**2

    def steps(self, piece: tuple[int, int], lag: float, latency: float, chord: bool = False) -> Steps:
        """What is known of every step of a piece, for these values of lag and latency (s).

        Args:
            piece: first and last tick (not included).
            lag: of the rotors, s.
            latency: of the frames, s.
            chord: whether between two ticks thrusts decay, and not their roots; both agree at the ticks.
                Then the derivatives by the lag are not exact.
        """
        ticks = np.arange(piece[0], piece[1], self.stride)
        at, step = ticks * self.dt - latency, self.step
        middle, middle_slope = self._between(at + 0.5 * step)
        start, start_slope = self._between(at)
        low, high = self._integrals(at, lag, chord), self._integrals(at + step, lag, chord)
        mean = (high.once - low.once) / step
        early = (high.twice - low.twice - step * low.once) / (0.5 * step**2)
        return Steps(
            middle=middle,
            middle_rate=-middle_slope,
            cog=start[:, 0:3],
            cog_rate=-start_slope[:, 0:3],
            thrusts=mean[0],
            thrusts_by=np.concatenate([mean[1], -mean[2]], axis=1),
            early=early[0],
            early_by=np.concatenate([early[1], -early[2]], axis=1),
            position=self.position[ticks],
            attitude=self.attitude[ticks].reshape(-1, 9),
            fresh=self.fresh[ticks, None].astype(float),
        )

    def _between(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mechanics at any times, between two ticks in a straight line, and their slope."""
        where = np.clip(times / self.dt, 0.0, len(self.flat) - 1.001)
        tick = np.floor(where).astype(int)
        part = (where - tick)[:, None]
        step = self.flat[tick + 1] - self.flat[tick]
        return self.flat[tick] + part * step, step / self.dt

    def _integrals(self, times: np.ndarray, lag: float, chord: bool) -> _Integrals:
        """The thrusts' first and second integral up to any times, and their derivatives by lag and time."""
        roots, away_lag = self.roots(lag)
        where = np.clip(times / self.dt, 0.0, len(roots) - 1e-9)
        tick = np.floor(where).astype(int)
        command = _root(self.command)
        away = roots - command
        left = float(np.exp(-self.dt / lag)) if chord else None
        whole = _within(np.full((len(roots), 1), self.dt), lag, command, away, away_lag, left)
        # At the beginning of every tick: what all ticks before it have brought.
        once = _before(whole.once[:2])
        twice = _before(whole.twice[:2] + self.dt * once)
        s = ((where - tick) * self.dt)[:, None]
        part = _within(s, lag, command[tick], away[tick], away_lag[tick], left)
        once, twice = once[:, tick], twice[:, tick]
        first = np.concatenate([once + part.once[:2], part.once[2:]])
        second = np.concatenate([twice + once * s + part.twice[:2], first[:1]])
        return _Integrals(first, second)


class _Integrals(NamedTuple):
    """Integrals of the thrusts, each with its derivatives by lag and time: (3, k, n)."""

    once: np.ndarray
    twice: np.ndarray


def _within(
    s: np.ndarray,
    lag: float,
    command: np.ndarray,
    away: np.ndarray,
    away_lag: np.ndarray,
    left: float | None,
) -> _Integrals:
    """Integrals over the first s seconds of a tick, of thrusts (command + away e^(-s / lag))^2.

    With what is left of e^(-s / lag) after a tick, its square is the chord between both ends.
    """
    even = _decaying(s, lag, command**2, 2.0 * command * away, 2.0 * command * away_lag)
    # The square decays twice as fast, and so by half of the lag.
    square = _decaying(s, 0.5 * lag, 0.0 * away, away**2, 4.0 * away * away_lag)
    if left is not None:
        square = _decaying(s, lag, -left * away**2, (1.0 + left) * away**2, 0.0 * away)
    halves = np.array([1.0, 0.5, 1.0])[:, None, None]
    return _Integrals(*(a + halves * b for a, b in zip(even, square, strict=True)))


def _decaying(
    s: np.ndarray, lag: float, command: np.ndarray, away: np.ndarray, away_lag: np.ndarray
) -> _Integrals:
    """Integrals over the first s seconds of command + away e^(-s / lag)."""
    decay = np.exp(-s / lag)
    once = lag * (1.0 - decay)
    once_lag = (1.0 - decay) - (s / lag) * decay
    twice, twice_lag = lag * (s - once), (s - once) - lag * once_lag
    first = [command * s + away * once, away_lag * once + away * once_lag, command + away * decay]
    second = [0.5 * command * s**2 + away * twice, away_lag * twice + away * twice_lag, first[0]]
    return _Integrals(np.stack(first), np.stack(second))


def _root(thrusts: np.ndarray) -> np.ndarray:
    """The root of thrusts, which goes with the rotors' speeds, sqrt(N)."""
    return np.sqrt(np.maximum(thrusts, 0.0))


def _before(parts: np.ndarray) -> np.ndarray:
    """Sum of all rows before each row, along the second axis."""
    return np.cumsum(parts, axis=1) - parts


def record_of(run: Run, robot: Robot) -> Record:
    """The parts of a run's log in which the robot flew freely.

    Raises:
        ConfigError: naming what the log lacks, or what is wrong with the flight.
    """
    columns, dt = columns_of(run, robot)
    fresh = fresh_frames(columns, dt)
    require_believable(run, robot, dt)
    follows = followed(columns[COMMAND], dt, robot) | _idle(run)
    pieces = free_pieces(run, dt, follows)
    # Where there is no frame, any pose will do.
    position = np.where(fresh[:, None], columns[POSITION], 0.0)
    quaternion = np.where(fresh[:, None], columns[QUATERNION], [1.0, 0.0, 0.0, 0.0])
    encoders = np.concatenate([columns[JOINTS], columns[VECTORING]], axis=1)
    used = np.concatenate([np.arange(*piece) for piece in pieces])
    angles, rates = smoothed(encoders, used, dt)
    stride, fresh = _in_step(fresh, dt)
    return Record(
        robot,
        dt,
        stride,
        # Each piece from its first frame on.
        tuple((begin + int(np.argmax(fresh[begin:end])), end - stride) for begin, end in pieces),
        position,
        Rotation.from_quat(quaternion, scalar_first=True).as_matrix(),
        fresh,
        angles,
        rates,
        columns[COMMAND],
        mechanics(robot, angles, rates),
        _wheels(run, robot),
        float(np.count_nonzero(~follows)) * dt,
    )


def _wheels(run: Run, robot: Robot) -> np.ndarray:
    """Of the rotors, as the robot's file describes them; a simulation may take their inertia away."""
    inertias = np.array([0.0 if _idle(run) else rotor.inertia or 0.0 for rotor in robot.description.rotors])
    factors = np.array([rotor.thrust_factor or np.inf for rotor in robot.description.rotors])
    return np.array([rotor.spin for rotor in robot.description.rotors]) * inertias / np.sqrt(factors)


def _idle(run: Run) -> bool:
    """Whether the flight's rotors have no inertia, and so follow anything."""
    return run.tables.get("plant", {}).get("rotors") == "thrust"


def _in_step(fresh: np.ndarray, dt: float) -> tuple[int, np.ndarray]:
    """Ticks from frame to frame, and the frames that keep step with them; 1 and all where they do not."""
    frames = np.flatnonzero(fresh)
    spacing = int(np.median(np.diff(frames)))
    first = np.bincount(frames % spacing).argmax()
    regular = frames[frames % spacing == first]
    if len(regular) < _MOST_REGULAR * len(frames) or spacing * dt > _LONGEST_STEP:
        return 1, fresh
    kept = np.zeros_like(fresh)
    kept[regular] = True
    return spacing, kept
