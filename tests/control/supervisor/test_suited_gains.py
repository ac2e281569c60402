"""Gains where measurements are late or were away, or rotors slow: nothing else changes."""

from __future__ import annotations

import numpy as np
import pytest

import skylimb
from skylimb.base.packing import Layout
from skylimb.control.supervisor.suited_gains import (
    EASE,
    LAG,
    LATENCY,
    MOST,
    RETURNED,
    SOFT,
    SOFTER,
    SOME,
    STIFFNESS,
    suited_gains,
)

GAINS = skylimb.load_controller("following", skylimb.load_robot("hydrus_xi_quad")).gains()
NAMED = Layout(GAINS)
OWN = NAMED.pack(GAINS)


@pytest.mark.parametrize("back", [0.0, RETURNED, np.inf, np.nan])
def test_in_time_not_a_bit_changes(back: float) -> None:
    np.testing.assert_array_equal(suited_gains(NAMED, OWN, 0.0, 0.0, back), OWN)
    assert suited_gains(Layout(()), np.zeros(0), 0.05, 0.05, back).size == 0


@pytest.mark.parametrize("back", [0.005, RETURNED - 0.005])
def test_a_pen_ahead_of_its_path_presses_on_once_poses_have_come_back(back: float) -> None:
    found, ease = suited_gains(NAMED, OWN, 0.0, 0.0, back), NAMED.slices[EASE]
    assert (found[ease], OWN[ease]) == (0.0, 1.0)
    found[ease] = OWN[ease]
    np.testing.assert_array_equal(found, OWN)


@pytest.mark.parametrize(("late", "share"), [(SOME - 0.01, 1.0), (SOME + 0.01, SOFTER), (MOST + 0.01, SOFT)])
def test_latency_is_believed_and_far_too_late_is_soft(late: float, share: float) -> None:
    found = suited_gains(NAMED, OWN, late, 0.0, np.inf)
    latency, stiffness = NAMED.slices[LATENCY], NAMED.slices[STIFFNESS]
    np.testing.assert_allclose(found[latency], OWN[latency] + late)
    np.testing.assert_array_equal(found[stiffness], share * OWN[stiffness])
    found[latency], found[stiffness] = OWN[latency], OWN[stiffness]
    np.testing.assert_array_equal(found, OWN)


def test_the_lag_of_slow_rotors_is_believed() -> None:
    found, lag = suited_gains(NAMED, OWN, 0.0, 0.05, np.inf), NAMED.slices[LAG]
    np.testing.assert_allclose(found[lag], OWN[lag] + 0.05)
    found[lag] = OWN[lag]
    np.testing.assert_array_equal(found, OWN)
