"""From an observer's wrench to what the laws see, and the laws of the slot."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.base.packing import numeric
from skylimb.base.rotations import quaternion_from_rotation, rot_z, rotation_from_rpy
from skylimb.control.estimation.body_state import see_body
from skylimb.control.estimation.calibration import Calibration, Correction, calibrated, fed_bias, follow_bias
from skylimb.control.estimation.delay import DEPTH, Delay, delayed_wrench, predict, remember
from skylimb.control.estimation.estimate import PushState, estimate_of
from skylimb.control.estimation.force_filter import ForceFilter, filter_force
from skylimb.control.estimation.laws import momentum, predictive
from skylimb.control.estimation.momentum_observer import known_wrench, observe
from skylimb.control.estimation.records import BodyState, Measurement, Sensed, Start, Wrench
from skylimb.control.estimation.tare import TareState
from skylimb.control.missions.reference import zero_reference
from skylimb.robots.description import GRAVITY
from skylimb.robots.model import Robot

G = np.array([0.0, 0.0, GRAVITY])

DT = 0.005
R = rotation_from_rpy(0.1, -0.2, 0.7)
AXIS = np.array([0.6, 0.0, 0.8])
REFERENCE = zero_reference(3, 4)._replace(contact_axis=AXIS)


def flat(value: Any) -> np.ndarray:
    return np.asarray(value, dtype=float).ravel()


@pytest.fixture(scope="module")
def robot() -> Robot:
    return skylimb.load_robot("hydrus_xi_quad")


# ---- the force filter ----


def test_the_contact_force_is_low_passed_at_its_cutoff() -> None:
    force = 0.5
    for _ in range(30):
        force = filter_force(ForceFilter(1.5), force, -2.0, DT)
    decay = np.exp(-2.0 * np.pi * 1.5 * 30 * DT)
    assert force == pytest.approx(decay * 0.5 - (1.0 - decay) * 2.0)


# ---- tare, filter and arm together ----


def body() -> BodyState:
    model: Any = SimpleNamespace(mass=4.0, gravity=G, tip_C=np.array([1.0, 0.1, 0.2]))
    return BodyState(np.zeros(3), np.zeros(3), R, np.zeros(3), model)


@pytest.mark.parametrize("tared", [True, False])
def test_the_bias_is_taken_off_where_a_tare_is_wanted(tared: bool) -> None:
    gains = SimpleNamespace(tare=tared, force_filter=ForceFilter(2.0))
    bias, raw = np.array([0.3, -0.1, 0.2]), Wrench(np.array([1.0, 2.0, -3.0]), np.array([0.1, 0.2, 0.3]))
    yaw = np.arctan2(R[1, 0], R[0, 0])
    before = PushState()._replace(tare=TareState(bias, 0.1 * bias, 7.0), contact_force=-0.4)
    unit: Any = None
    state, found = estimate_of(gains, before, body(), raw, Sensed(unit, unit, REFERENCE, DT))
    off = 1.0 if tared else 0.0
    np.testing.assert_allclose(found.wrench.force, raw.force - off * rot_z(yaw) @ bias)
    np.testing.assert_allclose(found.wrench.torque, raw.torque - off * 0.1 * bias)
    assert found.raw is raw
    pushed = filter_force(gains.force_filter, -0.4, AXIS @ found.wrench.force, DT)
    assert found.contact_force == state.contact_force == pytest.approx(pushed)
    np.testing.assert_allclose(found.arm, R @ [1.0, 0.1, 0.2])
    assert found.bias is None
    assert state.tare.ticks == 7.0


def test_the_bias_is_collected_while_the_mission_says_so() -> None:
    gains, unit = SimpleNamespace(tare=True, force_filter=ForceFilter(2.0)), None
    raw = Wrench(np.array([1.0, 2.0, -3.0]), np.array([0.1, 0.2, 0.3]))
    sensed: Any = Sensed(unit, unit, REFERENCE._replace(tare=1.0), DT)  # type: ignore[arg-type]
    state, found = estimate_of(gains, PushState(), body(), raw, sensed)
    assert state.tare.ticks == 1.0
    np.testing.assert_allclose(found.wrench.force, 0.0, atol=1e-12)
    assert PushState().contact_force == 0.0


# ---- the laws ----

MEASUREMENT = Measurement(
    np.array([0.1, 0.2, 1.2]),
    quaternion_from_rotation(R),
    np.array([0.3, -0.1, 0.05]),
    np.array([0.2, -0.3, 0.1]),
    np.array([1.0, 0.9, -0.4]),
    np.array([3.0, 0.1, 3.1, 0.2]),
)
ROTORS = Wrench(np.array([1.0, -2.0, 41.0]), np.array([0.1, -0.2, 0.05]))


def begun(law: Any, gains: Any, robot: Robot) -> Any:
    return numeric(law.initial_state(gains, Start(robot, 1.09, np.full(4, 10.0))))


def test_the_papers_law_is_its_parts_in_a_row(robot: Robot) -> None:
    gains = numeric(momentum.Gains())
    sensed = Sensed(robot, MEASUREMENT, REFERENCE, DT)
    state = begun(momentum, momentum.Gains(), robot)
    for _ in range(2):
        before = state
        state, found, signals = momentum.step(gains, before, sensed)
        rates, seen = see_body(gains.angle_rates, before.angle_rates, sensed)
        observer, raw = observe(gains.observer, before.observer, seen, DT)
        push, wanted = estimate_of(gains, before.push, seen, raw, sensed)
        for one, other in ((found.raw, raw), (found.wrench, wanted.wrench)):
            np.testing.assert_allclose(flat(one.force), flat(other.force))
        assert float(found.contact_force) == float(wanted.contact_force) == float(push.contact_force)
        np.testing.assert_allclose(flat(state.angle_rates.smoothed), flat(rates.smoothed))
        np.testing.assert_allclose(flat(state.observer.linear_momentum), flat(observer.linear_momentum))
        state = momentum.commanded(gains, state, found, ROTORS, DT)
        known = known_wrench(seen, ROTORS)
        np.testing.assert_allclose(flat(state.observer.known_force), flat(known.force))
        np.testing.assert_allclose(flat(state.observer.known_torque), flat(known.torque))
        assert signals == {}


def test_the_predictive_law_predicts_and_calibrates_what_the_papers_found(robot: Robot) -> None:
    made = predictive.Gains(
        delay=Delay(0.0125), calibration=Calibration(feed=True, attitude=True, cog=True, rate=3.0)
    )
    gains = numeric(made)
    sensed = Sensed(robot, MEASUREMENT, REFERENCE, DT)
    state = begun(predictive, made, robot)
    correction = Correction(np.array([0.3, -0.2, 0.1]), np.array([0.05, 0.02, -0.01]))
    tare = TareState(np.array([0.5, 0.1, 0.2]), np.array([0.01, 0.02, 0.03]), 9.0)
    basic = state.momentum._replace(push=state.momentum.push._replace(tare=tare))
    state = state._replace(momentum=basic, correction=correction)
    for wrench in (np.arange(6.0), -np.arange(6.0), 2.0 * np.arange(6.0)):
        state = state._replace(delay=remember(state.delay, Wrench(wrench[:3], wrench[3:])))
    after, found, signals = predictive.step(gains, state, sensed)

    plain, then, _ = momentum.step(gains, basic, sensed)
    ahead = predict(gains.delay, state.delay, then.body, then.raw, DT)
    placed, arm = calibrated(gains.calibration, correction, ahead)
    yaw = np.arctan2(float(then.body.R_WC[1, 0]), float(then.body.R_WC[0, 0]))
    bias = fed_bias(gains.calibration, correction, yaw)
    for name in ("position", "velocity", "angular_velocity"):
        np.testing.assert_allclose(flat(getattr(found.body, name)), flat(getattr(placed, name)))
    np.testing.assert_allclose(flat(found.arm), flat(arm))
    np.testing.assert_allclose(flat(found.bias.force), flat(bias.force))
    np.testing.assert_allclose(flat(found.bias.torque), correction.torque)
    np.testing.assert_allclose(flat(found.wrench.force), flat(then.wrench.force))
    weight = then.body.model.mass * then.body.model.gravity[2]
    wanted = follow_bias(gains.calibration, correction, tare, weight, 0.0, DT)
    np.testing.assert_allclose(flat(after.correction.force), wanted.force)
    assert float(after.momentum.push.contact_force) == float(plain.push.contact_force)
    assert signals == {}

    known = known_wrench(found.body, ROTORS)
    later = predictive.commanded(gains, after, found, ROTORS, DT)
    history = remember(after.delay, known)
    np.testing.assert_allclose(flat(later.delay.wrenches[0]), flat(history.wrenches[0]))
    acted = delayed_wrench(gains.delay.latency, history, DT)
    np.testing.assert_allclose(flat(later.momentum.observer.known_force), flat(acted.force))
    np.testing.assert_allclose(flat(later.momentum.observer.known_torque), flat(acted.torque))
    assert np.abs(flat(acted.force) - flat(known.force)).max() > 0.5


def test_a_correction_waits_for_the_end_of_the_tare(robot: Robot) -> None:
    made = predictive.Gains(calibration=Calibration(feed=True))
    state = begun(predictive, made, robot)
    tare = TareState(np.ones(3), np.ones(3), 9.0)
    state = state._replace(momentum=state.momentum._replace(push=state.momentum.push._replace(tare=tare)))
    taring = Sensed(robot, MEASUREMENT, REFERENCE._replace(tare=1.0), DT)
    after, _, _ = predictive.step(numeric(made), state, taring)
    np.testing.assert_array_equal(flat(after.correction.force), 0.0)


def test_a_latency_beyond_the_history_is_refused() -> None:
    gains = predictive.Gains(delay=Delay(0.05))
    predictive.require(gains, 0.05 / (DEPTH - 1))
    with pytest.raises(ConfigError, match=r"estimation\.delay\.latency"):
        predictive.require(gains, 0.99 * 0.05 / (DEPTH - 1))
