"""Metrics against signals whose scores are known beforehand."""

import json

import numpy as np
import pytest
import xarray as xr

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.declared import shown_scores
from skylimb.analysis.scores.metrics import metrics
from skylimb.analysis.scores.registry import NUMERIC_KEYS, SCORES
from skylimb.analysis.scores.score import FURTHER, TASK, grouped
from skylimb.analysis.scores.signals import moving_mean

TOLERANCES = {
    "force": 0.1, "force_swing": 0.3, "pen_line": 0.02, "path": 0.95, "contact": 0.95, "strokes": 0.0,
    "lifted": 0.05,
}  # fmt: skip
NOTHING_JUDGED = {"missed": [], "checks": {}, "force_limits": {}, "strokes": []}


def sliding(log):
    return log.phase.values == 4


def test_exactly_the_promised_keys(make_log):
    assert tuple(metrics(make_log())) == (
        "status",
        *NUMERIC_KEYS,
        "missed",
        "checks",
        "force_limits",
        "strokes",
    )
    assert all(SCORES[key].group and SCORES[key].row for key in NUMERIC_KEYS)


def test_known_signals_give_known_scores(make_log):
    scores = metrics(make_log(error=(-0.10, 0.05, -0.02)))
    assert scores["status"] == "OK"
    assert scores["error_u_median"] == pytest.approx(0.05, abs=1e-12)
    assert scores["error_v_median"] == pytest.approx(0.02, abs=1e-12)
    assert scores["displacement_median"] == pytest.approx(0.10, abs=1e-12)
    assert scores["estimated_force_median"] == pytest.approx(-1.0)
    assert scores["contact_force_normal_mean"] == pytest.approx(1.0)
    assert scores["contact_force_normal_std"] == pytest.approx(0.0, abs=1e-12)
    assert scores["contact_force_normal_peak"] == pytest.approx(1.0)
    assert scores["contact_fraction"] == 1.0
    assert scores["tilt_max"] == pytest.approx(0.01)


def test_every_controller_is_held_to_the_mission(make_log):
    log = make_log(error=(-0.10, 0.05, -0.02))
    target = log.cog_position_reference + xr.DataArray([-0.08, 0.06, 0.01], dims="axis")
    aimed = metrics(log.assign(cog_position_target=target))
    plain = metrics(log)
    own = ("target_error_u_median", "target_error_v_median", "target_error_contact_median")
    assert [aimed[key] for key in own] == pytest.approx([0.01, 0.03, 0.02], abs=1e-12)
    assert [plain[key] for key in own] == [None, None, None]
    assert {key: value for key, value in aimed.items() if key not in own} == {
        key: value for key, value in plain.items() if key not in own
    }


def test_groups_show_what_some_flight_has(make_log):
    log = make_log()
    nearest = json.dumps(["rotor1", 0.1, 2.0])
    told = log.assign_attrs(tolerances=json.dumps(TOLERANCES), clearance=nearest)
    told = told.assign(
        contact_force_reference=log.contact_force_normal, tip_position_reference=log.tip_position
    )
    target = told.assign(cog_position_target=log.cog_position)
    lost = make_log(status="FAILED", cause="fell")

    def shown(*logs):
        runs = [Run("", "", each, metrics(each)) for each in logs]
        return {title: [one.name for one in part] for title, part in shown_scores(runs).items()}

    everything = {
        title: [score.name for score in part]
        for title, part in grouped(SCORES[key] for key in NUMERIC_KEYS).items()
    }
    assert [key for keys in everything.values() for key in keys] == list(NUMERIC_KEYS)
    of_a_tool = everything[TASK]
    assert shown(log, target, lost) == {
        title: [key for key in keys if not key.startswith(("lift_", "area_"))]
        for title, keys in everything.items()
        if title != TASK
    }
    without = [key for keys in shown(log, lost).values() for key in keys]
    assert without == [
        key
        for key in NUMERIC_KEYS
        if key not in of_a_tool
        and not key.startswith(("target_", "force_", "done", "lift_", "area_", "clear", "pen_behind"))
    ]
    assert shown(lost) == {}


def test_numbers_are_printed_as_what_they_are():
    assert SCORES["tilt_max"].printed(0.0615) == "0.061"
    assert SCORES["estimated_force_median"].printed(-0.5) == "\N{MINUS SIGN}0.500"
    assert [SCORES["contact_losses"].printed(value) for value in (2.0, 0.5)] == ["2", "0.5"]
    assert SCORES["tilt_max"].printed(None) == ""
    assert [SCORES["done"].printed(value) for value in (True, False, 0.75)] == ["yes", "no", "0.750"]


def test_a_loss_is_a_gap_that_lasts(make_log):
    log = make_log(dt=0.005)
    slide = np.flatnonzero(sliding(log))
    log.contact[slide[100:105]] = 0
    log.contact[slide[200:230]] = 0
    assert metrics(log)["contact_losses"] == 1.0


def test_what_was_never_touched_is_not_lost(make_log):
    log = make_log(dt=0.005)
    log.contact[:] = 0
    assert metrics(log)["contact_losses"] == 0.0
    slide = np.flatnonzero(sliding(log))
    log.contact[slide[500:600]] = 1
    assert metrics(log)["contact_losses"] == 1.0


