"""The error of a commanded force, and what limited it, against signals made to have them."""

import json

import numpy as np
import pytest

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.commanded_force import while_pressing
from skylimb.analysis.scores.force import force_error
from skylimb.analysis.scores.force_limits import NAMED_FROM, force_limits, limited_by
from skylimb.analysis.scores.metrics import metrics

SLIDE = 4


def pressed(log, wanted, force):
    """A log whose controller commands `wanted` N and reaches `force` in the slide."""
    sliding = log.phase.values == SLIDE
    touching = log.contact.values > 0

    def held(value):
        return ("time",), np.where(sliding, value, 0.0)

    log = log.assign(contact_force_reference=(("time",), np.where(touching, wanted, 0.0)))
    return log.assign(contact_force_normal=held(force))


def errors(log):
    return force_error(Run("", "", log))


def during(log, part):
    """The first `part` of the samples of the slide."""
    slide = np.flatnonzero(log.phase.values == SLIDE)
    return slide[: round(part * len(slide))]


def test_a_controller_that_commands_no_force_has_no_error(make_log):
    log = make_log()
    assert force_limits(log) == {}
    assert np.isnan(list(errors(log).values())).all()
    assert not while_pressing(log).any()
    assert np.isnan(list(errors(pressed(log, 0.0, 1.0)).values())).all()


@pytest.mark.parametrize("force", [1.94, 4.06])
def test_the_error_has_a_sign_in_newtons_and_a_size_in_percent(make_log, force):
    scores = errors(pressed(make_log(), 3.0, force))
    assert scores["mean"] == pytest.approx(force - 3.0)
    assert scores["percent"] == pytest.approx(100.0 * 1.06 / 3.0)
    assert scores["rms"] == pytest.approx(1.06)


def test_slow_swings_about_the_right_mean_show_and_chatter_does_not(make_log):
    log = make_log(dt=0.005)
    slow = 1.0 + 0.5 * np.sign(np.sin(2.0 * np.pi * log.time.values / 2.0))
    fast = 1.0 + 0.5 * (-1.0) ** np.arange(log.sizes["time"])
    swings, chatter = (errors(pressed(log, 1.0, force)) for force in (slow, fast))
    assert abs(swings["mean"]) < 0.02
    assert swings["rms"] == pytest.approx(0.5, abs=0.05)
    assert chatter["rms"] < 0.02


TOLERANCES = {"force": 0.1, "force_swing": 0.3, "force_spread": 0.5, "force_peak": 4.0}


def missed(log):
    checks = metrics(log.assign_attrs(tolerances=json.dumps(TOLERANCES)))["checks"]
    return {name for name, check in checks.items() if not check["kept"]}


@pytest.mark.parametrize("frequency", [5.0, 7.5, 10.0, 20.0, 45.0])
def test_a_force_that_swings_from_nothing_to_twice_is_no_steady_one(make_log, frequency):
    """Its 0.2 s mean does not see it."""
    log = make_log(dt=0.005)
    wave = np.sin(2.0 * np.pi * frequency * log.time.values)
    assert missed(pressed(log, 1.0, 1.0 + wave)) == {"force_spread"}
    assert missed(pressed(log, 1.0, 1.0 + 0.6 * wave)) == set()


def test_a_steady_force_that_is_too_small_does_not_hammer(make_log):
    assert missed(pressed(make_log(dt=0.005), 3.0, 0.3)) == {"force", "force_swing"}


def test_blows_are_no_force_however_right_their_mean(make_log):
    log = make_log(dt=0.005)
    blows = np.where(np.arange(log.sizes["time"]) % 40 < 2, 20.0, 0.0)
    assert missed(pressed(log, 1.0, blows)) == {"force_spread", "force_peak"}
    once = np.ones(log.sizes["time"])
    once[during(log, 0.5)[-2:]] = 8.0
    assert missed(pressed(log, 1.0, once)) == {"force_peak"}
    assert errors(pressed(log, 1.0, once))["peak"] == pytest.approx(7.0)


def test_no_mean_goes_over_a_gap_between_two_strokes(make_log):
    """Two strokes of 0.1 s with errors of either sign; glued together they would cancel."""
    log = pressed(make_log(dt=0.005), 1.0, 1.0)
    log.contact_force_reference[:] = 0.0
    slide = during(log, 1.0)
    for number, error in enumerate((0.8, -0.8) * 4):
        stroke = slide[40 * number : 40 * number + 20]
        log.contact_force_reference[stroke] = 1.0
        log.contact_force_normal[stroke] = 1.0 + error
    assert errors(log)["mean"] == pytest.approx(0.0, abs=1e-9)
    assert errors(log)["rms"] == pytest.approx(0.8)


