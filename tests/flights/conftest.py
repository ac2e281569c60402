"""Short flights, ready for any driver."""

from collections.abc import Callable
from typing import Any

import pytest

from skylimb.flights.public import take_off
from skylimb.flights.takeoff import Takeoff

SHORT = {
    "phases.hover": 0.4,
    "phases.tare": 0.3,
    "phases.settle": 0.3,
    "phases.hover_end": 0.1,
    "approach.depth": 0.05,
    "approach.standoff": 0.02,
    "approach.speed": 0.2,
    "approach.retreat_speed": 0.3,
    "trajectory.radius": 0.05,
    "trajectory.period": 1.5,
}


def _make(
    experiment: str = "paper", controller: str = "hybrid", set: dict[str, Any] | None = None, seed: int = 0
) -> Takeoff:
    """A flight of a shipped experiment with some of its values changed."""
    changes = {**(SHORT if experiment == "paper" else {}), **(set or {})}
    (takeoff,) = take_off(experiment, (controller,), seed, changes)
    return takeoff


@pytest.fixture(scope="session")
def make_takeoff() -> Callable[..., Takeoff]:
    return _make
