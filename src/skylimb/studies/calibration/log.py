"""A log read for a calibration: what it must have, and which of its ticks were flown freely."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.ndimage import median_filter

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.signals import events_of, phase_names, stretches
from skylimb.base.errors import ConfigError
from skylimb.flight.replay.doubts import doubts
from skylimb.flight.replay.rates import SAME
from skylimb.flight.replay.recorded import recorded, require_rising
from skylimb.robots.model import Robot

POSITION, QUATERNION = "root_position_measured", "root_quaternion_measured"
JOINTS, VECTORING, COMMAND = "joint_angles_measured", "vectoring_angles_measured", "thrusts_command"

UNITS = {POSITION: "m", QUATERNION: "", JOINTS: "rad", VECTORING: "rad", COMMAND: "N"}
"""What is read of a log, nothing but what a real robot records, and the unit of each."""

LONGEST_BLIND = 1.0
"""Longest time without a frame that is bridged, s."""

SHORTEST_PIECE = 2.0
"""Least time of a part that is used, s."""

SHORTEST = 5.0
"""Least time of a flight that says anything, s."""

LONGEST_TICK = 0.05
"""Longest time from row to row, s: the shortest piece and the smoothing of encoders have some rows then."""

MARGIN = 0.25
"""Time at both ends of a piece that is not used, s: angles are smoothed there, and a frame is as old."""

_SEEN_OTHERWISE = ("late", "jump", "turn", "joint")
"""Keys of a sensor fault that change the frames and angles which are read; others take them away."""

_WILD = 15.0
"""Times its usual distance from the median of the five frames around it at which a frame is not used."""


Columns = dict[str, np.ndarray]
"""Signal -> its numbers, a row a tick, (k, ...)."""


def columns_of(run: Run, robot: Robot) -> tuple[Columns, float]:
    """The signals of a run's log, checked, and its control period, s.

    Raises:
        ConfigError: naming what is missing, not finite, too short or of another robot, or that the flight was
            lost.
    """
    log = run.log
    if run.failed:
        raise ConfigError(f"the flight of '{run.name}' was lost ({run.cause}); no calibration is made of it")
    of = str(log.attrs.get("robot", ""))
    if of != robot.name:
        raise ConfigError(f"the log is of robot '{of}', not of '{robot.name}'")
    dt = _tick(run)
    widths = (3, 4, robot.n_joints, robot.n_vectoring, robot.n_rotors)
    columns = {name: _column(log, name, width) for name, width in zip(UNITS, widths, strict=True)}
    lift = float(np.median(columns[COMMAND].sum(axis=1)))
    if not 0.5 * robot.weight < lift < 2.0 * robot.weight:
        raise ConfigError(
            f"the thrusts of the log are {lift:.3g} N together; {robot.name} weighs {robot.weight:.3g} N, so "
            "they are in another unit or of another robot"
        )
    return columns, dt


def _tick(run: Run) -> float:
    """Time from row to row, s, of a log whose rows are the control ticks."""
    times = np.asarray(run.log["time"].values, dtype=float)
    length = float(np.ptp(times)) if len(times) else 0.0
    if length < SHORTEST:
        raise ConfigError(f"the log lasts {length:.3g} s; a calibration needs {SHORTEST:g} s at least")
    require_rising(times)
    taken = np.diff(times)
    dt = float(np.median(taken))
    uneven = np.flatnonzero(np.abs(taken - dt) > 0.1 * dt)
    if len(uneven):
        begin, end = times[uneven[0]], times[uneven[0] + 1]
        raise ConfigError(
            f"the log has a gap: from {begin:.3f} s to {end:.3f} s, where a tick takes {dt:g} s"
        )
    if dt > LONGEST_TICK:
        raise ConfigError(
            f"the log has a row every {dt:g} s; a calibration needs one every {LONGEST_TICK:g} s at least; "
            "is its time in seconds?"
        )
    rate = float(run.tables.get("controller_rate", 0.0))
    if rate * dt > 1.1:
        raise ConfigError(
            f"the log has a row every {dt:g} s, and its controller commanded every {1.0 / rate:g} s: a "
            "calibration needs all thrusts that were commanded"
        )
    return dt


def _column(log: xr.Dataset, name: str, width: int) -> np.ndarray:
    """A signal, (k, width), in its unit; finite, but for a pose, which has no numbers where no frame came."""
    if name not in log:
        raise ConfigError(f"the log has no signal '{name}', which a calibration needs")
    values = np.asarray(log[name].values, dtype=float)
    if values.ndim != 2 or values.shape[1] != width:
        raise ConfigError(f"signal '{name}' of the log has shape {values.shape}; {width} columns are right")
    unit = str(log[name].attrs.get("units", UNITS[name]))
    if unit != UNITS[name]:
        raise ConfigError(
            f"signal '{name}' of the log is in '{unit}'; a calibration needs it in '{UNITS[name]}'"
        )
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad) and name not in (POSITION, QUATERNION):
        at = float(log["time"].values[bad[0]])
        raise ConfigError(f"signal '{name}' of the log is not finite at {at:.3f} s")
    return values


def fresh_frames(columns: Columns, dt: float) -> np.ndarray:
    """Whether each tick shows a frame that the tick before did not; one without numbers is none, (k,).

    Raises:
        ConfigError: when the log is blind for too long, or its attitudes are none.
    """
    pose = np.concatenate([columns[POSITION], columns[QUATERNION]], axis=1)
    known = np.isfinite(pose).all(axis=1)
    held = np.concatenate([[False], (np.abs(pose[1:] - pose[:-1]) < SAME).all(axis=1)])
    fresh = known & ~held
    if fresh.any():
        fresh[np.flatnonzero(fresh)[_wild(pose[fresh])]] = False
    frames = np.flatnonzero(fresh)
    longest = float(np.max(np.diff(frames))) if len(frames) > 1 else np.inf
    if longest * dt > LONGEST_BLIND:
        raise ConfigError(
            f"the log is without a frame of the motion capture for more than {LONGEST_BLIND:g} s at a time"
        )
    if np.abs(np.linalg.norm(columns[QUATERNION][fresh], axis=1) - 1.0).max() > 0.01:
        raise ConfigError(f"signal '{QUATERNION}' of the log is no unit quaternion")
    return fresh


def require_believable(run: Run, robot: Robot, dt: float) -> None:
    """Refuse a log that says what no flight can have, most often in another unit than it names.

    Raises:
        ConfigError: with what it says.
    """
    found = list(doubts(recorded(run.log, robot, dt, "torque"), robot))
    if found:
        raise ConfigError(f"the log says what no flight can have: {'; '.join(found)}")


def _wild(frames: np.ndarray) -> np.ndarray:
    """Whether each frame, (k, 7), lies far beside those around it, where no robot can have been, (k,)."""
    # A quaternion and its negative are one attitude.
    turned = np.concatenate([[0.0], np.cumsum((frames[1:, 3:] * frames[:-1, 3:]).sum(axis=1) < 0.0)])
    frames = np.concatenate(
        [frames[:, :3], frames[:, 3:] * np.where(turned % 2.0, -1.0, 1.0)[:, None]], axis=1
    )
    beside = np.abs(frames - median_filter(frames, size=(5, 1), mode="nearest"))
    usual = np.sqrt(np.mean(np.minimum(beside, np.quantile(beside, 0.9, axis=0)) ** 2, axis=0))
    return (beside > _WILD * np.maximum(usual, SAME)).any(axis=1)


def free_pieces(run: Run, dt: float, follows: np.ndarray) -> tuple[tuple[int, int], ...]:
    """First and last tick (not included) of every part that is free, its thrusts known.

    Args:
        run: what was flown.
        dt: control period, s.
        follows: whether the motors follow at each tick.

    Raises:
        ConfigError: when something was touched there, when robot or sensors became others in between, or
            when there is too little of it.
    """
    log = run.log
    free = np.ones(log.sizes["time"], dtype=bool)
    touches = run.tables.get("approach", {}).get("contact", True)
    if "phase" in log and touches:
        names = phase_names(log)
        allowed = names.keys() & {"hover", "tare", "hover_end"}
        free = np.isin(log["phase"].values, [names[name] for name in allowed])
    if "contact" in log:
        touched = np.flatnonzero(free & (log["contact"].values > 0.0))
        if len(touched):
            at = float(log["time"].values[touched[0]])
            raise ConfigError(f"the flight of '{run.name}' touched something at {at:.3f} s in free flight")
    margin = round(MARGIN / dt)
    pieces = [(begin + margin, end - margin) for begin, end in stretches(free & follows)]
    pieces = [piece for piece in pieces if (piece[1] - piece[0]) * dt >= SHORTEST_PIECE]
    found = sum(b - a for a, b in pieces) * dt
    if found < SHORTEST - 2.0 * MARGIN:
        lost = float(np.count_nonzero(free & ~follows)) * dt
        why = f"; in {lost:.3g} s of it the motors could not follow what was commanded" if lost else ""
        raise ConfigError(
            f"the log has {found:.3g} s of free flight; a calibration needs {SHORTEST:g} s at least{why}"
        )
    _require_one_robot(run, float(log["time"].values[pieces[0][0]]), float(log["time"].values[pieces[-1][1]]))
    return tuple(pieces)


def _require_one_robot(run: Run, begin: float, end: float) -> None:
    """Refuse a flight whose record says that its robot or sensors changed between two times, s."""
    for event in events_of(run.log):
        seen = any(event.table.get(key) not in (None, 0.0, [0.0, 0.0, 0.0], "") for key in _SEEN_OTHERWISE)
        sensors = event.kind == "sensor" and (seen or event.table.get("capture") == "disordered")
        at = [time for time in (event.time, event.time + event.duration) if begin < time < end]
        if at and (sensors or event.kind in ("rotor", "body")):
            raise ConfigError(
                f"the flight of '{run.name}' has another robot or other sensors from {at[0]:.3f} s on "
                f"({event.words}); a calibration is of one: take the log before or after that"
            )
