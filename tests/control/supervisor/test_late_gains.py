"""Gains of a controller whose measurements come late, or whose rotors are slow: nothing else is touched."""

from __future__ import annotations

import numpy as np
import pytest

import skylimb
from skylimb.base.packing import Layout
from skylimb.control.supervisor.late_gains import (
    LAG,
    LATENCY,
    MOST,
    SOFT,
    SOFTER,
    SOME,
    STIFFNESS,
    late_gains,
)

GAINS = skylimb.load_controller("following", skylimb.load_robot("hydrus_xi_quad")).gains()
NAMED = Layout(GAINS)
OWN = NAMED.pack(GAINS)


def test_in_time_not_a_bit_changes() -> None:
    np.testing.assert_array_equal(late_gains(NAMED, OWN, 0.0, 0.0), OWN)
    assert late_gains(Layout(()), np.zeros(0), 0.05, 0.05).size == 0


@pytest.mark.parametrize(("late", "share"), [(SOME - 0.01, 1.0), (SOME + 0.01, SOFTER), (MOST + 0.01, SOFT)])
def test_latency_is_believed_and_far_too_late_is_soft(late: float, share: float) -> None:
    found = late_gains(NAMED, OWN, late, 0.0)
    latency, stiffness = NAMED.slices[LATENCY], NAMED.slices[STIFFNESS]
    np.testing.assert_allclose(found[latency], OWN[latency] + late)
    np.testing.assert_array_equal(found[stiffness], share * OWN[stiffness])
    found[latency], found[stiffness] = OWN[latency], OWN[stiffness]
    np.testing.assert_array_equal(found, OWN)


def test_the_lag_of_slow_rotors_is_believed() -> None:
    found, lag = late_gains(NAMED, OWN, 0.0, 0.05), NAMED.slices[LAG]
    np.testing.assert_allclose(found[lag], OWN[lag] + 0.05)
    found[lag] = OWN[lag]
    np.testing.assert_array_equal(found, OWN)
