import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skylimb.base.config import from_mapping, to_mapping
from skylimb.base.errors import ConfigError
from skylimb.control.planning.trajectories import trajectory
from skylimb.control.planning.trajectory_config import TrajectoryConfig

FIGURE = ((0.0, 0.0), (0.4, 0.1), (0.41, 0.1), (0.0, 0.5), (0.0, -0.5))
SHAPES = [
    TrajectoryConfig(shape="hold"),
    TrajectoryConfig(shape="circle"),
    TrajectoryConfig(shape="circle", direction=-1, ramp=2.0, laps=1.5, start_angle=1.0),
    TrajectoryConfig(shape="circle", ramp=14.0),
    TrajectoryConfig(shape="lemniscate"),
    TrajectoryConfig(shape="lemniscate", direction=-1, ramp=3.0),
    TrajectoryConfig(shape="line", angle=0.7),
    TrajectoryConfig(shape="line", length=0.02, speed=1.0),
    TrajectoryConfig(shape="lawnmower"),
    TrajectoryConfig(shape="lawnmower", strokes=1, direction=-1),
    TrajectoryConfig(shape="waypoints", waypoints=FIGURE),
    TrajectoryConfig(shape="waypoints", waypoints=FIGURE, direction=-1, acceleration=2.0),
]
names = [f"{i}-{config.shape}" for i, config in enumerate(SHAPES)]
every_shape = pytest.mark.parametrize("config", SHAPES, ids=names)
resting = pytest.mark.parametrize(
    "config", [c for c in SHAPES if c.ramp > 0 or c.shape not in ("circle", "lemniscate")]
)


@every_shape
def test_derivatives_match_finite_differences(config):
    path = trajectory(config)
    h = 1e-4
    t = np.linspace(2 * h, path.duration - 2 * h, 1501)
    _, velocity, acceleration = path.sample(t)
    (before, v_before, _), (after, v_after, _) = path.sample(t - h), path.sample(t + h)
    np.testing.assert_allclose((after - before) / (2 * h), velocity, atol=1e-6)
    np.testing.assert_allclose((v_after - v_before) / (2 * h), acceleration, atol=1e-5)


@every_shape
def test_acceleration_is_continuous(config):
    path = trajectory(config)
    t = np.linspace(0.0, path.duration, 40_001)
    acceleration = path.sample(t)[2]
    jumps = np.linalg.norm(np.diff(acceleration, axis=0), axis=1)
    assert jumps.max() <= 0.01 * max(np.linalg.norm(acceleration, axis=1).max(), 1e-9)


@resting
def test_it_starts_and_ends_at_rest(config):
    path = trajectory(config)
    _, velocity, acceleration = path.sample(np.array([0.0, path.duration]))
    np.testing.assert_allclose(velocity, 0.0, atol=1e-12)
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-9)


@every_shape
def test_it_rests_at_its_end_points_outside_of_its_duration(config):
    path = trajectory(config)
    position, velocity, acceleration = path.sample(np.array([-1.0, 0.0, path.duration, path.duration + 1.0]))
    np.testing.assert_array_equal(position[0], position[1])
    np.testing.assert_array_equal(position[3], position[2])
    assert not velocity[[0, 3]].any()
    assert not acceleration[[0, 3]].any()


def test_the_papers_circle():
    path = trajectory(TrajectoryConfig())
    assert path.duration == 14.0
    position, velocity, acceleration = path.sample(np.linspace(0.0, 14.0, 57))
    np.testing.assert_allclose(np.linalg.norm(position, axis=1), 0.30, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(velocity, axis=1), 0.30 * 2 * np.pi / 14.0, rtol=1e-12)
    np.testing.assert_allclose(acceleration, -((2 * np.pi / 14.0) ** 2) * position, atol=1e-12)
    np.testing.assert_allclose(position[0], [0.0, -0.30], atol=1e-12)  # from the bottom
    np.testing.assert_allclose(position[14], [0.30, 0.0], atol=1e-12)  # first toward +u
    np.testing.assert_allclose(position[-1], position[0], atol=1e-12)


