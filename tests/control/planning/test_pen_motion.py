import numpy as np
import pytest
from scipy.spatial import KDTree

from skylimb.base.config import from_mapping, to_mapping
from skylimb.base.errors import ConfigError
from skylimb.control.planning.drawing import Strokes
from skylimb.control.planning.pen_motion import ROUNDING, pen_motion
from skylimb.control.planning.trajectories import drawing_strokes, trajectory
from skylimb.control.planning.trajectory_config import TrajectoryConfig

WORDS = TrajectoryConfig(shape="drawing", text="Sky", width=0.4, speed=0.08, acceleration=0.3)


def dense(lines):
    places = [np.linspace(0, len(line) - 1, 400 * len(line)) for line in lines]
    return np.vstack(
        [
            np.stack([np.interp(place, np.arange(len(line)), axis) for axis in line.T], axis=1)
            for line, place in zip(lines, places, strict=True)
        ]
    )


@pytest.fixture(scope="module")
def words():
    path = trajectory(WORDS)
    t = np.arange(0.0, path.duration, 0.002)
    return path, t, path.sample(t)


def test_speed_and_acceleration_stay_within_bounds(words):
    _, _, (_, velocity, acceleration) = words
    assert np.linalg.norm(velocity, axis=1).max() <= 0.08 * (1 + 1e-9)
    assert np.linalg.norm(acceleration, axis=1).max() <= 0.3 * 1.05


def test_derivatives_match_and_are_continuous(words):
    path, _, _ = words
    h, t = 1e-4, np.linspace(0.01, path.duration - 0.01, 1501)
    (_, velocity, acceleration), before, after = path.sample(t), path.sample(t - h), path.sample(t + h)
    np.testing.assert_allclose((after[0] - before[0]) / (2 * h), velocity, atol=1e-6)
    # The acceleration is straight between two control points and bends at each.
    np.testing.assert_allclose((after[1] - before[1]) / (2 * h), acceleration, atol=3e-4)
    fine = path.sample(np.arange(0.0, path.duration, 1e-4))[2]
    assert np.linalg.norm(np.diff(fine, axis=0), axis=1).max() < 0.01 * 0.3


def test_it_rests_at_both_ends_and_outside_of_its_duration(words):
    path, _, _ = words
    position, velocity, acceleration = path.sample(np.array([-1.0, 0.0, path.duration, path.duration + 1.0]))
    np.testing.assert_array_equal(position[[0, 3]], position[[1, 2]])
    np.testing.assert_allclose(velocity, 0.0, atol=1e-12)
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-9)
    lines = drawing_strokes(WORDS).lines
    np.testing.assert_allclose(position[[1, 2]], [lines[0][0], lines[-1][-1]], atol=1e-12)


def test_a_table_gives_the_same_drawing():
    assert from_mapping(TrajectoryConfig, to_mapping(WORDS), "table") == WORDS


def test_the_pen_keeps_to_the_line_and_draws_all_of_it(words):
    path, t, (position, _, _) = words
    asked = dense(drawing_strokes(WORDS).lines)
    down = path.touching(t)
    assert KDTree(asked).query(position[down])[0].max() <= 1.2 * ROUNDING
    assert KDTree(position[down]).query(asked)[0].max() <= 1.5 * ROUNDING


def test_the_pen_is_up_between_strokes_and_rests_while_it_goes_and_comes(words):
    path, t, (_, velocity, _) = words
    assert len(path.lifts) == len(drawing_strokes(WORDS).lines) - 1
    part, rate, _ = path.lifted(t)
    assert part.min() >= -1e-12
    assert part.max() <= 1.0 + 1e-12
    moving = np.abs(rate) > 0.0
    assert np.linalg.norm(velocity[moving], axis=1).max() < 0.01
    travelling = (part > 1.0 - 1e-12) & (np.linalg.norm(velocity, axis=1) > 0.04)
    assert travelling.any()
    assert not path.touching(t)[travelling].any()
    assert (path.touching(t) | (part > 0.0) | (rate == 0.0)).all()
    leave, back = path.lifts[0]
    np.testing.assert_array_equal(
        path.touching([leave - 0.01, leave, back - 0.01, back]), [True, False, False, True]
    )
    np.testing.assert_allclose(
        path.lifted([leave, leave + 2.0, back, back + 2.0])[0], [0, 1, 1, 0], atol=1e-12
    )


