"""What ROS 1's rim says before a node begins."""

from __future__ import annotations

import pytest

from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.apps.ros.profile import PROFILES
from skylimb.apps.ros1.rim import say_left_out
from skylimb.base.errors import ConfigError


@pytest.mark.parametrize("profile", PROFILES)
def test_only_the_profile_without_a_robot_does_without_unknown_types(profile: str) -> None:
    known, unknown = Topic("joints", "sensor_msgs/msg/JointState"), Topic("odd", "lab/msg/Odd")
    said: list[str] = []
    say_left_out(profile, (known,), (), said.append)
    assert said == []
    if profile == "both":
        say_left_out(profile, (known, unknown), (), said.append)
        assert said == ["left out: odd, as no definition of lab/Odd is known (--messages)"]
    else:
        with pytest.raises(ConfigError, match=r"^no definition of lab/Odd: name the robot"):
            say_left_out(profile, (known, unknown), (), said.append)
