"""Limits that would have the supervisor act in another order than its table are refused."""

from __future__ import annotations

from typing import Any

import pytest

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.control.cascade import Cascade
from skylimb.control.controller import load_controller
from skylimb.control.supervisor.halves import Halves
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.supervised import Supervised


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"cut_after": 0.0}, "supervisor.retreat_after = 0.6 must be at most supervisor.cut_after = 0"),
        ({"retreat_after": 10.0}, "retreat_after = 10 .* supervisor.cut_after = 1"),
        ({"stale_after": 10.0}, "stale_after = 10 .* supervisor.retreat_after = 0.6"),
        ({"frozen_after": 2.0}, "frozen_after = 2 .* supervisor.retreat_after = 0.6"),
        ({"retreat_after": 0.04}, "frozen_after = 0.05 .* supervisor.retreat_after = 0.04"),
        ({"lossy": 0.9}, "lossy = 0.9 .* supervisor.dead = 0.7"),
        ({"deaf_after": 0.0}, "deaf_after"),
        ({"upset_at": 3.13}, "upset_at"),
    ],
)
def test_an_order_that_makes_no_sense_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        Limits(**given)


def test_a_latency_beyond_the_prediction_is_refused_by_both_supervisors() -> None:
    """The compiled tick's and the one around a controller on a clock; both cut the history off before."""
    robot, told = skylimb.load_robot("hydrus_xi_quad"), r"^supervisor\.latency = 0.05 s .* at most 0.025 s"
    controller = load_controller("hybrid", robot)
    assert isinstance(controller, Cascade)
    limits = Limits(latency=0.05)
    Supervised(controller, limits).require(0.005)
    with pytest.raises(ConfigError, match=told):
        Supervised(controller, limits).require(0.001)
    with pytest.raises(ConfigError, match=told):
        Halves(robot, limits, 0, 0.001, imu=False)
