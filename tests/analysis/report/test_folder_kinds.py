"""What a folder with records is, and that a comparison is of one experiment."""

from dataclasses import replace
from pathlib import Path

import pytest

from skylimb.analysis.recording import Run
from skylimb.analysis.recording.origin import origin_text
from skylimb.analysis.report.folder_kinds import other_than_flight, require_flights
from skylimb.analysis.report.output import write_records
from skylimb.analysis.report.places import configurations
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


def test_a_configuration_of_another_flight_is_not_said_to_fly_it_again(
    four_runs: dict[str, Run], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, folder = four_runs["hybrid"], tmp_path / "out"
    write_records({"hybrid": run}, folder)
    assert main(["score", str(folder)]) == 0
    assert "is not what flew" not in capsys.readouterr().out
    assert "skylimb run config.toml" in (folder / "report.html").read_text(encoding="utf-8")
    log = run.log.assign_attrs(config=run.config.replace("seed = 3", "seed = 4"))
    (folder / "log.nc").write_bytes(replace(run, log=log).content())
    assert main(["score", str(folder)]) == 0
    assert f"note: '{folder / 'config.toml'}' is not what flew" in capsys.readouterr().out
    assert "skylimb run config.toml" not in (folder / "report.html").read_text(encoding="utf-8")
    assert (folder / "config.toml").read_text(encoding="utf-8") == run.config  # it may be the user's


def test_a_configuration_in_a_comparison_names_its_files_otherwise(
    four_runs: dict[str, Run], tmp_path: Path
) -> None:
    law = {"sources/a-1/a.py": b"pass"}
    text = origin_text({"law": "sources/a-1/a.py"}, law, {})
    runs = {
        name: replace(four_runs[name], log=four_runs[name].log.assign_attrs(config=text), sources=law)
        for name in ("hybrid", "pid")
    }
    write_records(runs, tmp_path / "out")
    places = [tmp_path / "out" / name / "config.toml" for name in runs]
    assert configurations(runs, tmp_path / "out") == (places, [])
    places[1].write_text(origin_text({"law": "firm"}, {}, {}), encoding="utf-8")
    assert configurations(runs, tmp_path / "out") == (places[:1], places[1:])
