import pytest

from skylimb.flight.drivers.native import native_available


@pytest.fixture(scope="session", autouse=True)
def _compiler() -> None:
    if not native_available():
        pytest.skip("no C compiler on this machine")
