"""One short flight for all conversions."""

from pathlib import Path

import pytest

import skylimb
from short_flights import HOLD


@pytest.fixture(scope="session")
def flown(tmp_path_factory: pytest.TempPathFactory) -> skylimb.Run:
    """A flight with a file of the user's among its sources."""
    law = Path(__file__).parents[3] / "examples" / "laws" / "preview.toml"
    return skylimb.run("paper", controller=str(law), set=HOLD)
