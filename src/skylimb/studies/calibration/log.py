"""A log read for a calibration: what it must have, and which of its ticks were flown freely."""

from __future__ import annotations

import tomllib
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.ndimage import median_filter

from skylimb.analysis.recording.run import Run
from skylimb.base.errors import ConfigError
from skylimb.robots.model import Robot

SIGNALS = (
    "root_position_measured",
    "root_quaternion_measured",
    "joint_angles_measured",
    "vectoring_angles_measured",
    "thrusts_command",
)
"""What is read of a log: nothing but what a real robot records."""

UNITS = dict(zip(SIGNALS, ("m", "", "rad", "rad", "N"), strict=True))
"""Unit of each."""

LONGEST_BLIND = 1.0
"""Longest time without a frame that is bridged, s."""

SHORTEST_PIECE = 2.0
"""Least time of a part that is used, s."""

SHORTEST = 5.0
"""Least time of a flight that says anything, s."""

MARGIN = 0.25
"""Time at both ends of a piece that is not used, s: angles are smoothed there, and a frame is as old."""

_WILD = 15.0
"""Times its usual distance from the median of the five frames around it at which a frame is not used."""

_SAME = 1e-9
"""A pose that moved by less than this (m, or part of a unit quaternion) is the frame before, held."""


class Measured(NamedTuple):
    """A log's columns, a row a tick.

    Attributes:
        dt: control period, s.
        pieces: first and last tick (not included) of every part in which nothing touches.
        fresh: whether the pose is a new frame, (k,).
        position: of the measured root, W, m; zero where there is no frame.
        quaternion: of the measured root, (w, x, y, z); no turn where there is no frame.
        angles: measured joint and vectoring angles, rad.
        command: commanded thrusts, N.
    """

    dt: float
    pieces: tuple[tuple[int, int], ...]
    fresh: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray
    angles: np.ndarray
    command: np.ndarray


def measured(run: Run, robot: Robot) -> Measured:
    """What a run's log says, checked.

    Raises:
        ConfigError: naming what is missing, not finite, too short or of another robot, or that the flight was
            lost or touched something.
    """
    log, name = run.log, run.name
    if run.failed:
        raise ConfigError(f"the flight of '{name}' was lost ({run.cause}); no calibration is made of it")
    of = str(log.attrs.get("robot", ""))
    if of != robot.name:
        raise ConfigError(f"the log is of robot '{of}', not of '{robot.name}'")
    missing = [signal for signal in SIGNALS if signal not in log]
    if missing:
        raise ConfigError(f"the log has no signal '{missing[0]}', which a calibration needs")
    arrays = {signal: np.asarray(log[signal].values, dtype=float) for signal in SIGNALS}
    sizes = (3, 4, robot.n_joints, robot.n_vectoring, robot.n_rotors)
    for (signal, array), size in zip(arrays.items(), sizes, strict=True):
        if array.ndim != 2 or array.shape[1] != size:
            raise ConfigError(
                f"signal '{signal}' of the log has shape {array.shape}; {size} columns are right"
            )
    times = np.asarray(log["time"].values, dtype=float)
    if len(times) < 2 or times[-1] - times[0] < SHORTEST:
        length = times[-1] - times[0] if len(times) else 0.0
        raise ConfigError(f"the log lasts {length:.3g} s; a calibration needs {SHORTEST:g} s at least")
    dt = float(np.median(np.diff(times)))
    _require_ticks(times, dt)
    fresh = _fresh(arrays)
    _require_sound(log, arrays, robot, fresh)
    pieces = _free(run, dt, len(times))
    pose = arrays["root_position_measured"], arrays["root_quaternion_measured"]
    return Measured(
        dt,
        pieces,
        fresh,
        np.where(fresh[:, None], pose[0], 0.0),
        np.where(fresh[:, None], pose[1], [1.0, 0.0, 0.0, 0.0]),
        np.concatenate([arrays["joint_angles_measured"], arrays["vectoring_angles_measured"]], axis=1),
        arrays["thrusts_command"],
    )


def _require_ticks(times: np.ndarray, dt: float) -> None:
    """Refuse a log whose ticks do not come evenly."""
    uneven = np.flatnonzero(np.abs(np.diff(times) - dt) > 0.1 * dt)
    if len(uneven):
        at = int(uneven[0])
        raise ConfigError(
            f"the log has a gap: from {times[at]:.3f} s to {times[at + 1]:.3f} s, where a tick takes {dt:g} s"
        )


