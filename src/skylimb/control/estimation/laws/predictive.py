"""The paper's estimation, with its delay predicted and its constant errors corrected.

    measurement -> `momentum` -> prediction over the latency -> calibration

The observer gets the wrench that acted when the measured motion was made. What it finds while the robot
hovers freely shows errors of the model; the calibration corrects them.
"""

from __future__ import annotations

from dataclasses import field
from typing import Any, NamedTuple

from skylimb.base.keys import configuration
from skylimb.control.estimation.calibration import Calibration, Correction, Learnt, as_scaled, calibrate
from skylimb.control.estimation.delay import (
    Delay,
    DelayState,
    delayed_wrench,
    predict,
    remember,
    require_history,
    shifted,
)
from skylimb.control.estimation.laws import momentum
from skylimb.control.estimation.momentum_observer import known_wrench
from skylimb.control.estimation.records import Estimate, Sensed, Signals, Start, Wrench

needs = momentum.needs
PROVIDES = (*momentum.PROVIDES, "estimate.bias", "estimate.scale")


@configuration
class Gains(momentum.Gains):
    """Gains of the parts."""

    delay: Delay = field(default_factory=Delay)
    calibration: Calibration = field(default_factory=Calibration)


class State(NamedTuple):
    """States of the parts."""

    momentum: momentum.State
    delay: DelayState
    correction: Correction


def initial_state(gains: Gains, start: Start) -> State:
    """A robot that has been hovering, and nothing to correct."""
    return State(momentum.initial_state(gains, start), DelayState(), Correction())


def require(gains: Gains, dt: float) -> None:
    """Raise a `ConfigError` unless the history reaches back to the latency at a control period of `dt` s."""
    require_history("estimation.delay.latency", gains.delay.latency, dt)


def step(gains: Any, state: State, sensed: Sensed) -> tuple[State, Estimate, Signals]:
    """The estimate of this tick."""
    basic, then, signals = momentum.step(gains, state.momentum, sensed)
    # With an IMU the state is that of now.
    now = gains.smoothing.imu
    body = then.body if now else predict(gains.delay, state.delay, then.body, then.raw, sensed.dt)
    known = Learnt(state.correction, basic.push.tare, basic.observer)
    pole = gains.observer.force[2]
    known, estimate, told = calibrate(gains.calibration, known, then, body, pole, sensed)
    basic = basic._replace(observer=known.observer, push=basic.push._replace(tare=known.tare))
    delay = state.delay if known.more is None else shifted(state.delay, known.more)
    return State(basic, delay, known.correction), estimate, signals | told


def commanded(gains: Any, state: State, estimate: Estimate, rotors: Wrench, dt: float) -> State:
    """The state that knows which wrench the rotors make until the next tick."""
    known = known_wrench(estimate.body, as_scaled(gains.calibration, state.correction, rotors))
    delay = remember(state.delay, known)
    known = known if gains.smoothing.imu else delayed_wrench(gains.delay.latency, delay, dt)
    observer = state.momentum.observer._replace(known_force=known.force, known_torque=known.torque)
    return state._replace(momentum=state.momentum._replace(observer=observer), delay=delay)
