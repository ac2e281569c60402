import csv
import json
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skylimb
from skylimb.apps.cli import main
from skylimb.base.errors import SkylimbError
from skylimb.control.laws.preset import preset_mapping
from skylimb.studies.campaign import CampaignProgress, report_campaign, run_campaign, tune
from skylimb.studies.campaign.flight_queue import BATCH, FlightQueue, Interrupted

pytest.importorskip("cma")

SpecWriter = Callable[..., Path]
Contents = Callable[[Path], dict[str, bytes]]

SEARCH = """
[tune]
objective = "error_v_median"
trials = 9
held_out = 6
[tune.gains]
"translation.normalized_stiffness.2" = [0.5, 12.0]
"""


def test_a_search_finds_the_stiffness_that_theory_asks_for(write_spec: SpecWriter, tmp_path: Path) -> None:
    """Thrust is short of its command by a constant share, so the error falls as the stiffness grows."""
    spec = write_spec(
        draws=2,
        controllers='["impedance"]',
        vary='"plant.thrust_scale" = { uniform = [0.93, 0.97] }',
        more=SEARCH,
    )
    outcome = tune(spec, tmp_path / "tuned", workers=0)
    found = outcome.tuned["impedance"]
    key = "translation.normalized_stiffness.2"
    assert found.before[key] == 1.5
    assert found.after[key] > 3.0
    assert found.better
    assert found.held_out.wins == 6
    assert found.trials == 9
    written = preset_mapping(str(tmp_path / "tuned" / "impedance.toml"))[0]
    assert written["translation"]["normalized_stiffness"][2] == found.after[key]
    robot = skylimb.load_robot("hydrus_xi_quad")
    assert skylimb.load_controller(str(tmp_path / "tuned" / "impedance.toml"), robot).name == "impedance"


def test_controllers_are_compared_at_equal_budgets(
    write_spec: SpecWriter, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = write_spec(draws=1, controllers='["impedance", "hybrid"]', more=SEARCH.replace("= 9", "= 3"))
    assert main(["tune", str(spec), "--out", str(tmp_path / "tuned"), "--workers", "0"]) == 0
    assert "6 held-out draws" in capsys.readouterr().out
    verdict = json.loads((tmp_path / "tuned" / "verdict.json").read_text())
    assert [entry["trials"] for entry in verdict["controllers"].values()] == [3, 3]
    with (tmp_path / "tuned" / "trials.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["controller"] for row in rows] == ["impedance"] * 3 + ["hybrid"] * 3


@pytest.mark.slow
def test_an_interrupted_search_goes_on_and_finds_the_same(
    write_spec: SpecWriter, tmp_path: Path, contents: Contents
) -> None:
    spec = write_spec(draws=2, controllers='["impedance", "hybrid"]', more=SEARCH.replace("= 9", "= 4"))
    tune(spec, tmp_path / "whole", workers=0)
    for least in (3, 20):

        def stop(progress: CampaignProgress, least: int = least) -> None:
            if progress.done >= least and not progress.stopping:
                os.kill(os.getpid(), signal.SIGINT)

        stopped = tune(spec, tmp_path / "cut", workers=0, resume=least > 3, progress=stop)
        assert not stopped.complete
        assert least <= stopped.flown < least + BATCH
    assert tune(spec, tmp_path / "cut", workers=1, resume=True).complete
    assert contents(tmp_path / "cut") == contents(tmp_path / "whole")


@pytest.mark.slow
@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(kills=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=4))
def test_a_search_killed_at_any_moments_finds_the_same(
    kills: list[float], tmp_path_factory: pytest.TempPathFactory, write_spec_to: SpecWriter,
    in_child: Callable[..., int], contents: Contents, counted: Callable[..., Any],
    instant_flights: None,
) -> None:  # fmt: skip
    home = tmp_path_factory.mktemp("kills")
    spec = write_spec_to(home, draws=2, controllers='["impedance"]', more=SEARCH)
    folder = home / "cut"
    with counted() as calls:
        tune(spec, home / "whole", workers=0)

    def search() -> None:
        tune(spec, folder, workers=0, resume=folder.exists())

    for share in kills:
        assert in_child(search, calls=1 + int(share * calls.count)) in (0, -signal.SIGKILL)
    search()
    assert contents(folder) == contents(home / "whole")


def test_a_finished_search_is_not_flown_again(write_spec: SpecWriter, tmp_path: Path) -> None:
    spec = write_spec(draws=1, controllers='["impedance"]', more=SEARCH.replace("= 9", "= 2"))
    tune(spec, tmp_path / "tuned", workers=0)
    seen: list[int] = []
    tune(
        spec,
        tmp_path / "tuned",
        workers=0,
        resume=True,
        progress=lambda progress: seen.append(progress.flown),
    )
    assert max(seen) == 0


def test_a_search_is_not_resumed_with_another_spec(write_spec: SpecWriter, tmp_path: Path) -> None:
    head = {"draws": 1, "controllers": '["impedance"]'}
    tune(write_spec(**head, more=SEARCH.replace("= 9", "= 2")), tmp_path / "tuned", workers=0)
    other = write_spec(**head, more=SEARCH.replace("= 9", "= 3"))
    with pytest.raises(SkylimbError, match=r"tune\.trials: 2 -> 3"):
        tune(other, tmp_path / "tuned", workers=0, resume=True)
    with pytest.raises(SkylimbError, match="--resume goes on"):
        tune(other, tmp_path / "tuned", workers=0)
    (tmp_path / "mine").mkdir()
    with pytest.raises(SkylimbError, match="holds no campaign"):
        tune(other, tmp_path / "mine", workers=0, resume=True)
    run_campaign(other, tmp_path / "flown", workers=0)
    with pytest.raises(SkylimbError, match=r"frozen\.purpose: 'campaign' -> 'search'"):
        tune(other, tmp_path / "flown", workers=0, resume=True)
    with pytest.raises(SkylimbError, match="holds no flight"):
        report_campaign(tmp_path / "tuned")


def test_an_interrupted_search_says_how_to_go_on(
    write_spec: SpecWriter,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def stopped(*arguments: object) -> None:
        raise Interrupted

    monkeypatch.setattr(FlightQueue, "fly", stopped)
    spec, folder = write_spec(draws=1, controllers='["impedance"]', more=SEARCH), tmp_path / "tuned"
    assert main(["tune", str(spec), "--out", str(folder), "--workers", "0"]) == 130
    assert f"skylimb tune {spec} --out {folder} --resume --workers 0" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("", ["tune"]),
        (SEARCH.replace("stiffness.2", "stiffness"), ["normalized_stiffness", "single number"]),
        (SEARCH.replace("stiffness.2", "stifness.2"), ["did you mean 'translation.normalized_stiffness'"]),
    ],
)
def test_a_search_that_cannot_be_is_refused(
    more: str, words: list[str], write_spec: SpecWriter, tmp_path: Path
) -> None:
    with pytest.raises(SkylimbError) as caught:
        tune(write_spec(controllers='["impedance"]', more=more), tmp_path / "tuned", workers=0)
    assert all(word in str(caught.value) for word in words)
    assert not (tmp_path / "tuned").exists()
