"""A user's own controller, gains and metric in a campaign and in a search."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError
from skylimb.control.controller import load_controller, resolved_tables
from skylimb.control.laws.preset import preset_mapping
from skylimb.robots.loader import load_robot
from skylimb.studies.campaign import run_campaign, tune
from skylimb.studies.campaign.distributions import Distribution
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.campaign.spec import CampaignSpec

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


def test_a_metric_that_fails_leaves_its_flight_as_it_is(spec: Callable[..., Path], tmp_path: Path) -> None:
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


LAW = """
class Gains: ...

def initial_state(gains, start):
    return ()

def step(gains, state, inputs):
    force = 40.0 if inputs.estimate.body.position[2] > 1.0 else 41.0
    return state, force, {}
"""


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
