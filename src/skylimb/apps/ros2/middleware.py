"""What a node needs of ROS 2 before its process begins."""

from __future__ import annotations

import os
from collections.abc import Iterator

from skylimb.analysis.exchange.ros2_topics import SCENE, described
from skylimb.apps.ros.bridge import Middleware
from skylimb.apps.ros.messages import Outgoing
from skylimb.apps.ros2.dialect import ROS2_DIALECT
from skylimb.apps.ros2.scene import scene
from skylimb.apps.ros2.services import PARAMETERS, Parameter
from skylimb.base.errors import ConfigError, extra_module
from skylimb.base.keys.listing import described as keys_of
from skylimb.flight.plan import FlightPlan


def _require(anywhere: bool) -> None:
    """Raise where DDS or the types are not installed, or the domain is no number."""
    extra_module("cyclonedds")
    extra_module("rosbags")
    number = os.environ.get("ROS_DOMAIN_ID") or "0"
    if not number.isdecimal() or int(number) > 232:
        raise ConfigError(f"ROS_DOMAIN_ID = '{number}' is not a number from 0 to 232")


def _opening(plan: FlightPlan) -> list[Outgoing]:
    """The robot's URDF, what stands around it, and what it is flown with."""
    said = [Outgoing(*one) for one in described(plan.robot)]
    return [*said, Outgoing(SCENE, scene(plan)), Outgoing(PARAMETERS, list(_parameters(plan)))]


def _parameters(plan: FlightPlan) -> Iterator[Parameter]:
    for name, value, info in keys_of(plan.experiment):
        if isinstance(value, bool | int | float | str):
            more = ", ".join(filter(None, (info.unit, info.range)))
            words = f"{info.meaning} ({more})" if more else info.meaning
            yield name, value, words, info.key.low, info.key.high


ROS2 = Middleware("ROS 2", "skylimb.apps.ros2", _require, dialect=ROS2_DIALECT, opening=_opening)
