"""Encoders are smoothed as long as their motion allows: each by what predicts its left-out samples."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import savgol_filter

from skylimb.studies.calibration.smoothing import TIMES, smoothed

DT, NOISE = 0.005, 5e-4
TIME = np.arange(0.0, 20.0, DT)
USED = np.arange(100, len(TIME) - 100)


def noisy(angle: np.ndarray, seed: int = 3) -> np.ndarray:
    return angle[:, None] + np.random.default_rng(seed).normal(0.0, NOISE, (len(angle), 1))


def off(found: np.ndarray, true: np.ndarray) -> float:
    return float(np.std((found[:, 0] - true)[USED]))


@pytest.mark.parametrize("hertz", [0.0, 0.05, 0.5, 1.5, 4.0])
def test_no_single_time_is_clearly_better_than_the_one_that_is_chosen(hertz: float) -> None:
    angle = 0.3 * np.sin(2.0 * np.pi * hertz * TIME)
    measured = noisy(angle)
    found, _ = smoothed(measured, USED, DT)
    by_time = [
        off(np.asarray(savgol_filter(measured, 2 * round(0.5 * time / DT) + 1, 3, axis=0)), angle)
        for time in TIMES
    ]
    assert off(found, angle) < 1.1 * min(by_time)


def test_of_an_angle_that_rests_little_noise_is_left() -> None:
    angles, rates = smoothed(noisy(np.zeros_like(TIME)), USED, DT)
    assert off(angles, 0.0 * TIME) < 0.15 * NOISE
    assert off(rates, 0.0 * TIME) < 0.005


def test_each_angle_has_its_own_time() -> None:
    fast, still = 0.3 * np.sin(8.0 * np.pi * TIME), 0.0 * TIME
    both = np.hstack([noisy(fast, 4), noisy(still, 5)])
    together = smoothed(both, USED, DT)
    for column in (0, 1):
        for one, alone in zip(together, smoothed(both[:, [column]], USED, DT), strict=True):
            np.testing.assert_allclose(one[:, [column]], alone, atol=1e-12)


def test_robots_without_joints_and_short_records() -> None:
    none = smoothed(np.zeros((50, 0)), np.arange(50), DT)
    assert [part.shape for part in none] == [(50, 0), (50, 0)]
    angles, rates = smoothed(noisy(0.2 * TIME[:20]), np.arange(20), DT)
    np.testing.assert_allclose(angles[:, 0], 0.2 * TIME[:20], atol=3.0 * NOISE)
    assert rates.shape == (20, 1)
