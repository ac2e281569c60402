"""ROS is known in the bridge alone; where it is absent, one line says what to install."""

from __future__ import annotations

import re
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import skylimb
from skylimb.apps.cli.main import main
from skylimb.apps.ros.profile import profile_topics
from skylimb.apps.ros1 import installation
from skylimb.apps.ros1.installation import require_loopback, require_master
from skylimb.apps.ros1.middleware import ROS1
from skylimb.base.errors import ConfigError

SOURCE = Path(skylimb.__file__).parent
ROS = re.compile(r"^\s*(?:import|from) (rospy|rosgraph|genpy|genmsg|\w+_msgs)\b", re.MULTILINE)


def test_nothing_else_imports_ros() -> None:
    inside = [path for path in SOURCE.rglob("*.py") if ROS.search(path.read_text(encoding="utf-8"))]
    assert inside
    assert {path.parent for path in inside} == {SOURCE / "apps" / "ros1"}


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """What a command says where there is no ROS; it ends as a user's mistake does."""
    monkeypatch.setitem(sys.modules, "rospy", None)

    def said(*words: str) -> str:
        assert main(["ros", *words]) == 2
        return capsys.readouterr().err

    return said


def test_without_ros_one_line_says_what_to_install(tmp_path: Path, command: Callable[..., str]) -> None:
    said = command("both", "--out", str(tmp_path / "out"))
    assert said.startswith("skylimb: error: ROS 1 is not installed (")
    assert "apt-get install python3-rospy" in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_mistakes_are_said_before_ros_is_looked_for(command: Callable[..., str]) -> None:
    assert "PROFILE = 'bot' is not one of simulator, controller, both" in command("bot")
    said = command("controller")
    assert "the robot falls as it is" in said
    assert "--bare says that you know" in said
    assert "--cells = 99 is outside of 0 .. 20" in command("both", "--cells", "99")


def test_another_machine_only_by_a_flag(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://elsewhere:11311")
    with pytest.raises(ConfigError, match="--anywhere allows it"):
        require_loopback(False)
    require_loopback(True)
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:11311")
    monkeypatch.setenv("ROS_HOSTNAME", "outside")
    require_loopback(False)
    import os

    assert os.environ["ROS_IP"] == "127.0.0.1"
    assert "ROS_HOSTNAME" not in os.environ


def test_a_node_whose_name_is_taken_does_not_begin(
    master: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The master would shut the other one down, also in flight."""
    import rosgraph

    monkeypatch.setenv("ROS_MASTER_URI", master["ROS_MASTER_URI"])
    require_master("both")
    with socket.create_server(("127.0.0.1", 0)) as other:
        address = f"http://127.0.0.1:{other.getsockname()[1]}/"
        rosgraph.Master("/skylimb_both").registerSubscriber("/odd", "*", address)
        with pytest.raises(ConfigError, match=r"^node '/skylimb_both' runs already .* would end it"):
            require_master("both")
        require_master("controller")
    require_master("both")  # of a node that was killed only its name is left


@pytest.mark.parametrize(
    ("profile", "topic", "why"),
    [
        ("both", "four_axes/command", "both would publish it as well"),
        ("both", "mocap/pose", "both would publish it as well"),
        ("simulator", "imu", "simulator would publish it as well"),
        ("controller", "mocap/pose", "flies its robot itself"),
    ],
)
def test_a_node_beside_another_one_of_the_same_robot_does_not_begin(
    master: dict[str, str], monkeypatch: pytest.MonkeyPatch, profile: str, topic: str, why: str
) -> None:
    """`both` began beside a `controller` that may be flying: two spoke for one robot."""
    import rosgraph

    monkeypatch.setenv("ROS_MASTER_URI", master["ROS_MASTER_URI"])
    monkeypatch.setattr(installation, "_LEAVING", 0.2)
    topics, name = profile_topics(profile), f"/hydrus_xi/{topic}"

    def reach(namespace: str = "hydrus_xi") -> None:
        ROS1.reach(profile, topics, namespace)

    with socket.create_server(("127.0.0.1", 0)) as other:
        address = f"http://127.0.0.1:{other.getsockname()[1]}/"
        harmless = {"both": "battery_voltage_status", "simulator": "rpy/gain", "controller": "rpy/gain"}
        rosgraph.Master("/lab").registerPublisher(f"/hydrus_xi/{harmless[profile]}", "*", address)
        reach()
        rosgraph.Master("/theirs").registerPublisher(name, "*", address)
        if profile == "controller":
            rosgraph.Master("/theirs").registerPublisher("/hydrus_xi/four_axes/command", "*", address)
        reach("another")
        with pytest.raises(ConfigError, match=rf"^node '/theirs' publishes '/hydrus_xi/.*', and {why}; end"):
            reach()
    reach()  # of a node that was killed only its name is left
