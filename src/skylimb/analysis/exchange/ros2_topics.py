"""What is otherwise on ROS 2 than in the table of `lab_topics`: names, types, frames, and what rviz shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from skylimb.analysis.exchange import lab_messages as made
from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.lab_messages import Fields, header
from skylimb.analysis.exchange.lab_ticks import Frame, Names, TickView
from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.analysis.exchange.messages import WORLD
from skylimb.robots.model import Robot


class OwnNames(Names):
    """Names of the robot's own URDF, so that whatever reads that draws it; frames have no prefix.

    Args:
        robot: whose.
        namespace: of the topics.
    """

    def __init__(self, robot: Robot, namespace: str = "") -> None:
        super().__init__(robot, namespace)
        self.gimbals = self._description.vectoring_joints

    def frame(self, name: str) -> str:
        """A link's own name; `fc` is the one that the IMU sits on."""
        return self._description.imu.link if name == "fc" else name

    def link(self, name: str) -> str:
        """A link's own name."""
        return name

    def fixed(self, angles: np.ndarray) -> Iterator[Frame]:
        """Links that never move in their parents."""
        yield from (frame for turns, frame in self.links(angles) if not turns)


def transforms(tick: TickView) -> Fields | None:
    """The robot's root in the world, all links that move in their parents, and the centre of gravity."""
    body, names, angles = tick.body, tick.names, tick.angles
    if body is None or angles is None or not isinstance(names, OwnNames):
        return None
    root, (place, R), moving = names.placed(angles, (body.root, body.R_W_root))
    frames: list[Frame] = [(WORLD, root, place, R), (WORLD, "cog", body.cog, body.R_WC)]
    return {"transforms": [made.transform(tick, *one) for one in (*frames, *moving)]}


def imu(tick: TickView) -> Fields | None:
    """What the IMU says, in its link's axes."""
    felt: Any = made.imu(tick)
    if felt is None:
        return None
    x, y, z, w = felt.quaternion_xyzw
    return {
        **header(tick, tick.names.frame("fc")),
        "orientation": (w, x, y, z),
        "angular_velocity": felt.gyro,
        "linear_acceleration": felt.acceleration,
    }


def wanted(tick: TickView) -> Fields | None:
    """Where the centre of gravity is wanted."""
    return None if tick.target is None else {**header(tick), "point": made.vector(tick.target[0])}


def marker(space: str, number: int, kind: int, size: tuple[float, ...], colour: tuple[float, ...]) -> Fields:
    """Fields of a marker in W: an arrow 0, a cube 1, a sphere 2, a cylinder 3, triangles 11.

    Args:
        space: of its number.
        number: by which it is drawn anew.
        kind: what it is.
        size: m, (3,); of an arrow the widths of shaft and head, and the head's length.
        colour: red, green, blue, and how much of it is seen, 0 .. 1.
    """
    look = dict(zip(("color.r", "color.g", "color.b", "color.a"), colour, strict=True))
    turn = {"pose.orientation": (1.0, 0.0, 0.0, 0.0), "scale": size}
    return {"header.frame_id": WORLD, "ns": space, "id": number, "type": kind, **turn, **look}


def markers(tick: TickView) -> Fields | None:
    """Where the centre of gravity is wanted, and the force that is felt, 50 mm a newton."""
    found = []
    if tick.target is not None:
        ball = marker("target", 0, 2, (0.03,) * 3, (0.0, 0.62, 0.45, 0.6))
        found.append({**ball, "pose.position": made.vector(tick.target[0])})
    if tick.body is not None and "external_force_estimate" in tick.signals:
        ends = tick.body.cog, tick.body.cog + 0.05 * np.asarray(tick.signals["external_force_estimate"])
        arrow = marker("force", 0, 0, (0.01, 0.02, 0.02), (0.84, 0.37, 0.0, 1.0))
        found.append({**arrow, "points": [made.vector(one) for one in ends]})
    return {"markers": found} if found else None


DESCRIPTION = Topic("robot_description", topics.MISSION.type, latched=True)
SCENE = Topic("scene", "visualization_msgs/msg/MarkerArray", latched=True)
MARKERS = Topic("markers", SCENE.type, 20.0, markers)

_OTHERWISE = (
    replace(topics.IMU, type="sensor_msgs/msg/Imu", make=imu),
    replace(topics.FOUR_AXES, type="skylimb_msgs/msg/RotorThrusts", called="rotor_thrusts"),
    replace(topics.CONFIG, type="skylimb_msgs/msg/Arming", called="arming"),
    replace(topics.ACK, type="skylimb_msgs/msg/Arming", called="arming_acknowledged"),
    replace(topics.PWMS, type="skylimb_msgs/msg/MotorDuties", called="motor_duties"),
    replace(topics.DESIRE, type="skylimb_msgs/msg/ControlledAxes", called="controlled_axes"),
    replace(topics.BATTERY, type="sensor_msgs/msg/BatteryState", called="battery_state"),
    replace(topics.PID, type="skylimb_msgs/msg/PoseTerms"),
    replace(topics.NAV, type="geometry_msgs/msg/TwistStamped", called="cmd_vel"),
    replace(topics.COG, make=made.in_its_axes(made.cog_odometry), called="cog/odom"),
    replace(topics.BASELINK, make=made.in_its_axes(made.baselink_odometry), called="odom"),
    replace(topics.TF, make=transforms),
)
_BY_NAME = {topic.name: topic for topic in _OTHERWISE}

VIEWS = (DESCRIPTION, SCENE, MARKERS, replace(topics.REFERENCE, make=wanted, called="cog/target"))
"""What anybody may look at besides what ROS 1 has."""


def described(robot: Robot) -> Iterator[tuple[Topic, str]]:
    """The robot's URDF."""
    for source in robot.description.sources:
        if source.path.suffix == ".urdf":
            yield DESCRIPTION, source.content.decode("utf-8")


def spoken(topic: Topic) -> Topic | None:
    """A topic of the table as it is on ROS 2; None for what it is not."""
    topic = _BY_NAME.get(topic.name, topic)
    return None if topic.type.startswith(("spinal", "aerial_robot_msgs")) else topic
