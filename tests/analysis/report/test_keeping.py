"""A flight is not lost to what comes after it, nor to an end in its middle."""

import errno
import os
from dataclasses import replace

import pytest

from skylimb.analysis.recording import load_runs
from skylimb.analysis.report import keeping
from skylimb.analysis.report.keeping import KeptFlights
from skylimb.base.errors import OutputError


@pytest.fixture
def flown(make_run):
    return replace(make_run(slide=1.0), metrics={})


def interrupted(folder, *runs):
    """Ctrl-C after some flights."""
    with folder as kept:
        for run in runs:
            kept.keep(run)
        raise KeyboardInterrupt


def test_the_folder_has_its_name_as_soon_as_the_last_record_is_in_it(flown, tmp_path):
    folder = tmp_path / "deep" / "out"
    with KeptFlights(folder, 1) as kept:
        assert not folder.exists()
        kept.keep(flown)
        assert load_runs(folder)["hybrid"].metrics == {}
    assert [path.name for path in folder.parent.iterdir()] == ["out"]


def test_what_a_comparison_flew_is_kept_under_a_name_that_says_it_was_interrupted(flown, tmp_path):
    for name in ("out-interrupted", "out-interrupted-1"):
        with pytest.raises(KeyboardInterrupt) as stop:
            interrupted(KeptFlights(tmp_path / "out", 3, apart=True), flown, replace(flown, name="pid"))
        assert list(load_runs(tmp_path / name)) == ["hybrid", "pid"]
        assert stop.value.__notes__ == [f"what was flown is kept in '{tmp_path / name}'"]
    assert not (tmp_path / "out").exists()


def test_the_part_of_a_flight_does_not_get_the_name_of_a_whole_one(flown, tmp_path):
    part = replace(flown, log=flown.log.assign_attrs(status="FAILED", cause="stopped from outside"))
    with pytest.raises(KeyboardInterrupt):
        interrupted(KeptFlights(tmp_path / "out", 1), part)
    assert [path.name for path in tmp_path.iterdir()] == ["out-interrupted"]
    with KeptFlights(tmp_path / "lost", 1) as kept:  # lost, but to its end
        kept.keep(part)
    assert load_runs(tmp_path / "lost")["hybrid"].failed


def test_an_error_before_the_first_record_leaves_nothing(tmp_path):
    with pytest.raises(ValueError, match="nothing"), KeptFlights(tmp_path / "deep" / "out", 1):
        raise ValueError("nothing flew")
    assert list(tmp_path.iterdir()) == []


def test_a_record_for_which_the_disk_has_no_room_is_kept_elsewhere(flown, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    (tmp_path / "tmp").mkdir()
    monkeypatch.setattr(keeping, "record", full)
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path / "tmp"))
    place = tmp_path / "tmp" / "skylimb-out-1"
    with (
        pytest.raises(OutputError, match=f"out': No space left on device; the flight is kept in '{place}'$"),
        KeptFlights(tmp_path / "out", 1) as kept,
    ):
        kept.keep(flown)
    assert list(load_runs(place)) == ["hybrid"]
    assert not (tmp_path / "out").exists()
