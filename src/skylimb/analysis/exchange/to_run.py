"""A stream of messages as a run: whole where skylimb wrote it, else what the lab's topics hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from skylimb.analysis.exchange.frames import from_measured_link, lab_turn_in_C
from skylimb.analysis.exchange.lab_readers import reader, stamp
from skylimb.analysis.exchange.own_topics import RECORD, ROW, SOURCE, content_of, run_of
from skylimb.analysis.exchange.series import Series
from skylimb.analysis.exchange.stream import Message
from skylimb.analysis.recording.log import build_log
from skylimb.analysis.recording.run import Run
from skylimb.base.errors import OutputError
from skylimb.base.rotations import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_rpy,
    rpy_from_rotation,
)
from skylimb.robots.model import Robot


class Read(NamedTuple):
    """A run that was read, and what has to be said of it, one line each."""

    run: Run
    notes: tuple[str, ...]


def run_from(
    messages: Iterable[Message],
    robot: Callable[[], Robot],
    name: str,
    link: Callable[[Robot], str],
    period: float = 0.005,
) -> Read:
    """The run of a stream of messages.

    Args:
        messages: in the order of their recording.
        robot: makes the model of the robot that flew; not called where the stream holds a whole run.
        name: what a run is called that has no name.
        link: of the link whose pose the lab's topics show.
        period: between the ticks of a run that is put together from topics, s.

    Raises:
        OutputError: when there is neither a whole run nor a pose.
    """
    record: bytes | None = None
    sources: dict[str, bytes] = {}
    rows: list[np.ndarray] = []
    series: dict[str, Series] = {}
    others: Counter[str] = Counter()
    flights = 1
    for message in messages:
        if message.topic == RECORD:
            record = content_of(message.value)[1]
        elif message.topic == SOURCE:
            source, content = content_of(message.value)
            sources[source] = content
        elif message.topic == ROW:
            row = np.asarray(message.value.data, dtype=float)
            if rows and row[0] <= rows[-1][0]:  # time goes back: another flight begins
                rows.clear()
                flights += 1
            rows.append(row)
        elif record is None:
            _take(message, series, others)
    if record is not None:
        if len({len(row) for row in rows}) > 1:
            raise OutputError(f"'{name}': rows of different length on {ROW}")
        said = (f"{flights} flights; this is the last one",) if flights > 1 else ()
        return Read(run_of(record, np.array(rows).reshape(len(rows), -1), sources, name), said)
    return _from_topics(series, others, robot(), name, link, period)


def _take(message: Message, series: dict[str, Series], others: Counter[str]) -> None:
    """Note down the signals of a message, or that its topic has none."""
    read = reader(message.topic)
    if read is None:
        others[message.topic] += 1
        return
    for signal, value in read(message.value):
        series.setdefault(signal, Series()).add(message.time * 1e-9, stamp(message.value), value)


def _from_topics(
    series: dict[str, Series],
    others: Counter[str],
    robot: Robot,
    name: str,
    link: Callable[[Robot], str],
    period: float,
) -> Read:
    if "pose" not in series:
        topics = ", ".join(sorted(others)[:8]) or "none"
        raise OutputError(
            f"'{name}' has no topic .../mocap/pose: there is no flight in it (topics: {topics})"
        )
    said = [f"topics without a place in a log: {', '.join(sorted(others))}"] if others else []
    placed = {signal: one.times() for signal, one in series.items() if one.usable}
    said += [f"{signal}: samples of different sizes are left out" for signal in series.keys() - placed.keys()]
    offsets = {signal: offset for signal, (_, offset) in placed.items() if offset}
    said += [
        f"{signal}: stamps are {offset:+.3f} s off the recorder's clock; that is taken off"
        for signal, offset in offsets.items()
    ]
    times = placed["pose"][0]
    if len(times) < 2:
        raise OutputError(f"'{name}' has one pose; a flight has more")
    ticks = np.arange(int((times.max() - times.min()) / period + 1e-9) + 1) * period + times.min()
    held = {signal: series[signal].at(ticks, when) for signal, (when, _) in placed.items()}
    said += [
        f"{signal} at {1.0 / gap:.3g} Hz: at each tick the last one"
        for signal, (when, _) in placed.items()
        if len(when) > 1 and (gap := float(np.median(np.diff(when)))) > 1.5 * period
    ]
    values = _signals(held, robot, link(robot), said)
    return Read(_run(values, ticks - ticks[0], robot, name), tuple(said))


def _signals(held: dict[str, np.ndarray], robot: Robot, link: str, said: list[str]) -> dict[str, np.ndarray]:
    """The signals of a log by name."""
    sizes = {"joint": robot.n_joints, "vectoring": robot.n_vectoring, "rotor": robot.n_rotors}
    found: dict[str, np.ndarray] = {}

    def put(signal: str, name: str, dim: str) -> None:
        values = held.get(signal)
        if values is None:
            return
        if dim in sizes and values.shape[1] != sizes[dim]:
            said.append(f"{name}: {values.shape[1]} values, {robot.name} has {sizes[dim]}; left out")
        else:
            found[name] = values

    for kind in ("joint", "vectoring"):
        for part in ("measured", "command"):
            put(f"{kind}_{part}", f"{kind}_angles_{part}", kind)
    put("thrusts", "thrusts_command", "rotor")
    if "thrusts" in held:
        said.append("thrusts_command is base_thrust: what a flight controller adds on board is in no topic")
    for name in (
        "cog_position_estimate",
        "cog_velocity_estimate",
        "attitude_estimate",
        "angular_velocity_estimate",
        "external_force_estimate",
        "external_torque_estimate",
    ):
        put(name, name, "axis")
    _turn_to_C(found, robot, link, said)
    positions, attitudes = _measured_link(held, found, robot, link, said)
    found["root_position_measured"] = positions
    found["root_quaternion_measured"] = attitudes
    if "gyro" in held and link == robot.description.measured_link:
        found["root_angular_velocity_measured"] = held["gyro"]
    elif "gyro" in held:
        said.append(f"imu: its rates are those of {link}, not of {robot.description.measured_link}; left out")
    return found


def _turn_to_C(found: dict[str, np.ndarray], robot: Robot, link: str, said: list[str]) -> None:
    """Attitude and rates at the centre of gravity from the lab's axes, which have its link's yaw, to C's."""
    names = ("attitude_estimate", "angular_velocity_estimate")
    if not all(name in found for name in names):
        return
    q = found.get("joint_angles_measured", found.get("joint_angles_command"))
    if q is None:
        said.append(f"no joint angles: the yaw of {link} is taken for that of the centre of gravity")
        return
    none = np.zeros((len(q), robot.n_vectoring))
    psi = found.get("vectoring_angles_measured", found.get("vectoring_angles_command", none))
    attitudes, rates = (found[name].copy() for name in names)
    angles = np.concatenate([q, psi], axis=1)
    before, turn = np.full(angles.shape[1], np.nan), np.eye(3)
    for k, now in enumerate(angles):
        if not np.isfinite(now).all():
            attitudes[k], rates[k] = np.nan, np.nan
            continue
        if not np.array_equal(now, before):
            turn, before = lab_turn_in_C(robot, link, q[k], psi[k]), now
        attitudes[k] = rpy_from_rotation(rotation_from_rpy(*attitudes[k]) @ turn.T)
        rates[k] = turn @ rates[k]
    for name, values in zip(names, (attitudes, rates), strict=True):
        found[name] = values


