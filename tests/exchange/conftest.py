"""One short flight for all conversions."""

from pathlib import Path

import pytest

import skylimb

SHORT = {
    "phases.hover": 0.3,
    "phases.tare": 0.3,
    "phases.settle": 0.1,
    "phases.hover_end": 0.1,
    "approach.standoff": 0.02,
    "approach.speed": 0.3,
    "approach.retreat_speed": 0.3,
    "trajectory.shape": "hold",
    "trajectory.duration": 0.3,
}


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> skylimb.Run:
    """A flight with a file of the user's among its sources."""
    law = Path(__file__).parents[2] / "examples" / "laws" / "preview.toml"
    return skylimb.run("paper", controller=str(law), set=SHORT)