def _fresh(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Whether each tick shows a frame that the tick before did not; one without numbers is none, (k,)."""
    pose = np.concatenate([arrays["root_position_measured"], arrays["root_quaternion_measured"]], axis=1)
    known = np.isfinite(pose).all(axis=1)
    held = np.concatenate([[False], (np.abs(pose[1:] - pose[:-1]) < _SAME).all(axis=1)])
    fresh = known & ~held
    fresh[np.flatnonzero(fresh)[_wild(pose[fresh])]] = False
    return fresh


def _wild(frames: np.ndarray) -> np.ndarray:
    """Whether each frame, (k, 7), lies far beside those around it, where no robot can have been, (k,)."""
    # A quaternion and its negative are one attitude.
    turned = np.concatenate([[0.0], np.cumsum((frames[1:, 3:] * frames[:-1, 3:]).sum(axis=1) < 0.0)])
    frames = np.concatenate(
        [frames[:, :3], frames[:, 3:] * np.where(turned % 2.0, -1.0, 1.0)[:, None]], axis=1
    )
    beside = np.abs(frames - median_filter(frames, size=(5, 1), mode="nearest"))
    usual = np.sqrt(np.mean(np.minimum(beside, np.quantile(beside, 0.9, axis=0)) ** 2, axis=0))
    return (beside > _WILD * np.maximum(usual, _SAME)).any(axis=1)


def _require_sound(log: xr.Dataset, arrays: dict[str, np.ndarray], robot: Robot, fresh: np.ndarray) -> None:
    """Refuse numbers that are missing, or that cannot be what they are called."""
    for name, unit in UNITS.items():
        given = str(log[name].attrs.get("units", unit))
        if given != unit:
            raise ConfigError(
                f"signal '{name}' of the log is in '{given}'; a calibration needs it in '{unit}'"
            )
    for name in SIGNALS[2:]:
        bad = np.flatnonzero(~np.isfinite(arrays[name]).all(axis=1))
        if len(bad):
            at = float(log["time"].values[bad[0]])
            raise ConfigError(f"signal '{name}' of the log is not finite at {at:.3f} s")
    frames = np.flatnonzero(fresh)
    longest = float(np.max(np.diff(frames))) if len(frames) > 1 else np.inf
    if longest * float(np.median(np.diff(log["time"].values))) > LONGEST_BLIND:
        raise ConfigError(
            f"the log is without a frame of the motion capture for more than {LONGEST_BLIND:g} s at a time"
        )
    sizes = np.linalg.norm(arrays["root_quaternion_measured"][fresh], axis=1)
    if np.abs(sizes - 1.0).max() > 0.01:
        raise ConfigError("signal 'root_quaternion_measured' of the log is no unit quaternion")
    weight = robot.weight
    lift = float(np.median(arrays["thrusts_command"].sum(axis=1)))
    if not 0.5 * weight < lift < 2.0 * weight:
        raise ConfigError(
            f"the thrusts of the log are {lift:.3g} N together; {robot.name} weighs {weight:.3g} N, so they "
            "are in another unit or of another robot"
        )


def _free(run: Run, dt: float, count: int) -> tuple[tuple[int, int], ...]:
    """First and last tick of every part in which nothing is to touch."""
    free = np.ones(count, dtype=bool)
    if "phase" in run.log and _touches(run):
        names = str(run.log["phase"].attrs.get("flag_meanings", "")).split()
        allowed = [names.index(name) for name in ("hover", "tare", "hover_end") if name in names]
        free = np.isin(run.log["phase"].values, allowed)
    if "contact" in run.log:
        touched = np.flatnonzero(free & (run.log["contact"].values > 0.0))
        if len(touched):
            at = float(run.log["time"].values[touched[0]])
            raise ConfigError(f"the flight of '{run.name}' touched something at {at:.3f} s in free flight")
    edges = np.flatnonzero(np.diff(np.concatenate([[0], free.astype(int), [0]])))
    margin = round(MARGIN / dt)
    pieces = [(int(a) + margin, int(b) - margin) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    pieces = [piece for piece in pieces if (piece[1] - piece[0]) * dt >= SHORTEST_PIECE]
    if sum(b - a for a, b in pieces) * dt < SHORTEST - 2.0 * MARGIN:
        raise ConfigError(
            f"the log has {sum(b - a for a, b in pieces) * dt:.3g} s of free flight; a calibration needs "
            f"{SHORTEST:g} s at least"
        )
    return tuple(pieces)


def _touches(run: Run) -> bool:
    """Whether the mission of a run was to touch something."""
    config = tomllib.loads(run.config) if run.config else {}
    return bool(config.get("approach", {}).get("contact", True))
