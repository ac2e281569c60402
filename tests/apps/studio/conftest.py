"""Short experiments for live flights."""

import pytest

from short_flights import CIRCLE


@pytest.fixture(scope="session")
def short() -> dict[str, float]:
    return dict(CIRCLE)