def test_the_other_direction_mirrors_the_circle():
    t = np.linspace(0.0, 14.0, 29)
    there = trajectory(TrajectoryConfig()).sample(t)[0]
    back = trajectory(TrajectoryConfig(direction=-1)).sample(t)[0]
    np.testing.assert_allclose(back, there * [-1, 1], atol=1e-12)


def test_a_ramped_circle_closes_and_takes_one_ramp_longer():
    path = trajectory(TrajectoryConfig(ramp=2.0, laps=2.0))
    assert path.duration == 30.0
    position, velocity, _ = path.sample(np.array([0.0, 15.0, 30.0]))
    np.testing.assert_allclose(position[2], position[0], atol=1e-12)
    assert np.linalg.norm(velocity[1]) == pytest.approx(0.30 * 2 * np.pi / 14.0)


def test_the_lemniscate_crosses_itself_in_the_middle():
    position, _, _ = trajectory(TrajectoryConfig(shape="lemniscate")).sample(np.linspace(0.0, 14.0, 1001))
    np.testing.assert_allclose(position[[0, -1]], [[-0.30, 0.0]] * 2, atol=1e-12)
    np.testing.assert_allclose(position[[250, 750]], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.abs(position).max(axis=0), [0.30, 0.15], atol=1e-6)


def test_a_line_holds_its_speed_in_between():
    config = TrajectoryConfig(shape="line", length=1.0, angle=math.pi / 2, speed=0.2)
    path = trajectory(config)
    position, velocity, _ = path.sample(np.linspace(0.0, path.duration, 1001))
    np.testing.assert_allclose(position[[0, -1]], [[0.0, -0.5], [0.0, 0.5]], atol=1e-12)
    np.testing.assert_allclose(position[:, 0], 0.0, atol=1e-12)
    assert velocity[500, 1] == pytest.approx(0.2)
    assert velocity[:, 1].max() <= 0.2 + 1e-12


def test_a_lawnmower_covers_every_stroke():
    path = trajectory(
        TrajectoryConfig(shape="lawnmower", strokes=3, spacing=0.2, length=0.8, acceleration=1.0)
    )
    position, _, _ = path.sample(np.linspace(0.0, path.duration, 4001))
    np.testing.assert_allclose(position[[0, -1]], [[-0.4, -0.2], [0.4, 0.2]], atol=1e-12)
    for level in (-0.2, 0.0, 0.2):
        stroke = position[np.abs(position[:, 1] - level) < 1e-9, 0]
        assert stroke.min() < -0.35
        assert stroke.max() > 0.35


points = st.lists(
    st.tuples(st.integers(-20, 20), st.integers(-20, 20)), min_size=2, max_size=6, unique=True
).map(lambda grid: tuple((0.05 * u, 0.05 * v) for u, v in grid))


@settings(max_examples=60, deadline=None)
@given(points, st.floats(0.02, 1.0), st.floats(0.1, 5.0))
def test_waypoints_keep_to_speed_acceleration_and_ends(waypoints, speed, acceleration):
    path = trajectory(
        TrajectoryConfig(shape="waypoints", waypoints=waypoints, speed=speed, acceleration=acceleration)
    )
    t = np.linspace(0.0, path.duration, 2001)
    position, velocity, bend = path.sample(t)
    np.testing.assert_allclose(position[0], waypoints[0], atol=1e-9)
    np.testing.assert_allclose(position[-1], waypoints[-1], atol=1e-9)
    assert np.linalg.norm(velocity, axis=1).max() <= speed * (1 + 1e-9)
    assert np.linalg.norm(bend, axis=1).max() <= acceleration * (1 + 1e-9)


