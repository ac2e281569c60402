"""A run as a stream of messages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from skylimb.analysis.exchange.body import Bodies
from skylimb.analysis.exchange.codec import message_of
from skylimb.analysis.exchange.frames import felt_by
from skylimb.analysis.exchange.lab_messages import mounts
from skylimb.analysis.exchange.lab_ticks import Names, TickView
from skylimb.analysis.exchange.lab_topics import (
    COG,
    EACH_TICK,
    IN_LOGS,
    MOCAP,
    NAMESPACE,
    ROW,
    TF,
    TF_STATIC,
    Topic,
    is_due,
)
from skylimb.analysis.exchange.ros2_topics import OwnNames, described, spoken
from skylimb.analysis.exchange.run_topics import record_messages, row_table
from skylimb.analysis.exchange.stream import Message
from skylimb.analysis.recording.run import Run
from skylimb.base.rotations import rotation_from_rpy
from skylimb.robots.model import Robot

if TYPE_CHECKING:
    import xarray as xr

START = 10**9
"""Time of the first row, ns, of a run that has no date; ROS takes 0 for no time."""

_EACH_TICK = frozenset(topic.name for topic in EACH_TICK)

SAME_POSE = 1e-9
"""Metres, or parts of a quaternion, by which a pose that is held may be off by rounding."""

_MEASURED = (
    *("root_position_measured", "root_quaternion_measured", "root_velocity_measured"),
    *("root_angular_velocity_measured", "joint_angles_measured", "vectoring_angles_measured"),
)
_FELT = ("imu_angular_velocity_measured", "imu_specific_force_measured")
_COMMAND = ("thrusts_command", "joint_angles_command", "vectoring_angles_command")


def topics_of(log: xr.Dataset) -> list[Topic]:
    """The topics that a log has all signals for."""
    return [topic for topic in IN_LOGS if all(name in log.variables for name in topic.needs)]


def messages_of(
    run: Run,
    robot: Robot,
    types: Any,
    link: str,
    namespace: str = NAMESPACE,
    ros2: bool = False,
) -> Iterator[Message]:
    """Everything that a run holds, in the order of time.

    Args:
        run: what flew.
        robot: its model.
        types: message types.
        link: whose pose is on the lab's topics.
        namespace: of the lab's topics, and of its frames.
        ros2: whether topics, types and names are those of ROS 2.
    """

    def message(topic: Topic, time: int, value: Any, k: int = 0) -> Message:
        return Message(topic.full(namespace), topic.type, time, message_of(types, topic.type, value, k))

    for topic, value in record_messages(run):
        yield message(topic, START, value)
    topics, table, shown = topics_of(run.log), row_table(run.log), np.full(7, np.nan)
    view_of = _views(run.log, robot, link, (OwnNames if ros2 else Names)(robot, namespace))
    if ros2:  # whoever opens it sees the robot fly, with nothing beside it
        topics = [one for topic in (*topics, TF) if (one := spoken(topic)) is not None]
        for topic, value in (*described(robot), (TF_STATIC, mounts(view_of(0, START * 1e-9)))):
            yield message(topic, START, value)
    seconds = run.log.time.values - run.log.time.values[0]
    period = float(np.median(np.diff(seconds))) if len(seconds) > 1 else 1.0
    for k, time in enumerate((START + np.round(seconds * 1e9).astype(np.int64)).tolist()):
        yield message(ROW, time, {"data": table[k]})
        tick = view_of(k, time * 1e-9)
        for topic in topics:
            if topic.name == MOCAP.name:
                pose = np.concatenate([tick.signals[name] for name in _MEASURED[:2]])
                fresh = not np.all(abs(pose - shown) < SAME_POSE)
                shown = pose
            else:
                fresh = topic.name in _EACH_TICK or is_due(topic, k, period)
            if fresh and topic.make is not None:
                yield message(topic, time, topic.make(tick), k)


def _views(log: xr.Dataset, robot: Robot, link: str, names: Names) -> Callable[[int, float], TickView]:
    """What makes the view of a row of a log, at a stamp, s."""
    wanted = {*_MEASURED, *_FELT, *(name for topic in IN_LOGS for name in topic.needs)}
    values = {name: np.asarray(log[name].values) for name in sorted(wanted) if name in log.variables}
    bodies, none = Bodies(robot, link), np.zeros(0)
    unknown = {name: np.full(size, np.nan) for name, size in zip(_MEASURED, bodies.sizes, strict=True)}

    def view(k: int, stamp: float) -> TickView:
        row = {name: column[k] for name, column in values.items()}
        measured = [row.get(name, unknown[name]) for name in _MEASURED]
        thrusts, joints, vectoring = (row.get(name, none) for name in _COMMAND)
        cog = None
        if all(name in row for name in COG.signals):
            position, velocity, attitude, rates = (row[name] for name in COG.signals)
            cog = position, velocity, np.asarray(rotation_from_rpy(*attitude)), rates
        return TickView(
            stamp,
            names,
            bodies.of(measured),
            np.concatenate(measured[4:]),
            (thrusts, joints, vectoring),
            signals=row,
            felt=felt_by(robot, link, [row[name] for name in _FELT] if _FELT[0] in row else None),
            cog=cog,
        )

    return view
