"""Short experiments for live flights."""

import pytest

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


@pytest.fixture(scope="session")
def short() -> dict[str, float]:
    return dict(SHORT)
