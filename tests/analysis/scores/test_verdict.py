"""The verdict on flights that keep or miss what was commanded."""

import json

import numpy as np
import pytest

from skylimb.analysis.scores.metrics import metrics

TOLERANCES = {
    "force": 0.1, "force_swing": 0.3, "pen_line": 0.02, "path": 0.95, "contact": 0.95, "strokes": 0.0,
    "marks": 0.05,
}  # fmt: skip
SLIDE = 4


@pytest.fixture
def flown(make_log):
    """A flight that does all that is commanded, with the pen on its line."""
    log = make_log(error=(0.0, 0.0, 0.0))
    return log.assign(
        contact_force_reference=log.contact_force_normal.copy(deep=True),
        tip_position_reference=log.tip_position,
    ).assign_attrs(tolerances=json.dumps(TOLERANCES))


def first(log, part):
    slide = np.flatnonzero(log.phase.values == SLIDE)
    return slide[: round(part * len(slide))]


def test_all_that_was_commanded_is_judged(flown):
    scores = metrics(flown)
    assert scores["done"] is True
    assert scores["missed"] == []
    assert set(scores["checks"]) == set(TOLERANCES)
    assert all(check["kept"] for check in scores["checks"].values())
    json.dumps(scores, allow_nan=False)


def test_a_mean_force_that_is_missed_is_told_with_its_reason(flown):
    flown.contact_force_reference[:] = 3.0
    eased = {"flag_values": [0, 1], "flag_meanings": "as_commanded eased_for_lag"}
    flown = flown.assign(press_reason=("time", np.ones(flown.sizes["time"]), eased))
    scores = metrics(flown)
    assert scores["done"] is False
    assert not scores["checks"]["force"]["kept"]
    assert scores["missed"][0] == (
        "the mean force is 1.00 of 3.00 N, 67 % off, 10 % allowed "
        "(the press was eased while the pen lagged its path 100 % of the time: -2.00 N)"
    )


@pytest.mark.parametrize(
    ("signal", "unknown"),
    [
        ("contact_force_normal", {"force", "force_swing"}),
        ("contact", {"contact"}),
        ("contact_duty", {"contact"}),
    ],
)
def test_a_truth_with_a_gap_does_not_pass_as_kept(flown, signal, unknown):
    """One sample that is no number took its checks out of the verdict, and the rest was done as commanded."""
    with_gap = flown.contact.astype(float) if signal not in flown else flown[signal].astype(float)
    with_gap[first(flown, 0.5)[-1]] = np.nan
    scores = metrics(flown.drop_vars("contact_duty", errors="ignore").assign({signal: with_gap}))
    assert scores["done"] is False
    assert {name for name, check in scores["checks"].items() if check["value"] is None} == unknown
    assert all("there is none to be judged" in words for words in scores["missed"])


@pytest.mark.parametrize(("force", "kept"), [(0.91, True), (1.09, True), (0.89, False), (1.11, False)])
def test_the_tolerance_of_the_force_holds_both_ways(flown, force, kept):
    flown.contact_force_normal[:] = force * flown.contact_force_reference
    assert metrics(flown)["checks"]["force"]["kept"] is kept


@pytest.mark.parametrize(
    ("force", "off"), [(1.104, "10.4 %"), (0.896, "10.4 %"), (1.10003, "10.003 %"), (1.2, "20 %")]
)
def test_no_rounding_hides_that_a_value_misses_its_bound(flown, force, off):
    flown.contact_force_reference[:] = 1.0
    flown.contact_force_normal[:] = force
    assert f" N, {off} off, 10 % allowed" in metrics(flown)["missed"][0]


def test_a_part_that_is_nearly_the_bound_is_told_below_it(flown):
    off = first(flown, 0.051)
    flown.contact[off] = 0
    flown.contact_duty[off] = 0.0
    assert metrics(flown)["missed"][0] == "the pen touches 94.9 % of the time, 95 % commanded"


def test_a_bound_is_told_as_it_was_given(flown):
    tolerances = json.dumps({**TOLERANCES, "contact": 0.975})
    off = first(flown, 0.03)
    flown.contact[off] = 0
    flown.contact_duty[off] = 0.0
    missed = metrics(flown.assign_attrs(tolerances=tolerances))["missed"]
    assert missed[0] == "the pen touches 97 % of the time, 97.5 % commanded"


def test_a_force_that_swings_about_the_right_mean_is_not_done(flown):
    swing = 1.0 + 0.5 * np.sign(np.sin(2.0 * np.pi * flown.time.values / 2.0))
    flown.contact_force_normal[:] = flown.contact_force_reference * swing
    scores = metrics(flown)
    assert [name for name, check in scores["checks"].items() if not check["kept"]] == ["force_swing"]
    assert scores["missed"][0].startswith("the force swings by ")


def test_a_pen_that_leaves_the_surface_misses_touch_and_path(flown):
    off = first(flown, 0.2)
    flown.contact[off] = 0
    flown.contact_duty[off] = 0.0
    scores = metrics(flown.drop_vars("contact_force_reference"))
    missed = [name for name, check in scores["checks"].items() if not check["kept"]]
    assert missed == ["contact", "path", "strokes"]
    assert scores["missed"][:2] == [
        "the pen touches 80 % of the time, 95 % commanded",
        "82 % of the line is drawn close enough to its shape, 95 % commanded",
    ]


def test_a_pen_beside_its_line_misses_it(flown):
    flown.tip_position[:] = flown.tip_position + np.array([0.0, 0.0, 0.05])
    flown = flown.assign(tip_position_reference=flown.tip_position - np.array([0.0, 0.0, 0.05]))
    scores = metrics(flown)
    assert scores["done"] is False
    assert {"pen_line"} == {name for name, check in scores["checks"].items() if not check["kept"]}


def test_tolerances_are_the_experiments_own(flown):
    flown.contact_force_reference[:] = flown.contact_force_reference * 3.0
    wide = flown.assign_attrs(tolerances=json.dumps({**TOLERANCES, "force": 0.7, "force_swing": 0.7}))
    assert metrics(wide)["done"] is True


def test_without_commanded_contact_there_is_no_verdict(flown):
    assert metrics(flown.assign_attrs(tolerances="{}"))["done"] is None
    del flown.attrs["tolerances"]
    assert metrics(flown)["done"] is None


def test_a_lost_flight_was_not_done(flown):
    lost = metrics(flown.assign_attrs(status="FAILED", cause="fell"))
    assert lost["done"] is False
    assert lost["missed"] == ["the flight was lost"]
    held_back = metrics(flown.assign_attrs(status="UNFINISHED", cause="held back"))
    assert held_back["done"] is False
    assert held_back["missed"] == ["the flight was not finished"]
