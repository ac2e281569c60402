"""What a folder with records is, and that a comparison is of one experiment."""

from dataclasses import replace
from pathlib import Path

import pytest

from skylimb.analysis.recording import Run
from skylimb.analysis.report.folder_kinds import other_than_flight, require_flights
from skylimb.apps.cli import main
from skylimb.base.errors import OutputError


def test_flights_of_different_experiments_are_not_compared(
    four_runs: dict[str, Run], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one, other = (four_runs[name] for name in ("hybrid", "pid"))
    require_flights({"a": one, "b": other}, tmp_path)
    runs = {"a": one, "b": replace(other, log=other.log.assign_attrs(experiment="ridge"))}
    with pytest.raises(OutputError, match=r"different experiments.*\('a'\), ridge \('b'\)"):
        require_flights(runs, tmp_path)
    for name, run in runs.items():
        (tmp_path / name).mkdir()
        run.save(tmp_path / name / "log.nc")
    assert main(["report", str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert f"'{tmp_path}' holds flights of different experiments, which are not compared" in err
    assert err.count("\n") == 1
    assert not (tmp_path / "report.html").exists()


def test_a_folder_is_known_by_what_no_flight_leaves(tmp_path: Path) -> None:
    (tmp_path / "log.nc").touch()
    assert other_than_flight(tmp_path) == ""
    (tmp_path / "differences.csv").touch()
    assert other_than_flight(tmp_path) == "a replay"
