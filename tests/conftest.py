"""Settings of all tests."""

import gc
import os
import shutil
from collections.abc import Generator, Iterator
from types import SimpleNamespace
from typing import Any

# Before NumPy is loaded, here and in all that tests start. Threads of linear algebra wait for each other if
# another worker has the next core: on a busy machine a test of eigenvalues took 123 s in place of 1.6.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# It builds long functions of a tick or an exported controller in a third of gcc's time. A compiler that is
# named is used.
if shutil.which("clang"):
    os.environ.setdefault("CC", "clang")

import pytest
from hypothesis import settings

from skylimb.simulation import compiling
from strict_c import StrictC

# A test says what is right, not how fast: two cores that fly beside it break any deadline now and then.
# The same cases in every run, so that a change is judged and not luck; `--hypothesis-profile search` draws
# others.
settings.register_profile("search", deadline=None)
settings.register_profile("skylimb", deadline=None, derandomize=True)
settings.load_profile("skylimb")

LONGEST = (
    "test_arms.py", "test_page_browser.py", "test_verify_contact.py", "test_hostile_values.py",
    "test_restart.py", "test_doors.py", "test_examples.py", "test_pilot.py", "test_hostile_files.py",
    "test_cli.py", "test_campaign_engines.py", "test_house.py", "test_live_record.py", "test_figures.py",
    "test_native_driver.py", "test_convert.py", "test_fly_robot.py", "test_campaign_folder.py",
    "test_reproduction.py", "test_written_folders.py", "test_task_frame.py", "test_descents.py",
    "test_export_c.py", "test_spinal.py", "test_repeating.py", "test_store.py", "test_equilibrium.py",
    "test_estimate.py", "test_user_surface.py", "test_imports.py", "test_keeping.py",
    "test_host_program.py", "test_one_state.py",
)  # fmt: skip
"""Files that begin first, so that no worker is left alone with one of them at the end."""


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What is collected stays, so the collector of garbage need not walk over it again and again."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.name not in LONGEST)


@pytest.fixture(scope="session")
def strict_c(tmp_path_factory: pytest.TempPathFactory) -> StrictC:
    """One for all workers of a run."""
    base = tmp_path_factory.getbasetemp()
    return StrictC((base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "objects")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium, for the tests of a file; those that use it are marked with `needs_chromium`."""
    from chromium import chromium

    with chromium() as found:
        yield found


@pytest.fixture(scope="session", autouse=True)
def _coarse_pictures() -> Iterator[None]:
    """Pictures with few dots, and pushes at few moments: most tests look at what is drawn, not how finely."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("skylimb.analysis.figures.style.DPI", 40)
        patch.setattr("skylimb.analysis.viewer.pushes.MOMENTS", 2)
        yield


@pytest.fixture(scope="session", autouse=True)
def _quick_machine_code() -> Iterator[None]:
    """C without optimisation: built in a sixth of the time, the same bits.

    A test of the native driver holds what a user builds against it.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiling, "FLAGS", tuple(flag.replace("-O2", "-O0") for flag in compiling.FLAGS))
        yield


@pytest.fixture(scope="session", autouse=True)
def _no_search_for_garbage() -> Iterator[None]:
    """Before a flight on a clock: it would walk over all that tests have loaded, for a third of a second."""
    with pytest.MonkeyPatch.context() as patch:
        kept = {name: getattr(gc, name) for name in ("isenabled", "disable", "enable")}
        nothing = dict.fromkeys(("collect", "freeze", "unfreeze"), lambda: None)
        patch.setattr("skylimb.flight.realtime.clocked_flight.gc", SimpleNamespace(**kept, **nothing))
        yield


@pytest.fixture
def no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """For what writes a report, and looks at none of its figures."""
    monkeypatch.setattr("skylimb.analysis.figures.report_figures.write_figures", lambda *_: [])


@pytest.fixture
def no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """For what imports a robot to fly it."""
    monkeypatch.setattr("skylimb.apps.robot_import.writing.draw_robot", lambda *_: None)


@pytest.fixture
def sharp(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures as fine as a user's."""
    monkeypatch.setattr("skylimb.analysis.figures.style.DPI", 200)
