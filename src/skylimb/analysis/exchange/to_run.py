"""A stream of messages as a run: whole where skylimb wrote it, else what the lab's topics hold."""

from __future__ import annotations

import functools
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np

from skylimb.analysis.exchange.codec import plain_of
from skylimb.analysis.exchange.frames import Frames, LinkFrames
from skylimb.analysis.exchange.lab_ticks import Names, lab_name
from skylimb.analysis.exchange.lab_topics import IN_LOGS, RECORD, ROW, SOURCE
from skylimb.analysis.exchange.messages import Joints
from skylimb.analysis.exchange.run_topics import content_of, run_of
from skylimb.analysis.exchange.series import Sample, series_of
from skylimb.analysis.exchange.stream import Message
from skylimb.analysis.recording.log import build_log
from skylimb.analysis.recording.run import OK, Run
from skylimb.base.errors import OutputError
from skylimb.base.rotations import (
    quaternion_from_rotation,
    rot_z,
    rotation_from_quaternion,
    rpy_from_rotation,
)
from skylimb.robots.model import Robot

Named = tuple[float, float, dict[str, float]]
"""When angles were recorded, s, their message's stamp, s, and the angles by the joint's name, rad."""


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
    samples: defaultdict[str, list[Sample]] = defaultdict(list)
    joints: defaultdict[str, list[Named]] = defaultdict(list)
    others: Counter[str] = Counter()
    flights, announced = 1, False
    for message in messages:
        if message.topic == RECORD.name:
            record, announced = content_of(message.value)[1], True
        elif message.topic == SOURCE.name:
            source, content = content_of(message.value)
            sources[source] = content
        elif message.topic == ROW.name:
            row = np.asarray(message.value.data, dtype=float)
            # Time goes back: what came from there on is flown anew, or another flight begins.
            flights += bool(rows) and row[0] <= rows[0][0] and announced
            while rows and row[0] <= rows[-1][0]:
                rows.pop()
            rows.append(row)
            announced = False
        elif record is None:
            _take(message, samples, joints, others)
    if record is not None:
        if not rows:
            raise OutputError(f"'{name}' holds the record of a flight, and no tick of it")
        if len({len(row) for row in rows}) > 1:
            raise OutputError(f"'{name}': rows of different length on {ROW.name}")
        said = (f"{flights} flights; this is the last one",) if flights > 1 else ()
        return Read(run_of(record, np.array(rows), sources, name), said)
    return _from_topics(samples, joints, others, robot(), name, link, period)


def _take(
    message: Message,
    samples: dict[str, list[Sample]],
    joints: dict[str, list[Named]],
    others: Counter[str],
) -> None:
    """Note down the signals of a message, or that its topic has none."""
    topics = (topic for topic in IN_LOGS if f"/{message.topic}".endswith(f"/{topic.name}"))
    topic = next(topics, None)
    if topic is None or not topic.signals:
        others[message.topic] += 1
        return
    header = getattr(message.value, "header", message.value)
    stamp = plain_of(header, "stamp") if hasattr(header, "stamp") else 0.0
    for signal, path in topic.signals.items():
        value = plain_of(message.value, path)
        if isinstance(value, Joints):
            angles = dict(zip(map(lab_name, value.names), value.angles, strict=False))
            joints[signal].append((message.time * 1e-9, stamp, angles))
        else:
            samples[signal].append((message.time * 1e-9, stamp, np.asarray(value, dtype=float)))


def angles_in_order(
    joints: Mapping[str, list[Named]], robot: Robot, said: list[str]
) -> dict[str, list[Sample]]:
    """Angles by signal, in the robot's order, of the messages that name all its joints of a kind."""
    names, found = Names(robot), {}
    kinds = {"joint": names.joints, "vectoring": names.gimbals}
    for signal, every in joints.items():
        whole = {
            f"{kind}_angles_{signal}": [
                (time, stamp, np.array([angles[name] for name in wanted], dtype=float))
                for time, stamp, angles in every
                if angles.keys() >= set(wanted)
            ]
            for kind, wanted in kinds.items()
            if wanted
        }
        known = {name: samples for name, samples in whole.items() if samples}
        if not known:
            heard = ", ".join(sorted({name for _, _, angles in every for name in angles})) or "no joint"
            expected = ", ".join(name for wanted in kinds.values() for name in wanted)
            said.append(f"angles {signal}: of {heard}; {robot.name} has {expected}; left out")
        found |= known
    return found


