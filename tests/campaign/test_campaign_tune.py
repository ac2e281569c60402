import csv
import json
from collections.abc import Callable
from pathlib import Path

import pytest

import skylimb
from skylimb.campaign import tune
from skylimb.cli import main
from skylimb.control.preset import preset_mapping
from skylimb.errors import SkylimbError

pytest.importorskip("cma")

SpecWriter = Callable[..., Path]

SEARCH = """
[tune]
objective = "error_z_median"
trials = 9
held_out = 4
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
    assert found.held_out.wins == 4
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
    assert "4 held-out draws" in capsys.readouterr().out
    verdict = json.loads((tmp_path / "tuned" / "verdict.json").read_text())
    assert [entry["trials"] for entry in verdict["controllers"].values()] == [3, 3]
    with (tmp_path / "tuned" / "trials.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["controller"] for row in rows] == ["impedance"] * 3 + ["hybrid"] * 3


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("", ["tune"]),
        (SEARCH.replace("stiffness.2", "stiffness"), ["normalized_stiffness", "single number"]),
        (SEARCH.replace("stiffness.2", "stifness.2"), ["stifness"]),
    ],
)
def test_a_search_that_cannot_be_is_refused(
    more: str, words: list[str], write_spec: SpecWriter, tmp_path: Path
) -> None:
    with pytest.raises(SkylimbError) as caught:
        tune(write_spec(controllers='["impedance"]', more=more), tmp_path / "tuned", workers=0)
    assert all(word in str(caught.value) for word in words)
    assert not (tmp_path / "tuned").exists()
