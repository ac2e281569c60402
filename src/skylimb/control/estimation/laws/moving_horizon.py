"""The wrench by least squares over the last frames, in which it may jump; all else as in `predictive`.

    measurement -> `predictive`'s body -> window of frames -> tare -> calibration

Frames count where they were made; the body is carried over the assumed latency.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any

from skylimb.base.keys import Key, configuration
from skylimb.control.estimation.body_state import AngleRateFilter, see_body
from skylimb.control.estimation.calibration import Calibration, Learnt, calibrate
from skylimb.control.estimation.delay import Delay, predict, shifted
from skylimb.control.estimation.estimate import estimate_of
from skylimb.control.estimation.force_filter import ForceFilter
from skylimb.control.estimation.laws import predictive
from skylimb.control.estimation.laws.predictive import State
from skylimb.control.estimation.moving_window import Window, WindowGains, looked, rescaled
from skylimb.control.estimation.records import Estimate, Sensed, Signals, Start, Wrench
from skylimb.control.estimation.smoothing import Smoothing, smoothed_body

_POLE = 6.0
"""Of the estimated force as it is set here, about, 1/s."""
PROVIDES = predictive.PROVIDES
needs, require, commanded = predictive.needs, predictive.require, predictive.commanded


@configuration
class Gains:
    """Gains of the parts."""

    angle_rates: AngleRateFilter = field(default_factory=AngleRateFilter)
    smoothing: Smoothing = field(default_factory=Smoothing)
    window: WindowGains = field(default_factory=WindowGains)
    force_filter: ForceFilter = field(default_factory=ForceFilter)
    tare: Annotated[bool, Key("", "whether the bias in free flight is taken off")] = True
    delay: Delay = field(default_factory=Delay)
    calibration: Calibration = field(default_factory=Calibration)


def initial_state(gains: Any, start: Start) -> State:
    """Nothing is known of any wrench."""
    first = predictive.initial_state(gains, start)
    return first._replace(momentum=first.momentum._replace(observer=Window()))


def step(gains: Any, state: State, sensed: Sensed) -> tuple[State, Estimate, Signals]:
    """The estimate of this tick."""
    before: Any = state.momentum
    age = sensed.measurement.capture_age
    rates, seen = see_body(gains.angle_rates, before.angle_rates, sensed)
    kept, body, told = smoothed_body(gains.smoothing, before, seen, rates, sensed)
    window = looked(gains.window, before.observer, seen, age, sensed.dt)
    push, then = estimate_of(gains, before.push, body, Wrench(window.force, window.torque), sensed)
    now = body if gains.smoothing.imu else predict(gains.delay, state.delay, body, then.raw, sensed.dt)
    known = Learnt(state.correction, push.tare, window)
    known, estimate, more = calibrate(gains.calibration, known, then, now, _POLE, sensed)
    window, delay = known.observer, state.delay
    if known.more is not None:
        window, delay = rescaled(window, known.more, sensed.dt), shifted(delay, known.more)
    basic = before._replace(
        angle_rates=rates, smoothed=kept, observer=window, push=push._replace(tare=known.tare)
    )
    return State(basic, delay, known.correction), estimate, told | more
