"""Metrics and figures of a user's own: by name in tables, reports and campaigns, errors in a line."""

import dataclasses
import re
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import skylimb
from skylimb.analysis.recording.run import Run
from skylimb.analysis.report.output import metrics_table
from skylimb.analysis.scores.declared import declared_in, shown_scores
from skylimb.analysis.scores.score import Metric
from skylimb.analysis.scores.user_scores import (
    UserFigure,
    load_user_scores,
    scored,
)
from skylimb.base.errors import ConfigError, UnknownNameError, UserCodeError

EXAMPLE = Path(__file__).parents[3] / "examples" / "user_metric.py"


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


def test_a_metric_has_a_name_a_unit_and_a_direction() -> None:
    assert isinstance(far, Metric)
    assert far(run()).item() == 4.0
    found = scored(run(), [far, span]).metrics
    assert (found["far"], found["span_low"], found["span_high"]) == (4.0, None, 3.0)
    lost = scored(run("FAILED"), [span]).metrics
    assert (lost["span_low"], lost["span_high"]) == (None, None)
    (score,), (low, _) = far.scores, span.scores
    assert (score.sign, low.directed) == (-1.0, False)
    assert (score.text(), score.unit) == ("How far it goes", "m")
    assert (low.text(), low.unit) == ("From where to where, low", "s")
    table = metrics_table({"one": scored(run(), [far])}).splitlines()
    assert table[0].endswith(",far")
    assert table[1].endswith(",4.0")


@skylimb.metric(unit="m", smaller_is_better=True, group="Force", row="farther", tolerance="pen_line")
def farther(run: Run) -> Any:
    """How far it goes along {u}."""
    return run.log.a.max()


@skylimb.metric(smaller_is_better=False, kind="count", tolerance=5)
def steps(run: Run) -> Any:
    """Steps that it takes."""
    return run.log.sizes["time"]


def test_a_metric_is_judged_by_its_tolerance_and_stands_in_its_group(make_log: Any, tmp_path: Path) -> None:
    flown = Run("one", "hybrid", make_log().assign(a=("b", [1.0, 0.03])))
    flown.log.attrs["tolerances"] = '{"pen_line": 0.02}'
    flown = scored(flown, [farther, steps, span])
    assert flown.done is False
    assert flown.metrics["checks"]["farther"] == {"value": 1.0, "tolerance": 0.02, "kept": False}
    assert flown.metrics["checks"]["steps"]["kept"] is True
    assert flown.missed[-1] == "How far it goes along y: 1000.0 mm, 20 mm allowed"
    # The record carries what the scores are, so it is shown and judged without the file that computed them.
    loaded = Run.load(flown.save(tmp_path / "log.nc"))
    assert loaded.metrics == flown.metrics
    assert list(declared_in(loaded.log)) == ["farther", "steps", "span_low", "span_high"]
    shown = shown_scores([loaded])
    assert [score.line() for score in shown["Force"]][-1] == "farther"
    assert [score.name for score in shown["Further numbers"]] == ["steps", "span_high"]
    assert shown["Further numbers"][0].printed(7.0) == "7"
    assert scored(loaded).metrics == flown.metrics
    lost = scored(Run("one", "hybrid", flown.log.assign_attrs(status="FAILED")))
    assert lost.missed == ["the flight was lost"]


def test_a_bound_of_its_own_judges_a_flight_that_nothing_else_judges() -> None:
    assert scored(run(), [steps]).missed == ["Steps that it takes: 2, 5 commanded"]
    assert scored(run("FAILED"), [steps]).done is False
    assert scored(run("FAILED"), [far]).done is None


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
        ("many", (), "metric 'bad' should return a number, or NaN where there is none; it returned 'many'$"),
        (None, (), "it returned None$"),
        (1j, (), "it returned 1j$"),
        (np.ones(300), (), r"it returned array\(\[1\., 1\., .*\.\.\.$"),
        ({"x": [1.0]}, ("x",), r"metric 'bad_x' should return a number, .* it returned \[1\.0\]$"),
    ],
)
def test_what_a_metric_returns_is_checked(value: Any, keys: tuple[str, ...], message: str) -> None:
    def bad(run: Run) -> Any:
        return value

    found = scored(run(), [skylimb.metric(bad, keys=keys), far])
    (problem,) = found.problems.items()
    assert problem[0] == "metric 'bad'"
    assert re.search(message, problem[1])
    assert found.metrics["far"] == 4.0  # the others are computed all the same
    assert found.metrics["bad_x" if keys else "bad"] is None


def test_what_failed_is_told_until_it_is_computed(tmp_path: Path) -> None:
    failing = dataclasses.replace(far, function=lambda run: 1 / 0)
    found = scored(run(), [failing, span])
    assert list(found.problems) == ["metric 'far'"]
    assert found.problems["metric 'far'"].endswith("ZeroDivisionError: division by zero")
    loaded = Run.load(found.save(tmp_path / "log.nc"))
    assert loaded.problems == found.problems
    assert scored(loaded).problems == found.problems  # nobody computed it anew
    mended = scored(loaded, [far])
    assert (mended.problems, mended.metrics["far"], mended.metrics["span_high"]) == ({}, 4.0, 3.0)


