"""What a log holds for a replay: measurements, commands and the mission's clock; and what it lacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from skylimb.base.errors import ConfigError
from skylimb.control.estimation.records import ABSENT, Imu, Measurement
from skylimb.control.loop.flight import MISSION_TIME
from skylimb.control.loop.vehicle import MEASURED
from skylimb.control.missions.clock import Clock, limited_pace
from skylimb.control.needs import PACE
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.records import Command
from skylimb.flight.replay.rates import angular_velocities, velocities
from skylimb.robots.model import Robot

HELD = "tick_held"
"""Signal of a flight on the wall clock: 1 where the command of the tick before was held."""

_WHOLE = 1e-6
"""Seconds by which a tick's stamp may be off its place before the log is sampled anew."""


SLOWEST = 10.0
"""Hz below which nothing can be replayed: between two rows of it a robot may tip over."""


@dataclass(frozen=True)
class Recorded:
    """What was measured and commanded at every tick.

    Attributes:
        times: since the log's beginning, s, (k,).
        measurement: every entry with the ticks as first dimension.
        command: likewise; thrusts are NaN where the log has none.
        clock: where the flight was on its mission's clock, each (k,).
        held: whether the controller was not asked and its command of the tick before held, (k,).
        missing: what the log lacks and what stands in its place, one line each.
    """

    times: np.ndarray
    measurement: Measurement
    command: Command
    clock: Clock
    held: np.ndarray
    missing: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.times)

    def measured_at(self, k: int) -> Measurement:
        """The measurement of a tick."""
        *others, imu = self.measurement
        felt = imu and Imu(*(part[k].copy() for part in imu))
        return Measurement(*(part[k].copy() for part in others), imu=felt)


def require_rising(times: np.ndarray) -> None:
    """Check that every row of a log is later than the one before.

    Raises:
        ConfigError: naming the first that is not, or whose time is no number.
    """
    (wrong,) = np.nonzero(~(np.diff(times) > 0.0))
    if len(wrong):
        before, after = times[wrong[0]], times[wrong[0] + 1]
        raise ConfigError(f"the time of the log does not rise: {after:g} s comes after {before:g} s")


def sampled(log: xr.Dataset, period: float) -> tuple[xr.Dataset, tuple[str, ...]]:
    """The log at every control tick: at each the last row before it, so that nothing looks into the future.

    Args:
        log: of signals over `time`, s.
        period: control period, s.

    Returns:
        The log itself where its rows are the ticks; and what was done, in a line.

    Raises:
        ConfigError: when the log has less than two rows, its time does not rise, or its rate is too low.
    """
    times = np.asarray(log.time.values, dtype=float)
    if len(times) < 2:
        raise ConfigError(f"a log with {len(times)} of the two rows that it takes cannot be replayed")
    require_rising(times)
    rate = 1.0 / float(np.median(np.diff(times)))
    if rate < SLOWEST:
        raise ConfigError(
            f"a log with rows at {rate:.3g} Hz cannot be replayed: at least {SLOWEST:g} Hz; "
            "is its time in seconds?"
        )
    first = times[0]
    if np.all(abs(times - first - np.arange(len(times)) * period) < _WHOLE):
        return log, ()
    ticks = np.arange(int((times[-1] - first) / period + 1e-9) + 1) * period
    rows = np.searchsorted(times, first + ticks + 1e-9, side="right") - 1
    said = f"rows at {rate:.4g} Hz: at each {1.0 / period:g} Hz tick the last one"
    return log.isel(time=rows).assign_coords(time=("time", ticks, log.time.attrs)), (said,)


