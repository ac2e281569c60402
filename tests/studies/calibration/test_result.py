"""A calibration as data, and its folder."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.analysis.recording.run import Run
from skylimb.apps.cli import main
from skylimb.base.errors import OutputError
from skylimb.control.calibration_date import age_of
from skylimb.control.corrections import read_corrections
from skylimb.robots.model import Robot
from skylimb.studies.calibration.parameters import centers, scaled, slices, spreads
from skylimb.studies.calibration.public import calibration_from
from skylimb.studies.calibration.report import write_calibration
from skylimb.studies.calibration.result import Calibration


def test_the_file_has_a_table_for_every_parameter(
    made: Calibration, robot: Robot, otherwise: dict[str, Any]
) -> None:
    tables = tomllib.loads(made.text)
    assert tables["robot"] == robot.name
    assert tables["robot_digest"] == robot.description.digest
    for key in ("attitude_misalignment", "cog_offset", "rotor_scale", "rotor_lag", "latency", "lean"):
        table = tables[key]
        value, low, high = (np.asarray(table[name]) for name in ("value", "low", "high"))
        assert np.all(low < value)
        assert np.all(value < high)
    assert tables["cog_offset"]["value"] == pytest.approx(otherwise["plant.cog_offset"], abs=1e-3)
    assert tables["rotor_lag"]["value"] == pytest.approx(0.06, abs=3e-3)
    assert tables["mass_scale"]["value"] == 1.0
    assert tables["mass_scale"]["shown"] is False
    assert tables["flight"]["experiment"] == "calibration"
    assert "mujoco" in tables["versions"]


def test_nothing_is_corrected_by_what_the_flight_did_not_show(made: Calibration) -> None:
    """What is not shown stays as it was believed; what goes with it comes along, and no more."""
    assert made.used.tolist() == made.estimate.value.tolist()
    spread, count = spreads(made.estimate.parameters), len(made.estimate.value)
    covariance = np.diag((0.1 * spread) ** 2)
    at = slices(made.estimate.parameters)
    hidden, beside, apart = at["latency"].start, at["rotor_lag"].start, at["cog_offset"].start
    covariance[hidden, hidden] = (0.9 * spread[hidden]) ** 2
    covariance[hidden, beside] = covariance[beside, hidden] = 0.5 * 0.09 * spread[hidden] * spread[beside]
    estimate = replace(made.estimate, covariance=covariance)
    poor = replace(made, estimate=estimate)
    assert estimate.shown.sum() == count - 1
    believed = centers(estimate.parameters)[hidden]
    assert poor.used[hidden] == believed
    moved = 0.5 * 0.1 / 0.9 * spread[beside] / spread[hidden] * (believed - estimate.value[hidden])
    assert poor.used[beside] == pytest.approx(estimate.value[beside] + moved)
    assert poor.used[apart] == estimate.value[apart]
    # A controller keeps its own latency then; the file says so, and a file of before has none of it.
    assert poor.corrections.latency == -1.0
    assert poor.tables["latency"]["value"] == estimate.value[hidden]
    assert poor.corrections.rotor_lag == poor.used[beside]


def test_a_number_known_to_a_third_of_what_was_unknown_corrects_nothing(made: Calibration) -> None:
    """With a latency known to a half the line of `following` was up to twice as far off as without."""
    spread, at = spreads(made.estimate.parameters), slices(made.estimate.parameters)
    for part, used in ((0.33, False), (0.2, True)):
        covariance = np.diag((0.01 * spread) ** 2)
        hidden = at["latency"].start
        covariance[hidden, hidden] = (part * spread[hidden]) ** 2
        poor = replace(made, estimate=replace(made.estimate, covariance=covariance))
        assert (poor.corrections.latency >= 0.0) is used


def test_the_map_of_information(made: Calibration) -> None:
    found = made.estimate
    assert np.linalg.eigvalsh(scaled(found.information, found.parameters))[0] > 1.0


def test_a_folder_with_data_page_and_figures(made: Calibration, tmp_path: Path) -> None:
    folder = write_calibration(made, tmp_path / "made")
    names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))
    figures = ["correlations", "information", "intervals", "residuals"]
    assert names == [
        "calibration.toml",
        "figures",
        *(f"figures/{name}.png" for name in figures),
        "report.html",
    ]
    assert 0.0 <= age_of(folder / "calibration.toml") < 0.1
    assert read_corrections(folder / "calibration.toml") == made.corrections
    page = (folder / "report.html").read_text("utf-8")
    assert escape(made.verdict, quote=False).replace("'", "&#39;") in page
    assert escape(made.moved) in page
    assert made.moved.startswith("The measured link moved over")
    assert page.count("data:image/png") == 4
    assert "Watch it" not in page
    with pytest.raises(OutputError, match="exists already"):
        write_calibration(made, folder)


def test_the_page_shows_the_flight_again(made: Calibration, flown: Run, tmp_path: Path) -> None:
    folder = write_calibration(made, tmp_path / "flown", flown)
    page = (folder / "report.html").read_text("utf-8")
    assert "Watch it" in page
    assert 'id="replay-data"' in page
    assert (folder / "log.nc").is_file()


def test_the_folder_of_a_calibration_is_no_flight_to_be_scored(
    made: Calibration, flown: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_calibration(made, tmp_path / "flown", flown)
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    for verb in ("report", "score"):
        assert main([verb, str(folder)]) == 2
        err = capsys.readouterr().err
        assert f"'{folder}' is a calibration and is not scored: `skylimb calibrate {folder}/log.nc`" in err
        assert err.count("\n") == 1
    assert main(["score", str(tmp_path)]) == 2
    assert f"'{folder}' is a calibration" in capsys.readouterr().err
    assert before == {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert main(["runs", str(tmp_path)]) == 0
    assert "a calibration" in capsys.readouterr().out


def test_a_folder_without_a_log_is_no_experiment(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", str(tmp_path), "--out", str(tmp_path / "made")]) == 2
    assert f"folder '{tmp_path}' holds no log.nc" in capsys.readouterr().err
    assert not (tmp_path / "made").exists()


def test_pushes_that_nothing_explains_are_told(made: Calibration, short: dict[str, Any]) -> None:
    """With air drag the residuals are as small as noise, as the level of the pushes is fitted."""
    assert not made.estimate.pushed
    assert made.verdict.endswith("What is left is the sensors' noise.")
    drags = skylimb.calibrate("calibration", set={**short, "plant.rotor_drag": 0.3})
    assert drags.left == pytest.approx(1.0, abs=0.1)
    assert drags.estimate.pushed
    assert "noise and pushes that nothing explains" in drags.verdict
    assert f"{drags.estimate.noise.push:.2g} m/s^2" in drags.verdict


def test_a_level_of_pushes_that_a_short_flight_does_not_tell_is_not_told(flown: Run, robot: Robot) -> None:
    """Of some seconds a level ten times the least was taken for pushes, though the least is as likely."""
    begin = int(np.argmax(flown.log.time.values > 4.0))
    some = replace(flown, log=flown.log.isel(time=slice(begin, begin + 1100)))
    made = calibration_from(some, robot)
    assert not made.estimate.pushed
    noise = made.estimate.noise
    unsure = replace(made.estimate, noise=noise._replace(push=10.0 * noise.push, turn=10.0 * noise.turn))
    assert "nothing explains" not in replace(made, estimate=unsure).verdict
    assert "nothing explains" in replace(made, estimate=replace(unsure, unpushed=30.0)).verdict
