"""Scores, verdict and figure of tasks with a tool."""

import json

import numpy as np
import pytest

from skylimb.analysis.figures import REPORT_FIGURES, task_progress
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.metrics import metrics
from skylimb.analysis.viewer.signals import packed_panels
from skylimb.flight.experiments.tolerances import Tolerances

SLIDE, RETREAT = 4, 6
LOOSE = {"pen_line": 1.0, "of_size": 10.0, "path": 0.0, "strokes": 1.0, "contact": 0.0}


@pytest.fixture
def worked(make_log):
    """A flight with all three tools at once, each of which ends just where it should."""
    log = make_log()
    count = log.sizes["time"]
    surface = {**json.loads(log.attrs["surface"]), "parameters": {"travel": 1.5, "depth": 0.06}}
    return log.assign(
        valve_angle=("time", np.linspace(0.0, 1.5, count)),
        peg_depth=("time", np.full(count, 0.06)),
        foot_angle=("time", np.zeros(count)),
    ).assign_attrs(surface=json.dumps(surface), tolerances=json.dumps(vars(Tolerances(**LOOSE))))


def last_of_slide(log, seconds):
    slide = np.flatnonzero(log.phase.values == SLIDE)
    time = log.time.values
    return slide[time[slide] > time[slide[-1]] - seconds]


def test_a_task_that_ends_where_it_should_is_done(worked):
    scores = metrics(worked)
    assert scores["done"] is True
    assert {"valve", "peg", "foot"} <= set(scores["checks"])
    assert [scores[key] for key in ("valve_left", "peg_left", "foot_angle_mean")] == pytest.approx([0, 0, 0])


def test_a_valve_counts_where_it_stays(worked):
    worked.valve_angle[-1] = 1.4
    scores = metrics(worked)
    assert scores["valve_left"] == pytest.approx(0.1)
    assert scores["missed"] == ["the valve is 5.7° from its stop in the end, 1.0° allowed"]


def test_a_peg_has_to_stay_in_to_the_end(worked):
    worked.peg_depth[last_of_slide(worked, 0.5)[0]] = 0.056
    scores = metrics(worked)
    assert scores["peg_left"] == pytest.approx(0.004)
    assert scores["missed"] == ["the peg is 4.0 mm from the floor, 1 mm allowed"]
    worked.peg_depth[:] = 0.06
    worked.peg_depth[worked.phase.values != SLIDE] = -0.1  # before and after it may be anywhere
    assert metrics(worked)["done"] is True


def test_a_foot_is_judged_while_it_touches(worked):
    end = last_of_slide(worked, 5.0)
    worked.foot_angle[end] = np.radians(2.0)
    assert metrics(worked)["missed"] == ["the foot is 2.0° from lying flat, 1.0° allowed"]
    # What it does in the air counts for the share of the touch, not for how flat it lies.
    worked.contact[end[: len(end) // 2]] = 0
    worked.contact_duty[end[: len(end) // 2]] = 0.0
    worked.foot_angle[end[len(end) // 2 :]] = 0.0
    assert metrics(worked)["foot_angle_mean"] == 0.0


def test_the_figure_and_the_panels_hold_what_was_commanded(worked, make_log):
    run = Run("task_frame", "task_frame", worked, {})
    figure = task_progress({"one": run, "two": run})
    solid, dashed = figure.axes[0].lines[1], figure.axes[0].lines[0]
    assert np.asarray(dashed.get_ydata())[0] == pytest.approx(np.degrees(1.5))
    assert np.max(np.asarray(solid.get_ydata())) == pytest.approx(np.degrees(1.5), rel=1e-2)
    (picture,) = (picture for picture in REPORT_FIGURES if picture.name == "task")
    assert picture.suits({"one": run})
    assert not picture.suits({"one": run, "two": Run("plain", "plain", make_log(), {})})
    titles = [panel["title"] for panel in packed_panels(worked)["panels"]]
    assert {"Turn of the valve", "Depth of the peg's end"} <= set(titles)


def test_a_foot_that_does_not_touch_in_the_end_misses_what_was_commanded(worked):
    end = last_of_slide(worked, 5.0)
    worked.contact[end] = 0
    worked.contact_duty[end] = 0.0
    scores = metrics(worked)
    assert scores["checks"]["foot"] == {"value": None, "tolerance": Tolerances().foot, "kept": False}
    assert any("foot" in words and "there is none to be judged" in words for words in scores["missed"])
