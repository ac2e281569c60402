import json

import numpy as np
import pytest
import xarray as xr

from skylimb.analysis.figures import REPORT_FIGURES
from skylimb.analysis.figures.drawing import drawn_line
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.pen_line import as_seen, pen_deviation, pen_line, reference_line
from skylimb.analysis.scores.signals import in_phase


def off(log: xr.Dataset) -> tuple[float, float]:
    """Root mean square and largest distance of the pen from its line, m."""
    found = pen_line(Run("", "", log))
    return found["rms"], found["max"]


CENTRE = [1.2, 0.0, 1.2]


def with_drawing(log, lines, tip_uv=None):
    """The log with an reference line, and the tip moved to (u, v) during the slide."""
    gap = np.full((1, 2), np.nan)
    points = np.vstack([row for line in lines for row in (np.array(line, dtype=float), gap)][:-1])
    log = log.assign(reference_line=xr.Variable(("reference_point", "plane"), points))
    log.attrs["path_center"] = json.dumps(CENTRE)
    if tip_uv is not None:
        slide = np.flatnonzero(in_phase(log, "slide"))
        uv = np.asarray(tip_uv(np.linspace(0.0, 1.0, len(slide)))).T
        tip = log.tip_position.values.copy()
        tip[slide, 1:] = uv + CENTRE[1:]
        log["tip_position"] = (("time", "axis"), tip)
    return log


def test_a_line_drawn_beside_the_asked_one(make_log):
    asked = [[[-0.3, 0.0], [0.3, 0.0]]]
    log = with_drawing(make_log(), asked, lambda s: (-0.3 + 0.6 * s, 0.004 + 0.0 * s))
    assert off(log) == pytest.approx((0.004, 0.004), abs=1e-9)


def test_the_gap_between_two_strokes_is_not_asked_for(make_log):
    asked = [[[-0.3, 0.0], [-0.1, 0.0]], [[0.1, 0.0], [0.3, 0.0]]]
    assert len(reference_line(with_drawing(make_log(), asked))) == 2
    log = with_drawing(make_log(), asked, lambda s: (-0.3 + 0.6 * s, 0.0 * s))
    root, largest = off(log)
    assert largest == pytest.approx(0.1, abs=1e-3)
    away = pen_deviation(log)
    assert root == pytest.approx(np.sqrt(np.mean(away**2)))


def test_distances_are_those_to_the_line_and_not_to_its_points(make_log):
    rng = np.random.default_rng(1)
    asked = rng.uniform(-0.3, 0.3, (12, 2))
    drawn = rng.uniform(-0.3, 0.3, (40, 2))

    def tip(s):
        return tuple(drawn[(s * 39.99).astype(int)].T)

    log = with_drawing(make_log(), [asked], tip)
    sides = np.diff(asked, axis=0)
    exact = []
    for point in drawn:
        along = np.clip(np.sum((point - asked[:-1]) * sides, axis=1) / np.sum(sides**2, axis=1), 0, 1)
        exact.append(np.linalg.norm(point - asked[:-1] - along[:, None] * sides, axis=1).min())
    assert off(log)[1] == pytest.approx(max(exact), abs=1e-5)


def test_a_path_that_is_no_drawing_is_judged_by_its_reference(make_log):
    log = make_log(error=(0.0, 0.0, 0.0))
    assert off(log)[0] < 1e-3
    shifted = make_log(error=(0.0, 0.02, 0.0))
    root, largest = off(shifted)
    assert largest == pytest.approx(0.02, abs=1e-3)
    assert root == pytest.approx(0.02 / np.sqrt(2.0), abs=1e-3)


def test_no_touch_no_number(make_log):
    log = make_log()
    log["contact"] = ("time", np.zeros(log.sizes["time"]))
    assert np.isnan(off(log)).all()
    bare = log.drop_vars(["tip_position"])
    assert np.isnan(off(bare)).all()


def test_a_flight_lost_before_its_slide_has_no_number(make_log):
    log = make_log()
    log = log.isel(time=np.flatnonzero(~in_phase(log, "slide"))[:200])
    assert np.isnan(off(log)).all()


def test_who_stands_behind_the_robot_has_plus_y_to_the_left(make_log):
    np.testing.assert_allclose(as_seen(make_log(), np.array([[0.1, 0.2]])), [[-0.1, 0.2]])


def test_the_figure_shows_drawings_only(make_log, make_run):
    picture = next(picture for picture in REPORT_FIGURES if picture.name == "drawing")
    asked = [[[-0.3, 0.0], [0.3, 0.0]], [[0.0, -0.2], [0.0, 0.2]]]
    log = with_drawing(make_log(), asked, lambda s: (-0.3 + 0.6 * s, 0.01 * np.sin(20 * s)))
    run = Run("hybrid", "hybrid", log)
    assert picture.suits({"hybrid": run})
    assert not picture.suits({"hybrid": make_run()})
    figure = drawn_line({"hybrid": run, "other": run})
    texts = [
        text.get_text() for ax in figure.axes if (legend := ax.get_legend()) for text in legend.get_texts()
    ]
    assert any("rms" in text and "mm" in text for text in texts)
    untouched = log.copy()
    untouched["contact"] = ("time", np.zeros(log.sizes["time"]))
    assert drawn_line({"hybrid": Run("hybrid", "hybrid", untouched)}).axes