def test_a_pen_off_the_surface_misses_the_whole_force(make_log):
    log = make_log()
    off = during(log, 0.25)
    log.contact[off] = 0
    log = pressed(log, 2.0, 2.0).assign(contact_force_reference=(("time",), np.full(log.sizes["time"], 2.0)))
    log.contact_force_normal[off] = 0.0
    assert errors(log)["percent"] == pytest.approx(25.0, abs=0.1)
    assert force_limits(log)["off_surface"]["share"] == pytest.approx(0.25, abs=1e-3)


def reasoned(log, **shares):
    """A log whose law says one reason after the other, each for its share of the slide."""
    names, code, begin = ["as_commanded", *shares], np.zeros(log.sizes["time"], dtype=np.int8), 0
    slide = np.flatnonzero(log.phase.values == SLIDE)
    for number, share in enumerate(shares.values(), start=1):
        end = begin + round(share * len(slide))
        code[slide[begin:end]] = number
        begin = end
    flags = {"flag_values": np.arange(len(names)), "flag_meanings": " ".join(names)}
    return log.assign(press_reason=("time", code, flags))


def test_every_reason_has_its_share_of_the_time_and_of_the_error(make_log):
    log = reasoned(pressed(make_log(), 3.0, 2.9), eased_for_lag=0.5, saturated=0.25)
    log.contact_force_normal[during(log, 0.5)] = 1.2
    limits = force_limits(log)
    assert {name: round(limit["share"], 2) for name, limit in limits.items() if limit["share"]} == {
        "eased_for_lag": 0.5, "saturated": 0.25, "none": 0.25,
    }  # fmt: skip
    assert limits["eased_for_lag"]["error"] == pytest.approx(-0.9, abs=1e-2)
    assert sum(limit["error"] for limit in limits.values()) == pytest.approx(errors(log)["mean"])
    assert limited_by(limits) == "the press was eased while the pen lagged its path 50 % of the time: -0.90 N"


def test_a_reason_never_stands_beside_an_error_that_it_worked_against(make_log):
    """A press eased for lag is no reason for a force that is too high."""
    log = reasoned(pressed(make_log(), 1.0, 1.5), eased_for_lag=0.4)
    log.contact_force_normal[during(log, 0.4)] = 0.8
    assert errors(log)["mean"] > 0.1
    assert limited_by(force_limits(log)) == ""


def test_a_ramp_of_the_press_is_commanded(make_log):
    """Dashes that are loaded and unloaded as commanded have no error, and no lag is blamed."""
    log = reasoned(pressed(make_log(), 1.0, 0.6), loading=0.3, unloading=0.3)
    assert errors(log)["percent"] == pytest.approx(40.0)
    assert "lagged" not in limited_by(force_limits(log))
    log.contact_force_reference[:] = log.contact_force_normal
    assert errors(log)["percent"] == 0.0


def test_what_the_simulation_saw_comes_where_the_law_says_nothing(make_log):
    log = pressed(make_log(), 3.0, 2.0)
    count = log.sizes["time"]
    thrusts, slip = np.full((count, 4), 10.0), np.ones(count)
    thrusts[during(log, 0.3), 1] = 1.0
    slip[during(log, 0.2)] = 0.0
    log = log.assign(
        thrusts_command=(("time", "rotor"), thrusts),
        slip_speed=(("time",), slip),
        tip_position_reference=log.cog_position_reference,
    ).assign_attrs(thrust_limits=json.dumps([[1.0] * 4, [30.0] * 4]))
    shares = {name: limit["share"] for name, limit in force_limits(log).items()}
    assert [shares[name] for name in ("sticking", "rotors", "none")] == pytest.approx(
        [0.2, 0.1, 0.7], abs=0.01
    )
    told = {name: limit["share"] for name, limit in force_limits(reasoned(log, saturated=0.25)).items()}
    assert [told[name] for name in ("saturated", "sticking")] == pytest.approx([0.25, 0.0], abs=0.01)


def test_what_did_little_is_not_told():
    part = 0.9 * NAMED_FROM
    limits = {"eased_for_lag": {"share": 1.0, "error": -part}, "none": {"share": 0.0, "error": part - 1.0}}
    assert limited_by(limits) == ""
