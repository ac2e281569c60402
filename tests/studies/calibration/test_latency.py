"""The latency by a profile of the likelihood, on likelihoods that are made up."""

from __future__ import annotations

import numpy as np
import pytest

from skylimb.studies.calibration.latency import by_latency, likely_latency

BELIEF = (0.02, 0.02)
TICK, LATENCY, LAG = 0.005, 0, 1


def valley(truth: float, deviation: float, rough: float = 0.0):
    """A likelihood of (latency, lag) whose lag goes with the latency, and the search for its lag."""

    def lag(latency: float) -> float:
        return 0.05 - 0.9 * (latency - truth)

    def unlikely(theta: np.ndarray) -> float:
        ticks = 2.0 * np.pi * theta[LATENCY] / TICK
        beside = (theta[LAG] - lag(theta[LATENCY])) / 1e-4
        return float(((theta[LATENCY] - truth) / deviation) ** 2 + beside**2 + rough * np.sin(1.7 * ticks))

    def search(near: np.ndarray) -> np.ndarray:
        return np.array([near[LATENCY], lag(near[LATENCY])])

    return search, unlikely


@pytest.mark.parametrize(("truth", "deviation"), [(0.012, 0.004), (0.029, 0.003), (0.02, 0.006)])
@pytest.mark.parametrize("rough", [0.0, 3.0])
def test_a_latency_that_hardly_shows_is_found_from_wherever_the_search_ended(
    truth: float, deviation: float, rough: float
) -> None:
    search, unlikely = valley(truth, deviation, rough)
    for begin in (0.010, 0.022):
        found, along = by_latency(search(np.array([begin, 0.0])), LATENCY, search, unlikely, TICK, BELIEF)
        assert along is not None
        assert abs(found[LATENCY] - truth) < 1.96 * along[LATENCY]
        assert found[LAG] == pytest.approx(0.05 - 0.9 * (found[LATENCY] - truth))
        # What is unsure of the latency is so of the lag that goes with it.
        assert along[LAG] == pytest.approx(-0.9 * along[LATENCY])
        if rough:
            assert along[LATENCY] > deviation
        else:
            assert along[LATENCY] == pytest.approx(deviation, rel=1e-6)
            assert found[LATENCY] == pytest.approx(truth, abs=1e-9)


def test_a_latency_that_shows_is_left_as_it_is() -> None:
    search, unlikely = valley(0.02, 1e-4)
    theta = search(np.array([0.0201, 0.0]))
    found, along = by_latency(theta, LATENCY, search, unlikely, TICK, BELIEF)
    assert along is None
    assert found is theta


def test_a_profile_without_a_bottom_leaves_the_belief() -> None:
    latencies = np.arange(0.0, 0.044, 0.004)
    assert likely_latency(latencies, np.zeros(len(latencies)), BELIEF) == BELIEF
    assert likely_latency(latencies, -0.1 * (latencies / 0.02) ** 2, BELIEF) == BELIEF
