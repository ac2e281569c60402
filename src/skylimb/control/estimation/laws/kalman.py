"""An extended Kalman filter: body, wrench and an IMU's biases in one, each measurement weighed by its worth.

    measurement -> angle rates -> filter -> tare -> calibration

The state is that of now: a frame is held against where the body was when it was made. With `imu.on` the
specific force shows the wrench as well, before it shows in what is seen.
"""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, NamedTuple

from skylimb.base.keys import Key, configuration
from skylimb.control.estimation.body_filter import (
    Biases,
    Filtered,
    Spread,
    body_of,
    initial_filter,
    moved,
    settled,
)
from skylimb.control.estimation.body_filter_imu import ImuSpread, drifts, felt, first_biases
from skylimb.control.estimation.body_filter_sight import looked
from skylimb.control.estimation.body_state import (
    AngleRateFilter,
    AngleRateState,
    angle_rates,
    initial_angle_rate_state,
)
from skylimb.control.estimation.calibration import Calibration, Correction, Learnt, as_scaled, calibrate
from skylimb.control.estimation.estimate import PushState, estimate_of
from skylimb.control.estimation.force_filter import ForceFilter
from skylimb.control.estimation.gates import numbers
from skylimb.control.estimation.inertial import MEMORY
from skylimb.control.estimation.laws import momentum
from skylimb.control.estimation.momentum_observer import known_wrench
from skylimb.control.estimation.records import Estimate, Sensed, Signals, Start, Wrench
from skylimb.control.needs import Needs
from skylimb.symbolic import stack

_POLE = 10.0
"""Of the estimated force as it is set here, about, 1/s."""
PROVIDES = (*momentum.PROVIDES, "estimate.bias", "estimate.scale")


@configuration
class Gains:
    """Gains of the parts."""

    angle_rates: AngleRateFilter = field(default_factory=AngleRateFilter)
    spread: Spread = field(default_factory=Spread)
    imu: ImuSpread = field(default_factory=ImuSpread)
    force_filter: ForceFilter = field(default_factory=ForceFilter)
    tare: Annotated[bool, Key("", "whether the bias in free flight is taken off")] = True
    calibration: Calibration = field(default_factory=Calibration)


class State(NamedTuple):
    """States of the parts."""

    angle_rates: AngleRateState
    body: Filtered
    push: PushState
    correction: Correction


def needs(gains: Gains) -> Needs:
    """An IMU, where it is used, and frames that are not older than its memory."""
    return Needs(imu=gains.imu.on, memory=MEMORY)


def initial_state(gains: Gains, start: Start) -> State:
    """Nothing is known of any wrench."""
    rates = initial_angle_rate_state(start.robot)
    return State(rates, initial_filter(gains.spread, first_biases(gains.imu)), PushState(), Correction())


def step(gains: Any, state: State, sensed: Sensed) -> tuple[State, Estimate, Signals]:
    """The estimate of this tick."""
    robot, measurement, dt = sensed.robot, sensed.measurement, sensed.dt
    seen = stack(measurement.joint_angles, measurement.vectoring_angles)
    angles = numbers(seen, state.angle_rates.smoothed)
    rates, speeds = angle_rates(gains.angle_rates, state.angle_rates, angles, dt)
    q, psi = angles[: robot.n_joints], angles[robot.n_joints :]
    model = robot.at(q, psi)
    body = moved(gains.spread, state.body, drifts(gains.imu), model, dt)
    body, shown = looked(gains.spread, body, measurement, model, model.cog_jacobian @ speeds, dt)
    if gains.imu.on and measurement.imu is not None:
        shown += felt(gains.imu, body, measurement.imu, robot.imu_at(q, psi, speeds), model)
    body = settled(body, model, shown)
    push, then = estimate_of(gains, state.push, body_of(body, model), Wrench(body.force, body.torque), sensed)
    known = Learnt(state.correction, push.tare, body)
    known, estimate, told = calibrate(gains.calibration, known, then, then.body, _POLE, sensed)
    state = State(rates, known.observer, push._replace(tare=known.tare), known.correction)
    return state, estimate, told | _biases(body)


def commanded(gains: Any, state: State, estimate: Estimate, rotors: Wrench, dt: float) -> State:
    """The state that knows which wrench the rotors make until the next tick."""
    known = known_wrench(estimate.body, as_scaled(gains.calibration, state.correction, rotors))
    return state._replace(body=state.body._replace(known_force=known.force, known_torque=known.torque))


def _biases(body: Filtered) -> Signals:
    if not isinstance(body.biases, Biases):
        return {}
    return {
        "gyro_bias_estimate": body.biases.gyro,
        "accelerometer_bias_estimate": body.biases.accelerometer,
    }
