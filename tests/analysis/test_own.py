"""Metrics and figures of a user's own: by name in tables, reports and campaigns, errors in a line."""

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import skylimb
from skylimb.analysis.measures import describe
from skylimb.analysis.output import metrics_table
from skylimb.analysis.own import GOALS, KNOWN, Metric, OwnFigure, load_own, own_scores, with_own_scores
from skylimb.errors import ConfigError, UserCodeError
from skylimb.recording.run import Run

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_metric.py"


def run(status: str = "OK") -> Run:
    return Run("one", "hybrid", xr.Dataset({"a": ("time", [1.0, 4.0])}, attrs={"status": status}), {"b": 2.0})


@skylimb.metric(unit="m", smaller_is_better=False)
def far(run: Run) -> Any:
    """How far it goes.

    And more.
    """
    return run.log.a.max()


@skylimb.metric(keys=("low", "high"), unit="s")
def span(run: Run) -> Any:
    """From where to where."""
    return {"low": np.nan, "high": 3}


def test_a_metric_has_a_name_a_unit_and_a_goal() -> None:
    assert isinstance(far, Metric)
    assert far(run()).item() == 4.0
    assert own_scores(run(), [far, span]) == {"far": 4.0, "span_low": None, "span_high": 3.0}
    assert own_scores(run("FAILED"), [far, span]) == {"far": None, "span_low": None, "span_high": None}
    assert with_own_scores(run(), [far]).metrics == {"b": 2.0, "far": 4.0}
    assert (GOALS["far"], "span_low" in GOALS) == (-1.0, False)
    assert describe("far") == ("How far it goes", "m")
    assert describe("span_low") == ("From where to where, low", "s")
    assert set(KNOWN) >= {"far", "span_low", "span_high"}
    table = metrics_table({"one": with_own_scores(run(), [far])}).splitlines()
    assert table[0].endswith(",far")
    assert table[1].endswith(",4.0")


@pytest.mark.parametrize(
    ("value", "keys", "message"),
    [
        (
            {"x": 1.0},
            (),
            r"^metric 'bad' should return a number, it returned .*; name them: @skylimb\.metric\(keys",
        ),
        (1.0, ("x",), r"should return a dict with x, it returned 1\.0$"),
        ({"y": 1.0}, ("x",), "should return a dict with x"),
        ("many", (), "metric 'bad' fails: ValueError: could not convert string"),
    ],
)
def test_what_a_metric_returns_is_checked(value: Any, keys: tuple[str, ...], message: str) -> None:
    bad = Metric("bad", lambda run: value, keys=keys)
    with pytest.raises(UserCodeError, match=message):
        bad.of(run())


def test_an_error_names_the_users_line(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(
        "import skylimb\n@skylimb.metric\ndef wrong(run):\n    return run.log.nothing\n", encoding="utf-8"
    )
    with pytest.raises(
        UserCodeError, match=r"metric 'wrong' fails in .*mine\.py, line 4, `return run\.log\.nothing`: Attr"
    ):
        own_scores(run(), load_own([file]))
    file.write_text("x = 1\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"mine\.py' has no metric and no figure"):
        load_own([file])
    file.write_text("import skylimb\n@skylimb.metric\ndef tilt_max(run): ...\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="metric 'tilt_max' has the name of one that ships"):
        load_own([file])


def test_a_figure_is_a_matplotlib_figure() -> None:
    @skylimb.figure
    def drawn(run: Run) -> Any:
        """A line."""
        return plt.figure() if run.name == "one" else 3

    assert isinstance(drawn, OwnFigure)
    assert (drawn.name, drawn.caption) == ("drawn", "A line.")
    assert isinstance(drawn(run()), Figure)
    plt.close("all")
    with pytest.raises(
        UserCodeError, match="figure 'drawn' should return a matplotlib figure, it returned int"
    ):
        drawn(Run("two", "pid", run().log))


def test_the_example_has_both() -> None:
    assert [one.name for one in load_own([EXAMPLE])] == ["overshoot", "tilt_spread", "thrusts"]