def _measured_link(
    held: dict[str, np.ndarray],
    found: dict[str, np.ndarray],
    robot: Robot,
    link: str,
    said: list[str],
) -> tuple[np.ndarray, np.ndarray]:
    """Position and attitude of the measured link from those of the lab's link, (k, 3) and (k, 4)."""
    positions, attitudes = held["pose"][:, 0:3], held["pose"][:, 3:7]
    sizes = np.linalg.norm(attitudes, axis=1)
    attitudes = attitudes / np.where(sizes > 0.0, sizes, np.nan)[:, None]
    if link == robot.description.measured_link:
        return positions, attitudes
    q = found.get("joint_angles_measured", found.get("joint_angles_command"))
    if q is None:
        said.append(f"no joint angles: the pose of {link} is taken for that of the measured link")
        return positions, attitudes
    psi = np.zeros(robot.n_vectoring)
    moved, turned = np.empty_like(positions), np.empty_like(attitudes)
    before = np.full(7 + q.shape[1], np.nan)
    for k, (position, attitude, angles) in enumerate(zip(positions, attitudes, q, strict=True)):
        now = np.concatenate([position, attitude, angles])
        if k and np.array_equal(now, before):
            moved[k], turned[k] = moved[k - 1], turned[k - 1]
            continue
        before = now
        if not np.isfinite(now).all():
            moved[k], turned[k] = np.nan, np.nan
            continue
        xyz, turn = from_measured_link(robot, link, angles, psi)
        R = rotation_from_quaternion(attitude) @ turn.T
        moved[k], turned[k] = position - R @ xyz, quaternion_from_rotation(R)
    return moved, turned


def _run(values: dict[str, np.ndarray], times: np.ndarray, robot: Robot, name: str) -> Run:
    attributes = {"robot": robot.name, "experiment": "log", "status": "OK"}
    log = build_log(values, times, robot.description, attributes=attributes)
    return Run(name=name, controller="", log=log)
