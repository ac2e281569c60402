"""Short flights, ready for any driver."""

from collections.abc import Callable
from typing import Any

import pytest

from short_flights import CIRCLE
from skylimb.flight.takeoff import Takeoff, take_off


def _make(
    experiment: str = "paper", controller: str = "hybrid", set: dict[str, Any] | None = None, seed: int = 0
) -> Takeoff:
    """A flight of a shipped experiment with some of its values changed."""
    changes = {**(CIRCLE if experiment == "paper" else {}), **(set or {})}
    (takeoff,) = take_off(experiment, (controller,), seed, changes)
    return takeoff


@pytest.fixture(scope="session")
def make_takeoff() -> Callable[..., Takeoff]:
    return _make