def recorded(log: xr.Dataset, robot: Robot, period: float, vectoring: str) -> Recorded:
    """Measurements, commands and clock of a log whose rows are ticks; see `sampled`.

    Args:
        log: of a flight of this robot.
        robot: gives the sizes, and the angles that stand in where none were recorded.
        period: control period, s.
        vectoring: purpose of those vectoring angles.

    Raises:
        ConfigError: when the log holds no pose, or a signal has the wrong size.
    """
    times = np.asarray(log.time.values, dtype=float)
    said: list[str] = []

    def pose(name: str, width: int) -> np.ndarray:
        values = _held(log, name, width, said)
        if values is None:
            raise ConfigError(f"the log has no '{name}': without a measured pose nothing can be replayed")
        return values

    def entry(name: str, width: int | None, otherwise: Callable[[], np.ndarray], words: str) -> np.ndarray:
        values = _held(log, name, width, said)
        if values is None:
            said.append(f"no {name}: {words}")
            return otherwise()
        return values

    position, quaternion = pose(MEASURED[0], 3), pose(MEASURED[1], 4)
    words = "differences of the {}, low pass 20 Hz"
    velocity = entry(MEASURED[2], 3, lambda: velocities(times, position), words.format("positions"))
    angular_velocity = entry(
        MEASURED[3], 3, lambda: angular_velocities(times, quaternion), words.format("attitudes")
    )
    measured, commanded = list[Any](), list[np.ndarray]()
    sizes = robot.n_joints, robot.n_vectoring
    for name, width, angles in zip(MEASURED[4:6], sizes, nominal_posture(robot, vectoring), strict=True):
        command = _held(log, name.replace("_measured", "_command"), width, said)
        instead = np.tile(angles, (len(times), 1)) if command is None else command
        words = "those of the nominal posture" if command is None else "the commanded ones"
        measured.append(entry(name, width, lambda instead=instead: instead, words))
        commanded.append(measured[-1] if command is None else command)
    thrusts = entry(
        "thrusts_command",
        robot.n_rotors,
        lambda: np.full((len(times), robot.n_rotors), np.nan),
        "the estimator gets what the replayed controller commands, so its external wrench is that "
        "controller's own error",
    )
    age = entry(MEASURED[6], None, lambda: np.zeros(len(times)), "poses are taken for those of their tick")
    rates, force = (_held(log, name, 3, said) for name in MEASURED[7:])
    imu = ABSENT if rates is None or force is None else Imu(rates, force)
    clock = _clock(log, period, said)
    held = np.asarray(log[HELD].values, dtype=float) > 0.0 if HELD in log else np.zeros(len(times), bool)
    return Recorded(
        times,
        Measurement(position, quaternion, velocity, angular_velocity, *measured, capture_age=age, imu=imu),
        Command(thrusts, *commanded),
        clock,
        held,
        tuple(said),
    )


def _held(log: xr.Dataset, name: str, width: int | None, said: list[str]) -> np.ndarray | None:
    """A signal, its rows that are no numbers replaced by the last that was; None without one.

    It is (k, width), or (k,) where there is no width.
    """
    if name not in log.variables:
        return None
    values = np.asarray(log[name].values, dtype=float)
    wanted = () if width is None else (width,)
    if values.shape != (len(log.time), *wanted):
        raise ConfigError(f"signal '{name}' of the log has the shape {values.shape[1:]}, wanted {wanted}")
    bad = np.logical_not(np.isfinite(values.reshape(len(values), -1)).all(axis=1))
    if not bad.any():
        return values
    if bad.all():
        return None
    said.append(f"{name}: {int(bad.sum())} of {len(bad)} rows are no numbers; the last good row is held")
    rows = np.maximum.accumulate(np.where(bad, 0, np.arange(len(bad))))
    rows[: int(np.argmin(bad))] = int(np.argmin(bad))
    return values[rows]


def _clock(log: xr.Dataset, period: float, said: list[str]) -> Clock:
    """Where the flight was on its mission's clock."""
    count = len(log.time)
    if MISSION_TIME not in log.variables:
        return Clock(np.arange(float(count)), np.ones(count))
    shown = np.nan_to_num(np.asarray(log[MISSION_TIME].values, dtype=float)) / period
    if PACE in log.variables:
        # A tick's pace is that of the next one, and the clock is the sum of the paces: so it is the same to
        # the bit, where time in seconds was rounded.
        pace = np.nan_to_num(np.asarray(log[PACE].values, dtype=float)[:-1])
        pace = np.concatenate([np.ones(1), limited_pace(pace)])
        ticks = np.concatenate([np.zeros(1), np.cumsum(pace[1:])])
        if np.all(abs(ticks - shown) < 1e-3):
            return Clock(ticks, pace)
    said.append("the mission's clock is read from mission_time: no pace that fits it was recorded")
    return Clock(shown, np.gradient(shown))
