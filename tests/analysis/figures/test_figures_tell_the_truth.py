"""Figures show what matters: the force behind an estimate's noise, and how far the body was moved."""

import numpy as np
from matplotlib.collections import FillBetweenPolyCollection
from matplotlib.colors import to_hex

from skylimb.analysis.figures import REPORT_FIGURES, over_time, pose_strip, style
from skylimb.analysis.recording import Run
from skylimb.analysis.report.report import _facts


def test_noise_of_the_estimate_does_not_hide_the_force(make_log):
    """Half a newton of noise on each sample: the curve keeps to the truth, a band shows the noise."""
    log = make_log()
    noise = np.random.default_rng(0).normal(0.0, 0.5, log.sizes["time"])
    noisy = log.external_force_estimate.values + noise[:, None] * [1.0, 0.0, 0.0]
    log = log.assign(external_force_estimate=(("time", "axis"), noisy))
    figure = over_time.contact_direction({"pid": Run("pid", "pid", log, {})})
    below = figure.axes[1]
    estimate, truth = (np.asarray(line.get_ydata()) for line in below.lines[1:])
    assert np.std(estimate - truth) < 0.15
    [band] = [each for each in below.collections if isinstance(each, FillBetweenPolyCollection)]
    heights = np.asarray(band.get_paths()[0].vertices)[:, 1]
    assert heights.max() > 0.5
    assert heights.min() < -1.5
    assert to_hex(np.asarray(band.get_facecolor())[0]) == style.CONTROLLER_COLOURS["pid"].lower()


def test_a_pose_shows_how_far_the_body_was_moved(make_run):
    """The grey robot stands at the reference: what separates it from the coloured one is the displacement."""
    run = make_run("pid", error=(-0.13, 0.0, 0.0))
    figure = pose_strip.poses({"pid": run})
    for ax in figure.axes:
        grey, _, coloured = ax.lines[:3]  # between them the board
        assert grey.get_color() == pose_strip.GHOST
        assert coloured.get_color() == style.CONTROLLER_COLOURS["pid"]
        moved = np.asarray(coloured.get_xdata()) - np.asarray(grey.get_xdata())
        np.testing.assert_allclose(moved, moved[0], atol=1e-12)  # a stiff arm: the shape is the same
        assert any("moved \N{MINUS SIGN}0.13 m in x" in text.get_text() for text in ax.texts)
        reference, cog = (np.asarray(line.get_xdata()) for line in ax.lines if line.get_marker() == "P")
        np.testing.assert_allclose(cog - reference, -0.13)


def test_a_drawing_has_no_figure_that_joins_its_strokes(make_run):
    run = make_run(slide=2.0)
    drawing = Run("a", "following", run.log.assign(reference_line=run.log.tilt), {})
    traces = next(picture for picture in REPORT_FIGURES if picture.name == "pen_traces")
    assert traces.suits({"a": run})
    assert not traces.suits({"a": drawing})


def test_no_caption_speaks_of_a_path_that_may_be_another():
    for picture in REPORT_FIGURES:
        assert "circle" not in picture.caption
        assert "lap" not in picture.caption.split()


def test_a_drawings_file_is_named_without_its_folder():
    facts = dict(_facts({"trajectory": {"shape": "drawing", "file": "sources/7b3da0ab/cat.svg"}}))
    assert facts["Drawing"] == "cat.svg"


def test_a_file_of_ones_own_is_called_by_its_name():
    copy = "sources/bumps-672a6ef0/bumps.py"
    facts = dict(_facts({"surface": {"kind": copy}, "trajectory": {"shape": f"{copy}:heart"}}))
    assert (facts["Surface"], facts["Path"]) == ("bumps.py", "bumps.py:heart")


def test_a_paths_facts_are_those_of_its_shape():
    path = {"radius": 0.3, "length": 0.6, "period": 14.0, "direction": 1}

    def named(shape):
        return {name for name, _ in _facts({"trajectory": {"shape": shape, **path}})}

    assert named("circle") == {"Path", "Radius", "Period", "Direction"}
    assert named("line") == {"Path", "Length", "Direction"}
    assert named("drawing") == {"Path"}
    assert named("hold") == {"Path"}
