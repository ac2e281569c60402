"""A user's own controller, gains and metric in a campaign and in a search."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from skylimb.apps.cli import main
from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError
from skylimb.control.controller import load_controller, resolved_tables
from skylimb.control.laws.preset import preset_mapping
from skylimb.robots import loader
from skylimb.robots.loader import load_robot
from skylimb.studies.campaign import run_campaign, tune
from skylimb.studies.campaign.distributions import Distribution
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.campaign.reading import load_spec
from skylimb.studies.campaign.spec import CampaignSpec
from skylimb.studies.campaign.worker import Job, Worker

EXAMPLES = Path(__file__).parents[3] / "examples"
METRIC = """
import skylimb

@skylimb.metric(unit="m/s", smaller_is_better=True)
def fastest(run):
    '''Largest speed.'''
    return float(abs(run.log.cog_velocity).max())
"""
OWN = f'["{(EXAMPLES / "user_controller.py").as_posix()}"]'


@pytest.fixture
def spec(write_spec: Callable[..., Path], tmp_path: Path) -> Callable[..., Path]:
    (tmp_path / "mine.py").write_text(METRIC, encoding="utf-8")

    def written(**more: str) -> Path:
        return write_spec(draws=2, controllers=OWN, head='use = ["mine.py"]\nscore = "fastest"', **more)

    return written


def test_a_campaign_varies_its_gains_and_scores_by_its_metric(
    spec: Callable[..., Path], tmp_path: Path
) -> None:
    file = spec(
        vary='"controller.velocity.2" = { grid = [3.0, 6.0] }', more="[success]\nfastest = { max = 5.0 }"
    )
    outcome = run_campaign(file, tmp_path / "out", workers=0)
    assert outcome.summary is not None
    first, second = outcome.rows.values()
    assert (first["status"], second["status"]) == ("OK", "OK")
    assert (first["controller.velocity.2"], second["controller.velocity.2"]) == (3.0, 6.0)
    assert first["fastest"] != second["fastest"]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Largest speed" in page


def test_a_metric_that_fails_leaves_its_flight_as_it_is(
    spec: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = spec()
    (tmp_path / "mine.py").write_text(
        METRIC.replace("run.log.cog_velocity", "run.log.nothing"), encoding="utf-8"
    )
    outcome = run_campaign(file, tmp_path / "out", workers=0)
    for row in outcome.rows.values():
        assert (row["status"], row["fastest"]) == ("OK", None)
        assert row["tilt_max"] is not None
        assert "metric 'fastest' fails in " in row["cause"]
        assert "mine.py, line 7" in row["cause"]
    assert main(["campaign", "report", str(tmp_path / "out")]) == 0
    said = "2 flights lack numbers; flight 0 (user_controller): metric 'fastest' fails in"
    assert said in " ".join(capsys.readouterr().out.split())
    assert said.replace("'", "&#39;") in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_every_metric_that_fails_is_in_the_cause_also_of_a_flight_that_was_stopped(
    spec: Callable[..., Path], tmp_path: Path
) -> None:
    file = spec()
    file.write_text(file.read_text().replace("[set]", "[set]\nstop_at = 0.6"), encoding="utf-8")
    broken = METRIC.replace("run.log.cog_velocity", "run.log.nothing")
    other = broken[broken.index("@") :].replace("fastest", "other")
    (tmp_path / "mine.py").write_text(f"{broken}\n\n{other}", encoding="utf-8")
    for row in run_campaign(file, tmp_path / "out", workers=0).rows.values():
        assert row["status"] == "STOPPED"
        assert "metric 'fastest' fails in " in row["cause"]
        assert "; metric 'other' fails in " in row["cause"]


def test_a_report_is_made_from_another_directory_than_the_campaign_was_begun_in(
    spec: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["campaign", spec().name, "--out", "out", "--workers", "0"]) == 0
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    assert main(["campaign", "report", "../out"]) == 0
    assert main(["campaign", f"../{spec().name}", "--out", "../out", "--workers", "0", "--resume"]) == 0


LAW = """
class Gains: ...

def initial_state(gains, start):
    return ()

def step(gains, state, inputs):
    force = 40.0 if inputs.estimate.body.position[2] > 1.0 else 41.0
    return state, force, {}
