"""The scores that ship, as they are declared."""

from dataclasses import fields

import numpy as np
import pytest

import skylimb
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.metrics import metrics
from skylimb.analysis.scores.registry import METRICS, NUMERIC_KEYS, SCORES, SETS, TOLERANCES, measured
from skylimb.analysis.scores.score import Metric, Score, Tolerance
from skylimb.base.errors import ConfigError
from skylimb.flight.experiments.tolerances import Tolerances


def test_every_score_is_declared_once_and_says_what_it_is():
    names = [score.name for each in METRICS for score in each.scores]
    assert len(names) == len(set(names))
    assert (
        {*names, "done"} == set(SCORES) == {*NUMERIC_KEYS, *(key for keys in SETS.values() for key in keys)}
    )
    for score in SCORES.values():
        assert score.meaning
        assert not score.meaning.endswith(".")


def test_every_tolerance_of_an_experiment_judges_a_score_in_its_unit():
    sizes = {"of_size", "finest", "frechet", "longer"}  # by which a line's bounds follow what is drawn
    assert {field.name for field in fields(Tolerances)} - sizes == TOLERANCES


def test_the_sets_are_those_that_are_computed_on_demand(make_log):
    found = metrics(make_log())
    for keys in SETS.values():
        assert not set(keys) & set(found)
    run = Run("", "", make_log())
    assert tuple(measured(run, ["contact"])) == SETS["contact"]
    lost = Run("", "", make_log(status="FAILED", cause="fell"))
    assert set(measured(lost, list(SETS)).values()) == {None}


def test_a_path_that_is_a_point_has_no_size(make_log):
    """A pen that is to hold still draws no circle, and so is no number of times as large as one."""
    log = make_log()
    for name in ("cog_position_reference", "cog_position"):
        log[name][:] = log[name].values[0]
    assert measured(Run("", "", log), ["paper"])["trace_size"] is None


def number(run):
    """A number."""
    return np.float64(3.0)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"smaller_is_better": "yes"},
            "score 'number': smaller_is_better = 'yes' is no direction; it is True",
        ),
        ({"kind": "yes"}, "score 'number': kind = 'yes' is not one of number, count, yes or no"),
        ({"tolerance": "pen_line"}, "score 'number' has a tolerance, so it needs smaller_is_better"),
        ({"tolerance": True}, "tolerance = True is neither a key of an experiment's"),
        (
            {"unit": "m", "keys": {"a": Score()}},
            "metric 'number': each of its keys has a declaration of its own",
        ),
    ],
)
def test_what_cannot_be_declared_is_refused_by_name(given, message):
    with pytest.raises(ConfigError, match=message):
        skylimb.metric(**given)(number)


def test_keys_have_what_the_metric_says_or_each_its_own(make_log):
    alike = skylimb.metric(unit="m", row="it", keys=("low", "high"))(number)
    assert isinstance(alike, Metric)
    assert alike.columns == ("number_low", "number_high")
    assert [score.line() for score in alike.scores] == ["it, low", "it, high"]
    apart = skylimb.metric(keys={"low": Score("Lowest", "m"), "high": Score("Highest", "s", name="top")})(
        number
    )
    assert [(score.name, score.titled()) for score in apart.scores] == [
        ("number_low", "Lowest (m)"),
        ("top", "Highest (s)"),
    ]


def test_braces_of_a_users_own_stay_as_they_are():
    assert Score("Set {a} along {u}").text() == "Set {a} along u"


def test_words_and_divisor_of_a_tolerance_may_depend_on_the_run(make_log):
    run = Run("", "", make_log(), {"x": 3.0})
    stated = Tolerance(
        "force", lambda run: f"{run.metrics['x']:g} {{value}}", per=lambda run: run.metrics["x"]
    )
    assert stated.of(run) == Tolerance("force", "3 {value}", 3.0)
    assert Tolerance("force", per=lambda run: None).of(run).per == 0.0
