from collections.abc import Iterator

import pytest

from skylimb.flight.drivers import machine_code
from skylimb.flight.drivers.native import native_available
from skylimb.simulation import compiling

FLAGS = compiling.FLAGS
"""As a user has them; other tests build without optimisation."""


@pytest.fixture(scope="session", autouse=True)
def _compiler() -> None:
    if not native_available():
        pytest.skip("no C compiler on this machine")


@pytest.fixture(scope="module", autouse=True)
def _optimised() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiling, "FLAGS", FLAGS)
        patch.setattr(machine_code, "_loaded", type(machine_code._loaded)())
        yield
