"""The error of a commanded force, and what limited it, against signals made to have them."""

import json

import numpy as np
import pytest

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.force import NAMED_FROM, commanded, force_error, force_limits, limited_by

SLIDE = 4


def pressed(log, wanted, force, target=None):
    """A log whose controller commands `wanted` N, presses with `target` and reaches `force` in the slide."""
    sliding = log.phase.values == SLIDE
    touching = log.contact.values > 0

    def held(value):
        return ("time",), np.where(sliding, value, 0.0)

    log = log.assign(contact_force_reference=(("time",), np.where(touching, wanted, 0.0)))
    log = log.assign(contact_force_normal=held(force))
    return log if target is None else log.assign(contact_force_target=held(target))


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
    assert not commanded(log).any()
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


def test_a_pen_off_the_surface_misses_the_whole_force(make_log):
    log = make_log()
    off = during(log, 0.25)
    log.contact[off] = 0
    log = pressed(log, 2.0, 2.0).assign(contact_force_reference=(("time",), np.full(log.sizes["time"], 2.0)))
    log.contact_force_normal[off] = 0.0
    assert errors(log)["percent"] == pytest.approx(25.0, abs=0.1)
    assert force_limits(log)["off_surface"] == pytest.approx(0.25, abs=1e-3)


def test_easing_has_its_share_of_the_time_and_of_the_error(make_log):
    log = pressed(make_log(), 3.0, 2.0, target=3.0)
    log.contact_force_target[during(log, 0.5)] = 1.2
    limits = force_limits(log)
    assert limits["eased"] == pytest.approx(0.5, abs=1e-3)
    assert limits["error_eased"] == pytest.approx(-0.9, abs=1e-2)
    assert limited_by(limits) == "pressed less because the pen lagged its path 50 % of the time"


def test_thrusts_integral_tank_and_friction_have_their_shares(make_log):
    log = pressed(make_log(), 3.0, 2.0)
    count = log.sizes["time"]
    thrusts, share, tank, slip = np.full((count, 4), 10.0), np.zeros(count), np.ones(count), np.ones(count)
    thrusts[during(log, 0.1), 2] = 30.0
    thrusts[during(log, 0.3), 1] = 1.0
    share[during(log, 0.4)] = 1.0
    tank[during(log, 0.2)] = 0.0
    slip[during(log, 0.6)] = 0.0
    log = log.assign(
        thrusts_command=(("time", "rotor"), thrusts),
        contact_force_integral_share=(("time",), share),
        energy_tank_share=(("time",), tank),
        slip_speed=(("time",), slip),
        tip_position_reference=log.cog_position_reference,
    ).assign_attrs(thrust_limits=json.dumps([[1.0] * 4, [30.0] * 4]))
    limits = force_limits(log)
    found = [limits[name] for name in ("rotors", "integral", "tank", "sticking")]
    assert found == pytest.approx([0.3, 0.4, 0.2, 0.6], abs=0.01)
    words = limited_by(limits).split(", ")
    assert words[0] == "stuck by friction 60 % of the time"
    assert [word.split(" % ")[0][-2:] for word in words if "%" in word] == ["60", "40", "30", "20"]


def test_what_did_not_last_is_not_told():
    assert limited_by({"eased": NAMED_FROM / 2.0, "error_eased": -1.0}) == ""
