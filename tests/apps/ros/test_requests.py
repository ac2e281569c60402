"""What users ask of a hovering robot: bounded, or refused in words."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange.messages import Joints, Nav, Path, Pose
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.requests import RefusedError, Requests
from skylimb.apps.ros.targets import Place, Targets

LEVEL = (1.0, 0.0, 0.0, 0.0)
START = Place(np.array([0.0, 0.0, 1.0]), 0.0, 0.5)
STANDS = np.array([math.pi / 2 - 0.5, 1.0, -0.5])
"""Joint angles of the family's posture of 0.5 rad."""

NAV = Nav(0, 0, 0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@pytest.fixture(scope="module")
def ask() -> Callable[..., Targets]:
    requests = Requests(skylimb.load_robot("hydrus_xi_quad"), FlightLimits())

    def asked(message: Any, now: float = 10.0, offset: float = 0.0) -> Any:
        if isinstance(message, Joints):
            return requests.in_family(requests.joints(message, STANDS))
        return requests.targets(Targets(START, now), message, now, offset)

    return asked


def flown(targets: Targets, end: float, step: float = 0.01) -> list[np.ndarray]:
    """Positions from time 10 to `end`."""
    found, now = [], 10.0
    while now < end:
        targets, target = targets.at(now)
        found.append(target.place.position)
        now += step
    return found


def test_a_pose_is_reached_in_the_labs_time(ask: Any) -> None:
    quarter = (math.cos(math.pi / 4), 0.0, 0.0, math.sin(math.pi / 4))
    out = ask(Pose(10.0, (2.0, 0.0, 1.0), quarter))
    assert out.legs[0].duration == pytest.approx((math.pi / 2) / 0.3)
    assert ask(Pose(10.0, (2.0, 0.0, 1.0), LEVEL)).legs[0].duration == pytest.approx(4.0)
    assert ask(Pose(10.0, (0.1, 0.0, 1.0), LEVEL)).legs[0].duration == 2.0
    assert ask(Pose(17.0, (0.1, 0.0, 1.0), LEVEL)).legs[0].duration == pytest.approx(7.0)
    assert ask(Pose(11.0, (2.0, 0.0, 1.0), LEVEL)).legs[0].duration == pytest.approx(4.0)
    assert ask(Pose(4.0, (0.1, 0.0, 1.0), LEVEL), offset=13.0).legs[0].duration == pytest.approx(7.0)
    way = np.array(flown(ask(Pose(10.0, (2.0, 0.0, 1.0), LEVEL)), 15.0))
    np.testing.assert_allclose(way[-1], [2.0, 0.0, 1.0], atol=1e-9)
    assert np.diff(way[:, 0]).max() / 0.01 < 1.0


@pytest.mark.parametrize("frame", ["", "world", "/world"])
def test_targets_are_in_the_world(ask: Any, frame: str) -> None:
    pose = Pose(10.0, (0.1, 0.0, 1.0), LEVEL, frame)
    for out in (ask(pose), ask(Path((pose,), frame))):
        np.testing.assert_array_equal(out.legs[0].end.position, [0.1, 0.0, 1.0])


@pytest.mark.parametrize("ahead", [301.0, 3600.0, 1.7e9])
def test_a_stamp_of_another_clock_is_refused_and_says_so(ask: Any, ahead: float) -> None:
    """An hour between two clocks had the robot creep for an hour."""
    with pytest.raises(RefusedError, match=r"its stamp lies .* s ahead \(at most 300\): the sender's clock"):
        ask(Pose(10.0 + ahead, (0.1, 0.0, 1.0), LEVEL))


def test_velocity_is_the_derivative_of_the_way(ask: Any) -> None:
    targets, step = ask(Pose(10.0, (1.0, 0.5, 1.5), LEVEL)), 1e-4
    for now in (10.5, 11.0, 11.9):
        before, here, after = (targets.at(now + k * step)[1] for k in (-1, 0, 1))
        slope = (after.place.position - before.place.position) / (2 * step)
        np.testing.assert_allclose(here.velocity, slope, atol=1e-6)
        np.testing.assert_allclose(
            here.acceleration, (after.velocity - before.velocity) / (2 * step), atol=1e-5
        )


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (Pose(0.0, (11.0, 0.0, 1.0), LEVEL), "more than 10 m away"),
        (Pose(0.0, (0.0, 0.0, 0.1), LEVEL), "below 0.3 m"),
        (Pose(0.0, (math.nan, 0.0, 1.0), LEVEL), "no number"),
        (Pose(0.0, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0)), "no unit quaternion"),
        (Pose(0.0, (0.0, 0.0, 1.0), (math.inf, 0.0, 0.0, 0.0)), "no unit quaternion"),
        (
            Pose(0.0, (1.0, 0.0, 1.0), LEVEL, "hydrus_xi/cog"),
            "it is in the frame 'hydrus_xi/cog', and targets are in 'world'",
        ),
        (Path((Pose(0.0, (1.0, 0.0, 1.0), LEVEL, ""),), "map"), "it is in the frame 'map'"),
        (Path((Pose(0.0, (1.0, 0.0, 1.0), LEVEL, "map"),)), "it is in the frame 'map'"),
        (Path(()), "without poses"),
        (Path((Pose(0.0, (1.0, 0.0, 1.0), LEVEL), Pose(0.0, (1.0, 0.0, 0.0), LEVEL))), "below 0.3 m"),
        (replace(NAV, xy_mode=3), "neither a position nor a velocity"),
        (replace(NAV, z_mode=200), "neither a position nor a velocity"),
        (replace(NAV, velocity=(math.inf, 0.0, 0.0)), "no number"),
        (replace(NAV, xy_mode=2, position=(50.0, 0.0, 0.0)), "more than 10 m away"),
        (Joints(0.0, ("joint9",), (1.0,)), "no joint is called 'joint9'"),
        (Joints(0.0, ("joint1", "joint1"), (1.0, 1.0)), "'joint1' is named more than once"),
        (Joints(0.0, (), (1.0,)), "joints and angles are not as many: 3 and 1"),
        (Joints(0.0, ("joint1",), (math.nan,)), "no number"),
        (Joints(0.0, ("joint1",), (1.9,)), "joint1 = 1.90 rad is beyond its -1.57 .. 1.57 rad"),
    ],
)
def test_what_cannot_be_is_refused(ask: Any, message: Any, words: str) -> None:
    with pytest.raises(RefusedError, match=re.escape(words)):
        ask(message)


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (Joints(0.0, tuple(f"joint{k}" for k in range(20_000)), (0.0,) * 20_000), "no joint is called"),
        (Joints(0.0, ("joint1",) * 20_000, (0.0,) * 20_000), "'joint1' is named more than once"),
        (Joints(0.0, ("x" * 900_000,), (0.0,)), "no joint is called 'xxx"),
        (Path(tuple(Pose(0.0, (0.0, 0.01 * (k % 2), 1.0), LEVEL) for k in range(8_000))), "8000 poses"),
    ],
)
def test_a_message_without_end_is_refused_within_a_tick_and_a_line(
    ask: Any, message: Any, words: str
) -> None:
    """A megabyte is what is read; looked through name by name, this took 10 s of a flight."""
    began = time.process_time()
    with pytest.raises(RefusedError, match=words) as caught:
        ask(message)
    assert time.process_time() - began < 0.5
    assert len(str(caught.value)) < 200


