"""Settings of all tests."""

from collections.abc import Iterator

import pytest
from hypothesis import settings

# A test says what is right, not how fast: two cores that fly beside it break any deadline now and then.
settings.register_profile("skylimb", deadline=None)
settings.load_profile("skylimb")

FIGURES = (
    "analysis.figures.style.DPI",
    "studies.verification.figures._DPI",
    "studies.calibration.figures._DPI",
)


@pytest.fixture(scope="session", autouse=True)
def _coarse_pictures() -> Iterator[None]:
    """Pictures with few dots, as all tests but those of `sharp` look at what is drawn, not at how finely."""
    with pytest.MonkeyPatch.context() as patch:
        for name in FIGURES:
            patch.setattr(f"skylimb.{name}", 40)
        yield


@pytest.fixture
def sharp(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures as fine as a user's."""
    monkeypatch.setattr("skylimb.analysis.figures.style.DPI", 200)
