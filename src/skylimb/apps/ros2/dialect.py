"""How a node speaks on ROS 2: the lab's table with other names and types, and the robot's own joints."""

from __future__ import annotations

from skylimb.analysis.exchange.messages import MotorInfo, UavInfo
from skylimb.analysis.exchange.ros2_topics import VIEWS, OwnNames, spoken
from skylimb.apps.ros.profile import Dialect, ProfileTopics, profile_topics
from skylimb.apps.ros.spinal import LEAST


def _topics(profile: str, servos: bool) -> ProfileTopics:
    lab = profile_topics(profile, servos)
    heard, said = ([spoken(topic) for topic in side] for side in (lab.subscribed, lab.published))
    more = () if profile == "simulator" else VIEWS
    return ProfileTopics(tuple(filter(None, heard)), (*filter(None, said), *more))


def _known(rotors: int) -> tuple[UavInfo | MotorInfo, ...]:
    """A simulated board arms at once: motors turn from .55 of duty."""
    return UavInfo(rotors, 0), MotorInfo(0.55, 0.95, 0.0, LEAST, 0, ())


ROS2_DIALECT = Dialect(_topics, OwnNames, _known)
