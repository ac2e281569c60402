"""The bench that ranks all controllers, in its shortest form."""

import sys
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
