"""How well a force was estimated: a lag, a noise, a bias and touches that are known come out."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import xarray as xr

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.estimate import lag, pushed
from skylimb.analysis.scores.registry import measured

DT = 0.005
TIME = DT * np.arange(6000)
HOVER, TARE, APPROACH, SLIDE = range(4)


def log(known: np.ndarray, true: np.ndarray, **attributes: Any) -> xr.Dataset:
    """A flight of 30 s: hover, 2 s of tare from 2 s on, an approach until the touch at 10 s, then a slide."""
    phase = np.select([TIME < 2.0, TIME < 4.0, TIME < 10.0], [HOVER, TARE, APPROACH], SLIDE)
    found = xr.Dataset(
        {
            "external_force_estimate": (("time", "axis"), known),
            "contact_force": (("time", "axis"), true),
            "contact": ("time", (np.abs(true).sum(axis=1) > 0.0).astype(int)),
            "phase": ("time", phase),
        },
        {"time": TIME},
    )
    found.phase.attrs = {"flag_values": [0, 1, 2, 3], "flag_meanings": "hover tare approach slide"}
    found.attrs = {"status": "OK", "contact_axis": "x", **attributes}
    return found


def scores(flight: xr.Dataset) -> dict[str, Any]:
    return {
        key.removeprefix("estimate_"): value
        for key, value in measured(Run("", "", flight), ["estimate"]).items()
    }


def pressed() -> np.ndarray:
    """A push back along x from 10 s on that changes slowly."""
    force = np.zeros((len(TIME), 3))
    on = TIME >= 10.0
    force[on, 0] = -1.0 - 0.3 * np.sin(2.0 * (TIME[on] - 10.0))
    return force


def low_passed(force: np.ndarray, rate: float) -> np.ndarray:
    found, state = np.zeros_like(force), np.zeros(3)
    for k, each in enumerate(force):
        state = state + (1.0 - np.exp(-rate * DT)) * (each - state)
        found[k] = state
    return found


@pytest.mark.parametrize("ticks", [0, 7, 40])
def test_a_touch_is_felt_as_late_as_the_estimate_is(ticks: int) -> None:
    true = pressed()
    known = np.vstack([np.zeros((ticks, 3)), true[: len(true) - ticks]])
    found = scores(log(known, true))
    assert found["touch_late"] == pytest.approx(ticks * DT + 0.015, abs=DT)
    assert found["false_touches"] == 0.0
    assert found["noise"] == 0.0


@pytest.mark.parametrize("constant", [0.01, 0.1, 0.333])
def test_a_low_pass_lags_by_its_time_constant(constant: float) -> None:
    rng, true = np.random.default_rng(1), pressed()
    noisy = low_passed(true, 1.0 / constant) + 0.05 * rng.normal(size=true.shape) + 0.3
    assert lag(TIME, noisy, true) == pytest.approx(constant, rel=0.03)


def test_what_does_not_lag_has_no_lag() -> None:
    assert lag(TIME, pressed(), pressed()) < 0.3 * DT


def test_noise_and_bias_are_told_apart() -> None:
    rng = np.random.default_rng(3)
    true = pressed()
    known = true + 0.1 * rng.normal(size=true.shape) + np.array([0.05, 0.0, 0.0]) * (TIME[:, None] > 10.0)
    found = scores(log(known, true))
    assert found["noise"] == pytest.approx(0.1, rel=0.03)
    assert found["bias"] == pytest.approx(0.05, abs=0.005)
    assert found["error_rms"] == pytest.approx(0.05, abs=0.02)  # of means over 0.2 s


def test_touches_that_are_none_are_counted_after_the_tare() -> None:
    true, spike = pressed(), np.zeros((len(TIME), 3))
    for begin, length in ((1.0, 0.1), (3.0, 0.1), (5.0, 0.1), (7.0, 0.1), (8.0, 0.01), (10.1, 0.1)):
        spike[np.abs(TIME - begin - 0.5 * length) < 0.5 * length, 0] = -0.8
    found = scores(log(true + spike, true))
    assert found["false_touches"] == 2.0  # at 5 and 7 s; that at 8 s is too short, that at 10.1 s is a touch


def test_a_touch_that_is_never_felt_has_no_time() -> None:
    found = scores(log(np.zeros((len(TIME), 3)), pressed()))
    assert found["touch_late"] is None
    assert found["false_touches"] == 0.0


def test_a_push_is_a_force_too() -> None:
    event = {"kind": "push", "time": 12.0, "duration": 1.0, "words": "", "force": [0.0, 1.0, 0.0]}
    still = np.zeros((len(TIME), 3))
    flight = log(still, still, events=json.dumps([event]))
    force = pushed(flight)
    acts = (TIME > 12.001) & (TIME < 13.001)
    np.testing.assert_array_equal(force[acts], np.tile([0.0, 1.0, 0.0], (acts.sum(), 1)))
    assert not force[~acts].any()
    # What is felt of a push is no false touch, and what it does is not noise.
    felt = scores(log(low_passed(force, 10.0) - force[:, [1, 0, 2]], still, events=flight.attrs["events"]))
    assert felt["false_touches"] == 0.0
    assert felt["touch_late"] is None
    assert felt["noise"] < 1e-3


def test_what_is_not_recorded_has_no_number() -> None:
    true = pressed()
    assert set(scores(log(true, true).drop_vars("contact_force")).values()) == {None}
    windy = [{"kind": "wind", "time": 1.0, "duration": 1.0, "words": ""}]
    assert set(scores(log(true, true, events=json.dumps(windy))).values()) == {None}
    calm = scores(log(np.zeros_like(true), np.zeros_like(true)))
    assert calm["lag"] is None
    assert calm["bias"] is None
