"""The bench that ranks all controllers, in its shortest form."""

import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.mark.slow
def test_a_place_is_flown_and_its_table_ranks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    ranking = import_module("ranking")
    both = ("impedance", "mpc")
    rows = ranking.flown("push_and_slide", 8, tmp_path, both)
    sys.modules.pop("ranking")
    impedance, mpc = rows
    assert (impedance["lost"], mpc["lost"]) == (0, 0)
    assert 1e3 * mpc["pen_line_rms"][0] < 5.0 < 1e3 * impedance["pen_line_rms"][0]
    assert (mpc["pen_line_rms rank"], impedance["pen_line_rms rank"]) == (1, 2)
    text = ranking.table(rows, {"mpc": 28.0})
    assert "| `mpc` | 0 | " in text
    assert "(1)" in text
    assert ranking.flown("push_and_slide", 8, tmp_path, both) == rows  # nothing is flown again


@pytest.mark.slow
def test_a_controller_is_tuned_once_and_flies_from_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    ranking = import_module("ranking")
    file = ranking.tuned("admittance", tmp_path, 3, 2)
    searched = Path(file).read_text(encoding="utf-8")
    assert ranking.tuned("admittance", tmp_path, 3, 2) == file
    sys.modules.pop("ranking")
    assert Path(file).read_text(encoding="utf-8") == searched
    gains = tomllib.loads(searched)["translation"]
    assert gains["proportional"][0] == 2.3  # along the contact axis nothing is searched
    assert all(0.01 <= gain <= 3.0 for gain in gains["integral"][1:])
