import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skylimb.base.errors import SkylimbError
from skylimb.simulation.sensors import (
    SensorConfig,
    SensorNoise,
    draw_noise,
    frame_ages,
    history_depth,
    initial_sensor_state,
    no_failure,
    sense,
)

SILENT = SensorNoise(np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(4))

WORKS = no_failure(7)


def root_at(t: float) -> np.ndarray:
    """A root that moves at 1 m/s along x and turns slowly about z."""
    half = 0.5 * 0.2 * t
    return np.array([t, 0.0, 1.0, np.cos(half), 0.0, 0.0, np.sin(half), 1.0, 0.0, 0.0, 0.0, 0.0, 0.2])


@given(rate=st.sampled_from([0.0, 40.0, 60.0, 100.0, 333.0]), latency=st.floats(0.0, 0.05))
@settings(max_examples=30, deadline=None)
def test_a_measurement_is_the_past_by_the_frames_age(rate: float, latency: float) -> None:
    dt, config = 0.005, SensorConfig(rate=rate, latency=latency)
    times = np.arange(60) * dt
    ages = frame_ages(config, times)
    state = initial_sensor_state(config, dt, root_at(0.0), np.zeros(7))
    assert len(state.history) == history_depth(config, dt)
    for t, age in zip(times, ages, strict=True):
        state, seen = sense(state, root_at(t), np.zeros(3), np.zeros(4), age, SILENT, dt, WORKS)
        assert seen.position[0] == pytest.approx(max(t - age, 0.0), abs=dt * 0.2 if t < age + dt else 1e-9)
        assert np.linalg.norm(seen.quaternion) == pytest.approx(1.0)


def test_a_frame_stays_until_the_next_one() -> None:
    config = SensorConfig(rate=100.0, latency=0.010)
    times = np.arange(8) * 0.005
    np.testing.assert_allclose(
        times - frame_ages(config, times), [-0.01, -0.01, 0.0, 0.0, 0.01, 0.01, 0.02, 0.02], atol=1e-12
    )


def test_noise_has_the_asked_deviation_and_keeps_with_its_frame() -> None:
    config, times = SensorConfig(), np.arange(8000) * 0.005
    noise = draw_noise(config, times, 3, 4, np.random.default_rng(3))
    np.testing.assert_array_equal(noise.position[0::2], noise.position[1::2])
    assert noise.position.std() == pytest.approx(config.position_noise, rel=0.03)
    assert noise.angular_velocity.std() == pytest.approx(config.angular_velocity_noise, rel=0.03)
    assert noise.joint_angles.std() == pytest.approx(config.joint_noise, rel=0.03)
    assert np.abs(np.diff(noise.joint_angles, axis=0)).min() > 0.0


def test_misalignment_turns_the_measured_attitude() -> None:
    config = SensorConfig(rate=0.0, latency=0.0, attitude_noise=0.0, attitude_misalignment=(0.01, 0.0, 0.0))
    state = initial_sensor_state(config, 0.005, root_at(0.0), np.zeros(7))
    errors = draw_noise(config, np.zeros(1), 3, 4, np.random.default_rng(0))
    row = SensorNoise(*(entry[0] for entry in errors))
    _, seen = sense(state, root_at(0.0), np.zeros(3), np.zeros(4), 0.0, row, 0.005, WORKS)
    np.testing.assert_allclose(seen.quaternion, [np.cos(0.005), np.sin(0.005), 0.0, 0.0], atol=1e-7)


@pytest.mark.parametrize(
    "bad", [{"latency": 10.0}, {"rate": -1.0}, {"attitude_misalignment": (1.0, 0.0, 0.0)}]
)
def test_nonsense_is_refused(bad: dict[str, float]) -> None:
    with pytest.raises(SkylimbError, match=next(iter(bad))):
        SensorConfig(**bad)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("rate", "latency", "depth"),
    [(0.0, 0.0, 1), (0.0, 0.02, 5), (100.0, 0.02, 6), (200.0, 0.02, 5), (150.0, 0.02, 7)],
)
def test_the_history_is_as_deep_as_the_oldest_state_needs(rate: float, latency: float, depth: int) -> None:
    """At 5 ms a tick: the latency, and a frame's time, less a tick where frames and ticks keep step."""
    assert history_depth(SensorConfig(rate=rate, latency=latency), 0.005) == depth


def test_errors_are_added_to_the_encoders() -> None:
    noise = SensorNoise(*(np.full(n, 0.01 * k) for k, n in enumerate((3, 3, 3, 3, 2, 4), 1)))
    root = np.array([*np.zeros(3), 1.0, *np.zeros(9)])
    state = initial_sensor_state(SensorConfig(rate=0.0, latency=0.0), 0.005, root, np.zeros(6))
    _, seen = sense(state, root, np.ones(2), np.ones(4), 0.0, noise, 0.005, no_failure(6))
    np.testing.assert_allclose(seen.joint_angles, 1.05)
    np.testing.assert_allclose(seen.vectoring_angles, 1.06)
    np.testing.assert_allclose(seen.position, 0.01)