def test_the_lift_is_smooth(words):
    path, _, _ = words
    h, t = 1e-4, np.linspace(0.01, path.duration - 0.01, 1201)
    (_, rate, bend), before, after = path.lifted(t), path.lifted(t - h), path.lifted(t + h)
    np.testing.assert_allclose((after[0] - before[0]) / (2 * h), rate, atol=1e-6)
    np.testing.assert_allclose((after[1] - before[1]) / (2 * h), bend, atol=1e-5)


def test_other_shapes_always_touch():
    path = trajectory(TrajectoryConfig())
    t = np.linspace(-1.0, 20.0, 50)
    assert path.touching(t).all()
    assert not path.lifted(t)[0].any()
    assert path.touching(3.0)


def test_a_straight_line_is_drawn_at_full_speed_and_as_fast_as_can_be():
    line = np.array([[0.0, 0.0], [0.6, 0.0]])
    motion = pen_motion(Strokes((line,)), 0.1, 0.3, 2.0)
    assert motion.duration == pytest.approx(0.6 / 0.1 + 0.1 / 0.3, abs=0.2)
    t = np.linspace(0.0, motion.duration, 1001)
    assert np.linalg.norm(motion.position.derivative()(t), axis=1)[500] == pytest.approx(0.1, rel=0.01)
    np.testing.assert_allclose(motion.position(t)[[0, -1]], line, atol=1e-12)


def test_a_circle_is_slowed_by_its_bend():
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = 0.01 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    motion = pen_motion(Strokes((circle,)), 0.2, 0.3, 2.0)
    middle = np.linspace(0.4, 0.6, 50) * motion.duration
    speed = np.linalg.norm(motion.position.derivative()(middle), axis=1)
    np.testing.assert_allclose(speed, np.sqrt(0.3 * 0.01), rtol=0.1)
    np.testing.assert_allclose(np.linalg.norm(motion.position(middle), axis=1), 0.01, atol=ROUNDING)


def test_sharp_corners_are_met_at_rest_and_gentle_ones_rounded():
    corner = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]])
    motion = pen_motion(Strokes((corner,)), 0.1, 0.3, 2.0)
    t = np.linspace(0.0, motion.duration, 5001)
    miss = np.linalg.norm(motion.position(t) - [0.1, 0.0], axis=1)
    nearest = int(np.argmin(miss))
    assert miss[nearest] < 2e-4
    assert np.linalg.norm(motion.position.derivative()(t[nearest])) < 0.01
    gentle = np.array([[0.0, 0.0], [0.1, 0.0], [0.2, 0.05]])
    motion = pen_motion(Strokes((gentle,)), 0.1, 0.3, 2.0)
    t = np.linspace(0.2, motion.duration - 0.2, 5001) * 1.0
    speed = np.linalg.norm(motion.position.derivative()(t), axis=1)
    assert speed[1000:4000].min() > 0.03
    assert np.linalg.norm(motion.position(t) - [0.1, 0.0], axis=1).min() < ROUNDING


def test_tiny_strokes_are_drawn_too():
    dot = np.array([[0.0, 0.0], [0.0002, 0.0]])
    motion = pen_motion(Strokes((dot, dot + 0.1)), 0.1, 0.3, 0.5)
    t = np.linspace(0.0, motion.duration, 1001)
    assert np.isfinite(motion.position(t)).all()
    assert np.linalg.norm(motion.position.derivative()(t), axis=1).max() <= 0.1 * (1 + 1e-9)


def test_the_other_direction_draws_backwards():
    forward, backward = trajectory(WORDS), trajectory(TrajectoryConfig(**{**vars(WORDS), "direction": -1}))
    np.testing.assert_allclose(backward.sample(0.0)[0], forward.sample(forward.duration)[0], atol=1e-12)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, "trajectory.file or trajectory.text"),
        ({"file": "a.svg", "text": "b"}, "not both"),
        ({"text": "hi", "width": 0.0}, "width or trajectory.height"),
        ({"text": "hi", "width": -1.0}, "width"),
        ({"text": "hi", "width": float("nan")}, "width"),
        ({"text": "hi", "lift_time": 0.0}, "lift_time"),
        ({"text": "hi", "order": "random"}, "order"),
    ],
)
def test_drawings_that_cannot_be_are_refused(values, words):
    with pytest.raises(ConfigError, match=words):
        TrajectoryConfig(shape="drawing", **values)