def test_sharper_corners_pass_nearer():
    def miss(acceleration: float) -> float:
        path = trajectory(
            TrajectoryConfig(shape="waypoints", waypoints=((0, 0), (1, 0), (1, 1)), acceleration=acceleration)
        )
        position, _, _ = path.sample(np.linspace(0.0, path.duration, 20_001))
        return float(np.linalg.norm(position - [1.0, 0.0], axis=1).min())

    assert miss(0.3) < 0.02
    assert miss(3.0) < 0.1 * miss(0.3) + 1e-4


def test_reversed_waypoints_end_where_the_others_began():
    forward = TrajectoryConfig(shape="waypoints", waypoints=FIGURE)
    path = trajectory(replace(forward, direction=-1))
    position, _, _ = path.sample(np.array([0.0, path.duration]))
    np.testing.assert_allclose(position, [FIGURE[-1], FIGURE[0]], atol=1e-12)


@every_shape
def test_a_table_gives_the_same_path(config):
    assert from_mapping(TrajectoryConfig, to_mapping(config), "table") == config


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"shape": "cirle"}, "did you mean 'circle'"),
        ({"radius": 300}, "300 mm = 0.3 m"),
        ({"radius": -0.3}, "radius = -0.3 m is outside"),
        ({"radius": math.nan}, "radius = nan"),
        ({"period": -14.0}, "period = -14 s is outside"),
        ({"period": 14000}, "14000 ms = 14 s"),
        ({"direction": 0}, "direction = 0 is not one of 1, -1"),
        ({"direction": 2}, "direction = 2"),
        ({"start_angle": -90}, "-90 deg = -1.571 rad"),
        ({"laps": 0}, "laps = 0"),
        ({"ramp": -1}, "ramp = -1 s"),
        ({"ramp": 15}, "ramp = 15 s is longer"),
        ({"speed": 0}, "speed = 0 m/s"),
        ({"strokes": 0}, "strokes = 0"),
        ({"strokes": 2.5}, "expected a whole number"),
        ({"shape": "waypoints"}, "has 0 points; it needs at least 2"),
        ({"shape": "waypoints", "waypoints": [[0, 0]]}, "has 1 points"),
        ({"shape": "waypoints", "waypoints": [[0, 0], [0, 0]]}, "point 2 repeats"),
        ({"shape": "waypoints", "waypoints": [[0, 0], [300, 0]]}, "300 mm = 0.3 m"),
        ({"feedforward": "positions"}, "feedforward"),
        ({"radios": 0.2}, "did you mean 'radius'"),
    ],
)
def test_nonsense_is_refused_on_one_line(table, words):
    with pytest.raises(ConfigError) as caught:
        from_mapping(TrajectoryConfig, table, "trajectory")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_nonsense_is_refused_in_python_as_well():
    with pytest.raises(ConfigError, match=r"TrajectoryConfig\.strokes = 2\.5 .* expected a whole number"):
        TrajectoryConfig(strokes=2.5)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match=r"TrajectoryConfig\.radius"):
        TrajectoryConfig(radius="wide")  # type: ignore[arg-type]


def test_small_strokes_are_told_from_large_ones():
    """Once the pen comes back from a lift it is the next stroke that counts."""
    words = trajectory(TrajectoryConfig(shape="drawing", text="aerial", width=0.0, height=0.03))
    assert all(words.small)
    np.testing.assert_array_equal(words.fine(np.linspace(-1.0, words.duration + 1.0, 50)), 1.0)
    i = trajectory(TrajectoryConfig(shape="drawing", text="i", width=0.0, height=0.2))
    assert sorted(i.small) == [False, True]
    ((leave, back),) = i.lifts
    at = i.fine(np.array([-1.0, 0.5 * leave, back - 0.01, back + 0.01, i.duration]))
    np.testing.assert_array_equal(at, np.array(i.small, dtype=float)[[0, 0, 0, 1, 1]])
    circle = trajectory(TrajectoryConfig(shape="circle", radius=0.01))
    np.testing.assert_array_equal(circle.fine(np.array([0.0, 1.0])), 0.0)
