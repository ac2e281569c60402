"""Velocities from poses that come in frames."""

import numpy as np

from skylimb.flight.replay.rates import CUTOFF, angular_velocities, velocities

TIMES = np.arange(0.0, 2.0, 0.005)
FRAMES = np.floor(TIMES * 100.0 + 1e-9) / 100.0  # a pose stays for two ticks


def test_a_steady_motion_has_its_velocity() -> None:
    speed = np.array([0.3, -0.2, 0.1])
    found = velocities(TIMES, 1.0 + np.outer(FRAMES, speed))
    assert np.all(found[0] == 0.0)
    np.testing.assert_allclose(found[100:], np.tile(speed, (300, 1)), rtol=1e-9)
    # A frame that is held comes back with other last digits.
    jittered = np.outer(FRAMES, speed) + np.where(np.arange(len(TIMES)) % 2, 1e-15, 0.0)[:, None]
    np.testing.assert_allclose(velocities(TIMES, jittered), found, atol=1e-9)
    step = 1.0 - np.exp(-2.0 * np.pi * CUTOFF * 0.01)
    np.testing.assert_allclose(found[2], step * speed, rtol=1e-9)


def test_a_steady_turn_has_its_rate_in_the_bodys_axes() -> None:
    angle, rate = 0.7 * FRAMES, np.array([0.0, 0.0, 0.7])
    turned = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    np.testing.assert_allclose(angular_velocities(TIMES, turned)[100:], np.tile(rate, (300, 1)), rtol=1e-9)
    # A quaternion and its negative are one attitude.
    turned[::4] *= -1.0
    turned[1::4] *= -1.0
    np.testing.assert_allclose(angular_velocities(TIMES, turned)[100:], np.tile(rate, (300, 1)), rtol=1e-9)
    # Rolled first: the world's z is the body's y.
    rolled = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    half = np.sqrt(0.5)
    w, z = rolled[:, 0], rolled[:, 3]
    rolled = half * np.stack([w, w, z, z], axis=1)
    expected = np.tile([0.0, 0.7, 0.0], (300, 1))
    np.testing.assert_allclose(angular_velocities(TIMES, rolled)[100:], expected, atol=1e-9)


def test_what_stands_still_has_none() -> None:
    assert np.all(velocities(TIMES, np.ones((len(TIMES), 3))) == 0.0)
