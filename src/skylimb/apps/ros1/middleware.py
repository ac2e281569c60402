"""What a node needs of ROS 1 before its process begins."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.analysis.exchange.message_types import Definitions
from skylimb.apps.ros.bridge import Middleware
from skylimb.apps.ros.profile import ProfileTopics
from skylimb.apps.ros1.installation import (
    by_clock,
    described_mass,
    require_alone,
    require_loopback,
    require_master,
    require_ros,
)
from skylimb.base.errors import ConfigError


def _require(anywhere: bool) -> None:
    require_ros()
    require_loopback(anywhere)


def _reach(profile: str, topics: ProfileTopics, namespace: str) -> None:
    require_master(profile)
    sensors, commands = ({one.full(namespace) for one in part} for part in (topics.sensors, topics.commands))
    require_alone(profile, sensors, commands)


def say_left_out(
    profile: str, topics: Sequence[Topic], messages: Sequence[str], say: Callable[[str], None]
) -> None:
    """Say which topics are left out as their type is not known.

    Raises:
        ConfigError: for a profile that talks to a robot, which needs them all.
    """
    definitions = Definitions(messages)
    unknown = {
        topic.name: topic.type.replace("/msg/", "/") for topic in topics if not definitions.knows(topic.type)
    }
    missing = ", ".join(sorted(set(unknown.values())))
    if missing and profile == "both":
        say(f"left out: {', '.join(unknown)}, as no definition of {missing} is known (--messages)")
    elif missing:
        raise ConfigError(
            f"no definition of {missing}: name the robot's own checkout with --messages DIR, as "
            "definitions have changed"
        )


ROS1 = Middleware("ROS 1", "skylimb.apps.ros1", _require, _reach, say_left_out, described_mass, by_clock)