def test_an_error_names_the_users_line(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(
        "import skylimb\n@skylimb.metric\ndef wrong(run):\n    return run.log.nothing\n", encoding="utf-8"
    )
    (why,) = scored(run(), load_user_scores([file])).problems.values()
    assert re.match(r"metric 'wrong' fails in .*mine\.py, line 4, `return run\.log\.nothing`: Attr", why)
    file.write_text("x = 1\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"mine\.py' has no metric and no figure"):
        load_user_scores([file])
    file.write_text("import skylimb\n@skylimb.metric\ndef tilt_max(run): ...\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="metric 'tilt_max' has the name of one that ships"):
        load_user_scores([file])
    with pytest.raises(
        UnknownNameError, match="tolerance of metric 'far' 'pen_lin'; did you mean 'pen_line'"
    ):
        load_user_scores([skylimb.metric(far.function, smaller_is_better=True, tolerance="pen_lin")])


def test_a_figure_is_a_matplotlib_figure() -> None:
    @skylimb.figure
    def drawn(run: Run) -> Any:
        """A line."""
        return plt.figure() if run.name == "one" else 3

    assert isinstance(drawn, UserFigure)
    assert (drawn.name, drawn.caption) == ("drawn", "A line.")
    assert isinstance(drawn(run()), Figure)
    plt.close("all")
    with pytest.raises(
        UserCodeError, match="figure 'drawn' should return a matplotlib figure, it returned int"
    ):
        drawn(Run("two", "pid", run().log))


def test_the_example_has_both() -> None:
    assert [one.name for one in load_user_scores([EXAMPLE])] == ["overshoot", "tilt_spread", "thrusts"]


def test_a_required_metric_without_a_number_is_missed_and_stays_so_in_the_record() -> None:
    @skylimb.metric(unit="m", smaller_is_better=True, tolerance=skylimb.Tolerance(0.1, required=True))
    def found(run: Run) -> float:
        """How far it is."""
        return np.nan

    @skylimb.metric(unit="m", smaller_is_better=True, tolerance=0.1)
    def optional(run: Run) -> float:
        """How far it is, where it is at all."""
        return np.nan

    judged = scored(run(), [found, optional])
    assert (judged.done, judged.missed) == (False, ["How far it is: there is none to be judged"])
    assert scored(judged).missed == judged.missed


@pytest.mark.parametrize(
    "line", ["run.metrics['b'] = 0.0", "t = run.log.a.values; t *= 57.3", "run.log.a[0] = 7.0"]
)
def test_a_metric_cannot_change_what_others_read(tmp_path: Path, line: str) -> None:
    file = tmp_path / "own.py"
    file.write_text(
        f"import skylimb\n@skylimb.metric\ndef writes(run):\n    {line}\n    return 1.0\n"
        "@skylimb.metric\ndef adds(run):\n    run.log['a'] = 2.0 * run.log.a\n    return run.log.a.max()\n",
        encoding="utf-8",
    )
    one = run()
    found = scored(one, load_user_scores([file, far]))
    assert (found.metrics["writes"], found.metrics["adds"], found.metrics["far"]) == (None, 8.0, 4.0)
    assert f"own.py, line 4, `{line}`" in found.problems["metric 'writes'"]
    np.testing.assert_array_equal(found.log.a, [1.0, 4.0])
    one.log.a.values[0] = 3.0  # whose run it is may write to it as before


def test_a_figure_cannot_change_the_log() -> None:
    @skylimb.figure
    def scaled(run: Run) -> Any:
        run.log.a.values[:] = 0.0

    with pytest.raises(UserCodeError, match="read-only"):
        scaled(run())


def test_infinity_is_named() -> None:
    bad = skylimb.metric(lambda run: {"x": -np.inf, "y": 2.0, "z": np.nan}, keys=("x", "y", "z"))
    found = scored(run(), [bad])
    assert list(found.problems.values()) == [
        "metric '<lambda>' returned -inf as <lambda>_x; expected a finite number, or NaN where there is none"
    ]
    assert [found.metrics[f"<lambda>_{key}"] for key in "xyz"] == [None, 2.0, None]


def hardest(run: Any) -> float:
    return float(run.log.contact_force_normal.max())


@pytest.mark.parametrize(
    ("use", "told"),
    [
        ([hardest], "use: 'hardest' is neither a Python file nor a metric or figure; put @skylimb.metric"),
        ("mine.py", r"use = 'mine.py' should be a list, as in use=\['mine.py'\]"),
    ],
)
def test_a_function_without_its_decorator_is_named(use: Any, told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        load_user_scores(use)