"""


@pytest.mark.parametrize("edited", ["mine.py", "own.py", "law.py", "wall.csv", "mine/flight.toml"])
def test_a_file_that_is_edited_while_it_flies_ends_the_campaign(
    edited: str, write_spec: Callable[..., Path], tmp_path: Path
) -> None:
    """Rows of two codes never stand in one table, though workers read files as they need them."""
    (tmp_path / "mine.py").write_text(METRIC, encoding="utf-8")
    for file, name in (("user_controller.py", "own.py"), ("laws/extended_state.py", "law.py")):
        (tmp_path / name).write_bytes((EXAMPLES / file).read_bytes())
    preset = {**preset_mapping("pid")[0], "estimation": {"law": "law.py"}}
    (tmp_path / "with_law.toml").write_text(write_toml(preset), encoding="utf-8")
    (tmp_path / "wall.csv").write_text("0, 0, 0, 0\n0, 1, 1, 0\n0, 1, 1, 0\n0, 0, 0, 0\n", encoding="utf-8")
    (tmp_path / "board.toml").write_text(
        'robot = "mine"\n[surface]\nkind = "heightmap"\nfile = "wall.csv"\nrelief = 0.02\n'
    )
    shutil.copytree(Path(loader.__file__).with_name("hydrus_xi_quad"), tmp_path / "mine")
    file = write_spec(controllers='["own.py", "with_law.toml"]', head='use = ["mine.py"]')
    file.write_text(file.read_text().replace('experiment = "paper"', 'experiment = "board.toml"'))
    campaign = freeze(load_spec(file))
    worker = Worker(campaign)
    assert [flown.row["status"] for flown in worker.fly([Job(0), Job(1)])] == ["OK", "OK"]
    path = tmp_path / edited
    before = path.read_text(encoding="utf-8")
    after = {".csv": before.replace("1, 1", "1, 2"), ".toml": before + "# another\n"}
    path.write_text(after.get(path.suffix, before + "MORE = 1\n"), encoding="utf-8")
    for flier in (worker.fly, lambda jobs: Worker(campaign).fly(jobs)):
        with pytest.raises(ConfigError, match="is another than when the campaign was begun") as error:
            flier([Job(2), Job(3)])
        # Of all files the one that changed is named, also where digests are of several.
        assert f"({path.as_posix()!r} has changed)" in str(error.value)
    path.write_text(before, encoding="utf-8")
    assert len(worker.fly([Job(2), Job(3)])) == 2


def test_a_law_that_returns_too_little_is_refused_before_a_folder_is_begun(
    write_spec: Callable[..., Path], tmp_path: Path
) -> None:
    (tmp_path / "iffy.py").write_text(
        LAW.replace("class Gains", "from dataclasses import dataclass\n\n@dataclass\nclass Gains"),
        encoding="utf-8",
    )
    tables = preset_mapping("hybrid")[0] | {"translation": {"law": "iffy.py"}}
    (tmp_path / "iffy.toml").write_text(write_toml(tables), encoding="utf-8")
    file = write_spec(draws=2, controllers='["iffy.toml"]')
    with pytest.raises(ConfigError, match=r"iffy\.py, line 12, .*got a number, expected a force \(3,\)"):
        run_campaign(file, tmp_path / "out", workers=0)
    assert not (tmp_path / "out").exists()


def test_a_search_tunes_its_gains(spec: Callable[..., Path], tmp_path: Path) -> None:
    pytest.importorskip("cma")
    table = '[tune]\nobjective = "fastest"\ntrials = 2\nheld_out = 2\ngains = { "velocity.2" = [2.0, 8.0] }'
    outcome = tune(spec(more=table), tmp_path / "out", workers=0)
    assert "m/s" in outcome.lines()[0]
    tuned = load_controller(str(tmp_path / "out" / "user_controller.toml"), load_robot("hydrus_xi_quad"))
    found = outcome.tuned["user_controller"]
    assert resolved_tables(tuned)["velocity"] == [2.6, 2.6, found.after["velocity.2"]]


def test_the_laws_that_are_flown_are_read_and_no_others(tmp_path: Path) -> None:
    tables, _ = preset_mapping("hybrid")
    (tmp_path / "own.toml").write_text(
        write_toml({**tables, "translation": {"law": "away.py"}}), encoding="utf-8"
    )
    body = "inputs.estimate.body.model.mass * inputs.estimate.body.model.gravity"
    law = LAW.replace("40.0 if inputs.estimate.body.position[2] > 1.0 else 41.0", body)
    law = law.replace("class Gains", "from dataclasses import dataclass\n\n@dataclass\nclass Gains")
    for name in ("one.py", "two.py"):
        (tmp_path / name).write_text(law, encoding="utf-8")

    def frozen(*laws: str) -> dict[str, Any]:
        vary = {"controller.translation.law": Distribution(grid=laws)} if laws else {}
        spec = CampaignSpec("paper", (str(tmp_path / "own.toml"),), draws=len(laws) or 1, vary=vary)
        return freeze(spec).controllers["own"]["code"]

    with pytest.raises(ConfigError, match=r"away\.py' does not exist"):
        frozen()
    first = frozen("one.py", "two.py")
    assert set(first) == {"translation"}
    (tmp_path / "two.py").write_text(law + "# another one\n", encoding="utf-8")
    assert frozen("one.py", "two.py") != first
    assert frozen("one.py") == frozen("one.py")
