"""The area of a soft pen, against areas that are known."""

import numpy as np
import pytest
import xarray as xr

import skylimb
from skylimb.analysis.figures import REPORT_FIGURES
from skylimb.analysis.scores.area import CELL, areas, areas_of
from skylimb.analysis.scores.metrics import metrics
from skylimb.analysis.scores.registry import SETS, measured
from skylimb.analysis.scores.user_scores import scored

WORD = {
    "trajectory.text": "v",
    "trajectory.width": 0.05,
    "trajectory.speed": 0.05,
    "trajectory.brush": 0.01,
    "phases.hover": 0.5,
}


def line(length, width, v=0.0, v_width=0.0):
    u = np.arange(0.0, length + 1e-9, 0.2 * CELL)
    return np.column_stack([u, np.full(len(u), v), width + v_width * u / length])


def test_a_line_covers_its_length_times_its_width_and_its_round_ends():
    found = areas_of(line(0.2, 0.012), line(0.2, 0.012))
    exact = 0.2 * 0.012 + 0.25 * np.pi * 0.012**2
    assert np.count_nonzero(found.wanted) * CELL**2 == pytest.approx(exact, rel=0.06)
    np.testing.assert_array_equal(found.wanted, found.drawn)


@pytest.mark.parametrize("beside", [0.002, 0.005, 0.02])
def test_a_line_beside_its_place_shares_what_two_bands_share(beside):
    found = areas_of(line(0.2, 0.012), line(0.2, 0.012, v=beside))
    both = max(0.012 - beside, 0.0)
    share = np.count_nonzero(found.wanted & found.drawn) / np.count_nonzero(found.wanted | found.drawn)
    assert share == pytest.approx(both / (0.024 - both), abs=0.03)


def test_a_press_twice_as_hard_covers_twice_the_area():
    found = areas_of(line(0.3, 0.006), line(0.3, 0.012))
    assert (found.drawn | ~found.wanted).all()
    assert found.drawn.sum() / found.wanted.sum() == pytest.approx(2.0, rel=0.1)


def test_no_force_no_area():
    found = areas_of(line(0.1, 0.01), line(0.1, 0.0))
    assert not found.drawn.any()


@pytest.fixture(scope="module")
def runs():
    return {
        name: skylimb.run("calligraphy", "drawing", set={**WORD, **more})
        for name, more in (("as asked", {}), ("too soft", {"trajectory.force": [1.0, 1.0]}))
    }


def test_a_flight_is_scored_and_drawn(runs):
    as_asked, even = runs.values()
    assert as_asked.metrics["area_iou"] > 0.6
    # The log says what was wanted: lines of one width, or of two.
    widths = [np.unique(run.log.reference_width.dropna("reference_point").round(5)) for run in runs.values()]
    assert widths[0].min() == pytest.approx(0.006)
    assert widths[0].max() == pytest.approx(0.016)
    assert widths[1].tolist() == [0.01]
    assert even.metrics["area_iou"] > 0.6
    picture = next(each for each in REPORT_FIGURES if each.name == "area")
    assert picture.suits(runs)
    assert not picture.suits({"other": skylimb.Run("", "", as_asked.log.drop_vars("reference_width"), {})})
    assert len(picture.draw(runs).axes) == 2


def test_figures_have_no_score_of_a_flight_that_was_lost(runs):
    """The legend said how far its line was off, and the area's corner its IoU."""
    lost = scored(skylimb.Run("as asked", "drawing", runs["as asked"].log.assign_attrs(status="FAILED")))
    for name, number in (("drawing", "rms"), ("area", "IoU")):
        picture = next(each for each in REPORT_FIGURES if each.name == name)

        def words(run, picture=picture):
            axes = picture.draw({"one": run}).axes
            legends = [ax.get_legend() for ax in axes]
            told = [text.get_text() for legend in legends if legend for text in legend.get_texts()]
            return " ".join([*told, *(ax.get_title(loc="right") for ax in axes)])

        assert number in words(runs["as asked"])
        assert number not in words(lost)


def test_a_flight_that_ends_in_touch_has_its_area_as_well(runs):
    log = runs["as asked"].log
    cut = log.isel(time=slice(0, int(np.flatnonzero(log.contact.values > 0)[-1]) + 1))
    whole, found = areas(log), areas(cut)
    assert whole is not None
    assert found is not None
    assert np.count_nonzero(found.drawn) == pytest.approx(np.count_nonzero(whole.drawn), rel=0.02)


@pytest.mark.parametrize("signal", ["contact_force_normal", "tip_position", "cog_position", "slip_speed"])
def test_a_sample_that_is_no_number_costs_numbers_and_raises_nothing(runs, signal):
    """Some touch has no force, or no place: the area was an error of NumPy's, the trace one of LAPACK's."""
    log = runs["as asked"].log
    values = log[signal].values.copy()
    values[np.flatnonzero(log.contact.values > 0)[len(values) // 20]] = np.nan
    spoilt = log.assign({signal: (log[signal].dims, values, log[signal].attrs)})
    scores, further = metrics(spoilt), measured(skylimb.Run("", "", spoilt), SETS)
    assert scores["area_iou"] == (
        None if signal == "contact_force_normal" else pytest.approx(metrics(log)["area_iou"], rel=0.01)
    )
    assert further["trace_distance"] is not None


def test_the_width_at_a_sample_is_that_of_the_force_around_it(runs):
    """Forces that only grow cover the same when time goes back."""
    log = runs["as asked"].log
    force = xr.where(log.contact > 0, 0.2 + 0.05 * (log.time - log.time[0]), 0.0)
    forth = areas(log.assign(contact_force_normal=force))
    back = log.isel(time=slice(None, None, -1)).assign_coords(time=log.time.values)
    turned = areas(back.assign(contact_force_normal=force[::-1].assign_coords(time=log.time.values)))
    assert forth is not None
    assert turned is not None
    apart = np.count_nonzero(forth.drawn ^ turned.drawn)
    assert apart < 0.005 * np.count_nonzero(forth.drawn)


def test_the_force_follows_the_path(runs):
    log = runs["as asked"].log
    wanted = log.contact_force_reference.values
    assert wanted.max() == pytest.approx(1.6, abs=0.05)
    assert runs["as asked"].metrics["force_error_rms"] < 0.15
