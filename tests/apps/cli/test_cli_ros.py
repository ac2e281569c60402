"""From the words of `ros`, `ros2` and `fly` to what a node or a flight is asked to be; nothing is reached."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from skylimb.apps.cli import realtime
from skylimb.apps.cli import ros as verbs
from skylimb.apps.cli.arguments import parse
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.node_config import NodeConfig
from skylimb.apps.ros.run import Flown
from skylimb.base.errors import ConfigError
from skylimb.flight.realtime.timing import Timing

FENCE = ["--fence", "-2", "2", "-1.5", "2", "0", "3"]
BOUNDS = ((-2.0, 2.0), (-1.5, 2.0), (0.0, 3.0))


@pytest.fixture(params=["ros", "ros2"])
def asked(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Callable[..., NodeConfig]:
    """What `ros` or `ros2` makes of its words."""

    made: list[NodeConfig] = []

    def be(middleware: Any, profile: str, options: verbs.NodeOptions, **own: Any) -> int:
        made.append(verbs._asked(profile, options, **own))
        return 0

    monkeypatch.setattr(verbs, "_be", be)

    def call(*words: str) -> NodeConfig:
        parse(request.param, getattr(verbs, request.param), list(words))()
        return made[-1]

    return call


def test_a_fence_is_told_in_numbers_and_keeps_the_robot_in(asked: Callable[..., NodeConfig]) -> None:
    limits = asked("both", *FENCE).limits
    assert limits.fence == BOUNDS
    assert limits.outside(np.array([0.0, 0.0, 1.0])) == ""
    assert limits.outside(np.array([0.0, -1.6, 1.0])).startswith("y = -1.60 m is outside")
    assert asked("both").limits == FlightLimits()


@pytest.mark.parametrize(
    "words", [["--fence"], ["--fence", "1", "2", "3"], ["--fence", "1", "0", "0", "1", "0", "1"]]
)
def test_a_fence_that_is_none_is_refused_before_anything_is_reached(
    asked: Callable[..., NodeConfig], words: list[str]
) -> None:
    with pytest.raises(ConfigError, match=rf"^{' '.join(words)}: wanted are least and greatest x, y and z"):
        asked("both", *words)
    with pytest.raises(ConfigError, match=rf"^{' '.join(words)}: wanted"):
        parse("fly", realtime.fly, ["paper", "--udp", "127.0.0.1:9870", *words])()


def test_the_fence_of_fly_is_for_a_robot_alone() -> None:
    with pytest.raises(ConfigError, match="--check and --fence are for a robot"):
        parse("fly", realtime.fly, ["paper", "--realtime", *FENCE])()


@pytest.mark.parametrize("broken", ["", "the middleware's process is gone"])
def test_a_node_that_ends_by_itself_ends_with_1(broken: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """By which whoever supervises it knows that it was not its user."""
    timing = Timing(0.005, np.zeros(2), np.zeros(2), np.zeros(2, dtype=bool))
    monkeypatch.setattr("skylimb.apps.ros.run.run", lambda *given: Flown((), timing, {}, broken=broken))
    assert parse("ros", verbs.ros, ["both"])() == int(bool(broken))


def test_a_check_says_the_faults_of_what_came(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """They are why something is not known, and were kept to itself."""
    timing = Timing(0.005, np.zeros(2), np.zeros(2), np.zeros(2, dtype=bool))
    found = Flown((), timing, {"inbox: wrong md5 of imu": 7}, failed=("position",))
    monkeypatch.setattr("skylimb.apps.ros.run.run", lambda *given: found)
    assert parse("ros", verbs.ros, ["controller", "--bare", "--check"])() == 1
    said = capsys.readouterr()
    assert "wrong md5 of imu: 7 times" in said.out + said.err