def test_only_the_sliding_period_counts(make_log):
    log = make_log()
    # The first touch comes before it, and where the pen is beside the robot is seen in free flight.
    others = ("touch_force_peak", "pen_line_", "line_", "strokes")

    def scores():
        return {key: value for key, value in metrics(log).items() if not key.startswith(others)}

    before = scores()
    outside = ~sliding(log)
    for name in ("cog_position", "external_force_estimate", "contact_force_normal", "contact_duty", "tilt"):
        log[name][outside] = 99.0
    assert scores() == before


def test_medians_of_absolute_errors_and_signed_force(make_log):
    log = make_log(error=(0.0, 0.0, 0.0))
    slide = np.flatnonzero(sliding(log))
    sign = np.where(np.arange(len(slide)) % 2 == 0, 1.0, -1.0)
    log.cog_position[slide, 1] += 0.07 * sign
    log.external_force_estimate[slide, 0] = np.linspace(-3.0, 1.0, len(slide))
    scores = metrics(log)
    assert scores["error_u_median"] == pytest.approx(0.07)
    assert scores["estimated_force_median"] == pytest.approx(-1.0)


def test_mean_std_and_fraction_of_a_bouncing_contact(make_log):
    log = make_log()
    slide = np.flatnonzero(sliding(log))
    on = np.arange(len(slide)) % 4 == 0
    log.contact_force_normal[slide] = 2.0 * on
    log.contact_duty[slide] = 0.5 * on
    scores = metrics(log)
    assert scores["contact_force_normal_mean"] == pytest.approx(0.5, rel=1e-3)
    assert scores["contact_force_normal_std"] == pytest.approx(np.sqrt(0.25 * 0.75) * 2.0, rel=1e-3)
    assert scores["contact_fraction"] == pytest.approx(0.125, rel=1e-3)


@pytest.mark.parametrize(
    ("dt", "expected"), [(0.001, 1.0), (0.002, 2.0), (0.005, 5.0), (0.010, 10.0), (0.020, 10.0)]
)
def test_peak_is_that_of_a_10_ms_mean(make_log, dt, expected):
    log = make_log(dt=dt)
    log.contact_force_normal[:] = 0.0
    log.contact_force_normal[np.flatnonzero(sliding(log))[100]] = 10.0
    assert metrics(log)["contact_force_normal_peak"] == pytest.approx(expected)


def test_the_flag_stands_in_for_the_duty(make_log):
    log = make_log().drop_vars("contact_duty")
    slide = np.flatnonzero(sliding(log))
    log.contact[slide[: len(slide) // 2]] = 0
    assert metrics(log)["contact_fraction"] == pytest.approx(0.5, abs=1e-3)


def test_a_failed_flight_is_not_scored(make_log):
    scores = metrics(make_log(status="FAILED", cause="tilt above 1 rad"))
    assert scores == {
        "status": "FAILED", "cause": "tilt above 1 rad", **dict.fromkeys(NUMERIC_KEYS), **NOTHING_JUDGED
    }  # fmt: skip
    assert "NaN" not in json.dumps(scores, allow_nan=False)


def test_without_a_sliding_period_or_a_signal_there_is_no_number(make_log):
    log = make_log()
    hover = metrics(log.isel(time=slice(0, 100)))
    assert hover == {"status": "OK", **dict.fromkeys(NUMERIC_KEYS), **NOTHING_JUDGED}
    real = metrics(log.drop_vars(["contact_force_normal", "contact", "contact_duty"]))
    assert real["contact_force_normal_mean"] is None
    assert real["contact_fraction"] is None
    assert real["error_u_median"] is not None


def test_the_axes_come_from_the_log(make_log):
    log = make_log(error=(0.10, 0.05, -0.02)).assign_attrs(contact_axis="z", sliding_axes=["x", "y"])
    scores = metrics(log)
    assert scores["displacement_median"] == pytest.approx(0.02, abs=1e-12)
    assert scores["error_u_median"] == pytest.approx(0.10, abs=1e-12)
    assert metrics(log.assign_attrs(sliding_axes="x y")) == scores
    vectors = {"contact_axis": [0.0, 0.0, 1.0], "sliding_axes": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]}
    assert metrics(log.assign_attrs(vectors)) == scores


def test_errors_are_measured_along_oblique_axes(make_log):
    c, s = np.cos(0.3), np.sin(0.3)
    turned = {"contact_axis": [c, s, 0.0], "sliding_axes": [-s, c, 0.0, 0.0, 0.0, 1.0]}
    scores = metrics(make_log(error=(0.10 * c, 0.10 * s, -0.02)).assign_attrs(turned))
    assert scores["displacement_median"] == pytest.approx(0.10, abs=1e-12)
    assert scores["error_u_median"] == pytest.approx(0.0, abs=1e-12)
    assert scores["error_v_median"] == pytest.approx(0.02, abs=1e-12)


def test_moving_mean_of_a_ramp_is_its_middle():
    time = 0.001 * np.arange(50)
    np.testing.assert_allclose(moving_mean(time, time, 0.010), time[:41] + 0.0045)
    np.testing.assert_allclose(moving_mean(time, time, 1.0), [time.mean()])


def test_numbers_are_grouped_by_what_they_measure():
    found = grouped(SCORES[key] for key in ("slip_variation", "tilt_max", "error_u_median"))
    names = [[score.name for score in part] for part in found.values()]
    assert names == [["error_u_median"], ["tilt_max"], ["slip_variation"]]
    assert list(found)[-1] == FURTHER
    assert (SCORES["tilt_max"].line(), SCORES["tilt_max"].unit) == ("largest tilt", "rad")
    assert SCORES["slip_variation"].line() == "Standard deviation of the pen's speed over its mean"