def _from_topics(
    samples: Mapping[str, list[Sample]],
    joints: Mapping[str, list[Named]],
    others: Counter[str],
    robot: Robot,
    name: str,
    link: Callable[[Robot], str],
    period: float,
) -> Read:
    if "pose" not in samples:
        topics = ", ".join(sorted(others)[:8]) or "none"
        raise OutputError(
            f"'{name}' has no topic .../mocap/pose: there is no flight in it (topics: {topics})"
        )
    said = [f"topics without a place in a log: {', '.join(sorted(others))}"] if others else []
    samples = {**samples, **angles_in_order(joints, robot, said)}
    series = {signal: one for signal, every in samples.items() if (one := series_of(every))}
    said += [
        f"{signal}: samples of different sizes are left out" for signal in samples.keys() - series.keys()
    ]
    said += [
        f"{signal}: stamps are {one.offset:+.3f} s off the recorder's clock; that is taken off"
        for signal, one in series.items()
        if one.offset
    ]
    times = series["pose"].times
    if len(times) < 2:
        raise OutputError(f"'{name}' has one pose; a flight has more")
    ticks = np.arange(int((times.max() - times.min()) / period + 1e-9) + 1) * period + times.min()
    held = {signal: one.at(ticks) for signal, one in series.items()}
    said += [
        f"{signal} at {1.0 / gap:.3g} Hz: at each tick the last one"
        for signal, one in series.items()
        if len(one.times) > 1 and (gap := float(np.median(np.diff(one.times)))) > 1.5 * period
    ]
    values = _signals(held, robot, link(robot), said)
    attributes = {"robot": robot.name, "experiment": "log", "status": OK}
    log = build_log(values, ticks - ticks[0], robot.description, attributes=attributes)
    return Read(Run(name=name, controller="", log=log), tuple(said))


def _signals(held: dict[str, np.ndarray], robot: Robot, link: str, said: list[str]) -> dict[str, np.ndarray]:
    """The signals of a log by name."""
    sizes = {"joint": robot.n_joints, "vectoring": robot.n_vectoring, "thrusts": robot.n_rotors}
    found: dict[str, np.ndarray] = {}
    for name, values in held.items():
        size = sizes.get(name.partition("_")[0], values.shape[1])
        if values.shape[1] != size:
            said.append(f"{name}: {values.shape[1]} values, {robot.name} has {size}; left out")
        elif name not in ("pose", "gyro", "acc"):
            found[name] = values
    if "thrusts_command" in held:
        said.append("thrusts_command is base_thrust: what a flight controller adds on board is in no topic")
    frames = _link_frames(found, robot, link)
    if "attitude_estimate" in found:
        _turn_to_C(found, frames, link, said)
    measured = robot.description.measured_link
    positions, attitudes = held["pose"][:, 0:3], held["pose"][:, 3:7]
    lengths = np.linalg.norm(attitudes, axis=1)
    attitudes = attitudes / np.where(lengths > 0.0, lengths, np.nan)[:, None]
    if link != measured and frames is None:
        said.append(f"no joint angles: the pose of {link} is taken for that of the measured link")
    elif link != measured and frames is not None:
        turns = [
            rotation_from_quaternion(q) @ one.R_root_link.T for q, one in zip(attitudes, frames, strict=True)
        ]
        positions = positions - np.array([R @ one.link for R, one in zip(turns, frames, strict=True)])
        attitudes = np.array([quaternion_from_rotation(R) for R in turns])
    found["root_position_measured"], found["root_quaternion_measured"] = positions, attitudes
    mount = robot.description.imu
    if "gyro" in held and link == measured:
        found["root_angular_velocity_measured"] = held["gyro"]
    if "gyro" in held and link == mount.link:
        for name, values in (("angular_velocity", held["gyro"]), ("specific_force", held["acc"])):
            found[f"imu_{name}_measured"] = values @ mount.R
    elif "gyro" in held:
        said.append(f"imu: it sits on {link}, in the robot's file on {mount.link}; left out")
    return found


def _link_frames(found: dict[str, np.ndarray], robot: Robot, link: str) -> list[LinkFrames] | None:
    """The lab's link and C at each tick; NaN where angles are, None without joint angles."""
    q = found.get("joint_angles_measured", found.get("joint_angles_command"))
    if q is None:
        return None
    none = np.zeros((len(q), robot.n_vectoring))
    psi = found.get("vectoring_angles_measured", found.get("vectoring_angles_command", none))
    frames = Frames(robot, link)

    @functools.cache
    def at(angles: bytes) -> LinkFrames:
        return frames.at(*np.split(np.frombuffer(angles), [robot.n_joints]))

    return [at(row.tobytes()) for row in np.concatenate([q, psi], axis=1)]


def _turn_to_C(
    found: dict[str, np.ndarray], frames: list[LinkFrames] | None, link: str, said: list[str]
) -> None:
    """Attitude and rates at the centre of gravity from the lab's axes, which have its link's yaw, to C's."""
    attitudes, rates = found["attitude_estimate"], found["angular_velocity_estimate"]
    if frames is None:
        said.append(f"no joint angles: the yaw of {link} is taken for that of the centre of gravity")
        turns = [np.eye(3)] * len(attitudes)
    else:
        turns = [np.asarray(rot_z(one.yaw_in_C)) for one in frames]
    pairs = list(zip(turns, attitudes, rates, strict=True))
    found["attitude_estimate"] = np.array(
        [rpy_from_rotation(rotation_from_quaternion(q) @ turn.T) for turn, q, _ in pairs]
    )
    found["angular_velocity_estimate"] = np.array([turn @ rate for turn, _, rate in pairs])