def test_steps_and_velocities_of_nav(ask: Any) -> None:
    step = ask(replace(NAV, xy_mode=2, position=(0.9, 0.0, 7.0)))
    assert step.legs[0].duration == pytest.approx(3.0)
    np.testing.assert_array_equal(step.legs[0].end.position, [0.9, 0.0, 1.0])
    way = np.array(flown(ask(replace(NAV, xy_mode=1, velocity=(0.2, 0.0, 9.0))), 12.0))
    np.testing.assert_allclose(way[-1], [0.1, 0.0, 1.0], atol=1e-9)  # 0.5 s, then it stays
    way = np.array(flown(ask(replace(NAV, xy_mode=1, z_mode=1, velocity=(30.0, 0.0, 40.0))), 12.0))
    np.testing.assert_allclose(way[-1] - way[0], [0.15, 0.0, 0.2], atol=1e-9)  # no faster than 0.5 m/s
    turned = ask(replace(NAV, yaw_mode=1, yaw_rate=5.0)).at(12.0)[0].place.yaw
    assert turned == pytest.approx(0.15)
    requests = Requests(skylimb.load_robot("hydrus_xi_quad"), FlightLimits())
    facing = Targets(START._replace(yaw=math.pi / 2), 10.0)
    local = requests.targets(facing, replace(NAV, xy_mode=1, velocity=(0.2, 0.0, 0.0), frame=1), 10.0, 0.0)
    np.testing.assert_allclose(flown(local, 12.0)[-1], [0.0, 0.1, 1.0], atol=1e-9)


def test_a_path_goes_through_its_poses_at_rest(ask: Any) -> None:
    out = ask(Path((Pose(0.0, (1.0, 0.0, 1.0), LEVEL), Pose(0.0, (1.0, 1.0, 1.0), LEVEL))))
    way = np.array(flown(out, 14.5))
    np.testing.assert_allclose(way[200], [1.0, 0.0, 1.0], atol=1e-3)
    np.testing.assert_allclose(way[-1], [1.0, 1.0, 1.0], atol=1e-9)


def test_joints_are_known_by_name_and_as_a_posture_of_the_family(ask: Any) -> None:
    assert ask(Joints(0.0, ("joint2", "joint1", "joint3"), (1.2, 0.97, -0.6))) == pytest.approx(0.6, abs=0.01)
    assert ask(Joints(0.0, (), (0.9708, 1.2, -0.6))) == pytest.approx(0.6, abs=1e-3)
    assert ask(Joints(0.0, ("gimbal1",), (3.0,))) == pytest.approx(0.5, abs=1e-9)
    assert ask(Joints(0.0, ("joint1",), (0.0,))) is None


def test_a_turn_goes_the_short_way(ask: Any) -> None:
    back = START._replace(yaw=3.0)
    out = Targets(back, 0.0).go(back._replace(yaw=-3.0), 0.0, 2.0)
    assert out.at(1.0)[1].place.yaw == pytest.approx(math.pi)
