"""Calibration in flight: what a hover tells of a turned sensor and a shifted centre of gravity."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skylimb
from skylimb.analysis.scores.signals import in_phase
from skylimb.base.errors import ConfigError
from skylimb.base.rotations import rot_z, rotation_from_rpy
from skylimb.control.estimation.calibration import (
    LEVER,
    TRIM_POLE,
    Calibration,
    Correction,
    calibrated,
    fed_bias,
    follow_bias,
    is_sound,
    learn_scale,
    trimmed,
)
from skylimb.control.estimation.momentum_observer import ObserverState
from skylimb.control.estimation.records import BodyState, Estimate, Wrench
from skylimb.control.estimation.tare import TareState
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.robots.description import GRAVITY
from skylimb.robots.posed import RobotState
from skylimb.symbolic import stack

MISALIGNED = (0.0, np.radians(1.0), 0.0)
SHIFTED = (0.010, 0.0, 0.0)
HOVER = {
    "phases.hover": 2.0,
    "phases.tare": 3.0,
    "phases.hover_end": 0.2,
    "approach.contact": False,
    "trajectory.shape": "hold",
    "trajectory.duration": 6.0,
}


@pytest.fixture(scope="module")
def model() -> RobotState:
    robot = skylimb.load_robot("hydrus_xi_quad")
    return robot.at([np.pi / 3, np.pi / 3, -np.pi / 6], vectoring_table(robot).angles(np.pi / 6))


def hovering(model: RobotState, yaw: float = 0.0) -> BodyState:
    return BodyState(np.array([0.0, 0.0, 1.2]), np.zeros(3), rot_z(yaw), np.zeros(3), model)


def test_a_turned_sensor_is_turned_back(model: RobotState) -> None:
    """The tip and the centre of gravity of a body that is measured with an error of 1 degree."""
    e, yaw = np.radians([0.6, -0.8, 0.0]), 0.7
    force = -np.cross(e, [0.0, 0.0, model.mass * GRAVITY])
    state = Correction(force, np.zeros(3))
    root = np.array([0.0, 0.0, 1.2])
    to_cog, to_tip = model.R_root_C.T @ model.cog_root, model.R_root_C.T @ model.tip_root
    true_R = rot_z(yaw)
    turned_R = true_R @ (np.eye(3) + np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]]))
    measured = hovering(model, yaw)._replace(position=root + turned_R @ to_cog, R_WC=turned_R)
    body, arm = calibrated(Calibration(attitude=True), state, measured)
    np.testing.assert_allclose(body.position, root + true_R @ to_cog, atol=4e-4)
    np.testing.assert_allclose(body.position + arm, root + true_R @ to_tip, atol=7e-4)
    before = measured.position + turned_R @ model.tip_C
    assert np.linalg.norm(before - root - true_R @ to_tip) > 5e-3


def test_a_shifted_centre_of_gravity_is_found(model: RobotState) -> None:
    d = np.array([0.01, -0.004, 0.0])
    torque = -np.cross(d, [0.0, 0.0, model.mass * GRAVITY])
    measured = hovering(model)
    body, arm = calibrated(Calibration(cog=True), Correction(np.zeros(3), torque), measured)
    np.testing.assert_allclose(body.position - measured.position, d, atol=1e-12)
    # The tip stays where it is measured.
    np.testing.assert_allclose(body.position + arm, measured.position + model.tip_C, atol=1e-12)


def test_nothing_is_done_that_is_not_switched_on(model: RobotState) -> None:
    state, measured = Correction(np.ones(3), np.ones(3)), hovering(model)
    body, arm = calibrated(Calibration(), state, measured)
    np.testing.assert_array_equal(body.position, measured.position)
    np.testing.assert_allclose(arm, model.tip_C, atol=1e-12)
    assert not fed_bias(Calibration(), state, 0.3).force.any()
    assert not fed_bias(Calibration(), state, 0.3).torque.any()
    fed = fed_bias(Calibration(feed=True), state, 0.3)
    np.testing.assert_allclose(fed.force, rot_z(0.3) @ np.ones(3))
    np.testing.assert_allclose(fed.torque, np.ones(3))
    with pytest.raises(ConfigError, match="rate = 0 1/s must be above 0"):
        Calibration(rate=0.0)


def test_the_bias_comes_in_after_the_tare_and_smoothly(model: RobotState) -> None:
    tare, state = TareState(np.array([0.6, 0.0, 0.0]), np.array([0.0, 0.1, 0.0]), 100.0), Correction()
    weight = model.mass * GRAVITY
    state = follow_bias(Calibration(rate=2.0), state, tare, weight, 1.0, 0.005)
    assert not state.force.any()
    assert not state.torque.any()
    for _ in range(100):
        state = follow_bias(Calibration(rate=2.0), state, tare, weight, 0.0, 0.005)
    np.testing.assert_allclose(state.force, (1.0 - np.exp(-1.0)) * tare.force)
    np.testing.assert_allclose(state.torque, (1.0 - np.exp(-1.0)) * tare.torque)


def test_while_the_tare_is_taken_what_turns_by_more_than_the_lever_is_in_force(
    model: RobotState,
) -> None:
    """About the level axes; a second tare is as free to leave what is in force."""
    weight = model.mass * GRAVITY
    most = LEVER * weight
    great = TareState(np.ones(3), np.array([3.0 * most, -1.5 * most, 5.0 * most]), 100.0)
    state = Correction(torque=np.array([0.0, 0.0, 0.2]))
    for _ in range(2):
        state = follow_bias(Calibration(), state, great, weight, 1.0, 0.005)
        np.testing.assert_allclose(state.torque, [2.0 * most, -0.5 * most, 0.2])
        assert not state.force.any()
    near = great._replace(torque=state.torque + 0.9 * most)
    again = follow_bias(Calibration(), state, near, weight, 1.0, 0.005)
    np.testing.assert_array_equal(again.torque, state.torque)


@pytest.mark.parametrize("preset", ["following", "drawing"])
def test_a_centre_of_gravity_that_is_off_turns_no_robot_for_all_of_its_tare(preset: str) -> None:
    """Resisted by nobody, .8 N m turned it by 0.05 rad from its target."""
    keys = {"phases.hover": 0.5, "trajectory.duration": 0.5, "plant.cog_offset": [0.02, 0.0, 0.0]}
    run = skylimb.run("paper", preset, set={**HOVER, **keys})
    assert run.status == "OK", run.cause
    log = run.log.isel(time=np.flatnonzero(in_phase(run.log, "tare"))[-200:])
    turned = (log.attitude_estimate - log.attitude_target).values.mean(axis=0)
    assert np.linalg.norm(turned) < 0.035


def test_up_to_the_tare_what_is_felt_along_the_weight_is_in_force_within_a_quarter(model: RobotState) -> None:
    weight, torque, dt = model.mass * GRAVITY, np.array([0.0, 0.1, 0.0]), 0.005
    before = Correction(np.array([0.1, 0.2, 0.3]), torque)
    for felt, fed in ((-0.1, -0.1), (-0.4, -0.25), (0.4, 0.25)):
        seen, found = Wrench(np.array([3.0, 3.0, felt * weight]), np.ones(3)), before
        for _ in range(400):
            found = trimmed(found, seen, model, 0.0, 5.0, dt)
        np.testing.assert_allclose(found.force, [0.1, 0.2, fed * weight], rtol=1e-6)
        np.testing.assert_array_equal(found.torque, torque)
        np.testing.assert_array_equal(trimmed(before, seen, model, 1.0, 5.0, dt).force, before.force)


def test_the_trim_comes_sooner_than_the_observer(model: RobotState) -> None:
    """A step of force is in force by the trim's own pole: the observer's lag is undone."""
    dt, pole, state, felt = 0.001, 5.0, Correction(), 0.0
    for _ in range(50):
        felt += (1.0 - np.exp(-pole * dt)) * (-4.0 - felt)
        state = trimmed(state, Wrench(np.array([0.0, 0.0, felt]), np.zeros(3)), model, 0.0, pole, dt)
    assert state.force[2] == pytest.approx(-4.0 * (1.0 - np.exp(-TRIM_POLE * 50 * dt)), rel=0.02)


@pytest.mark.parametrize(("share", "sound"), [(0.11, 1.0), (-0.11, 1.0), (0.13, 0.0), (-0.13, 0.0)])
def test_a_robot_whose_bias_is_far_off_is_not_sound(model: RobotState, share: float, sound: float) -> None:
    bias = Wrench(np.array([5.0, 5.0, share * model.mass * GRAVITY]), np.zeros(3))
    assert is_sound(Estimate(hovering(model), bias=bias)) == sound


@pytest.mark.parametrize(("scale", "sound"), [(0.76, 1.0), (1.24, 1.0), (0.74, 0.0), (1.26, 0.0)])
def test_a_robot_whose_rotors_are_far_off_is_not_sound(model: RobotState, scale: float, sound: float) -> None:
    assert is_sound(Estimate(hovering(model), scale=scale)) == sound


@given(
    scale=st.floats(0.8, 1.25),
    lateral=st.tuples(*[st.floats(-1.0, 1.0)] * 2),
    torque=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
    yaw=st.floats(-3.0, 3.0),
)
def test_a_learnt_scale_moves_nothing_that_is_felt(
    model: RobotState, scale: float, lateral: Any, torque: Any, yaw: float
) -> None:
    """A robot that hovers on uneven rotors: the scale is found, bias and known wrench still cancel."""
    weight, body = model.mass * GRAVITY, hovering(model, yaw)
    up = weight - weight / scale
    tare = TareState(np.array([*lateral, up]), np.array(torque), 100.0)
    observer = ObserverState(force=rot_z(yaw) @ tare.force, torque=tare.torque)
    told = stack(-observer.force, -observer.torque)  # what a hovering robot commands, less its weight
    found = learn_scale(Correction(tare.force, tare.torque), tare, observer, body, 0.0)
    assert found.correction.scale == pytest.approx(scale)
    np.testing.assert_allclose(found.tare.force[2], 0.0, atol=1e-9)
    np.testing.assert_allclose(found.correction.force[2], 0.0, atol=1e-9)
    lift = np.array([0.0, 0.0, weight])
    given_ = stack(scale * (told[:3] + lift) - lift, scale * told[3:])
    np.testing.assert_allclose(told + found.more, given_, atol=1e-9)
    felt = stack(found.observer.force, found.observer.torque)
    np.testing.assert_allclose(given_ + felt, 0.0, atol=1e-9)
    # What is taken off is what is felt, and nothing is learnt twice, or while the tare goes on.
    np.testing.assert_allclose(rot_z(yaw) @ found.tare.force, found.observer.force, atol=1e-9)
    again = learn_scale(found.correction, found.tare, found.observer, body, 0.0)
    assert again.correction.scale == pytest.approx(scale)
    assert learn_scale(Correction(), tare, observer, body, 1.0).correction.scale == 1.0


@pytest.mark.parametrize("preset", ["following", pytest.param("drawing", marks=pytest.mark.slow)])
@pytest.mark.parametrize("scale", [0.8, 1.2])
def test_the_force_is_right_with_rotors_that_are_a_fifth_off(preset: str, scale: float) -> None:
    keys = {"trajectory.period": 5.0, "phases.hover": 1.0, "plant.thrust_scale": scale}
    run = skylimb.run("paper", preset, set=keys)
    assert run.status == "OK", run.cause
    assert run.metrics["force_error_percent"] < 3.0
    assert run.log.thrust_scale_estimate.values[-1] == pytest.approx(scale, rel=0.01)


@pytest.mark.parametrize("preset", ["following", "drawing"])
@pytest.mark.parametrize(("share", "sag"), [(0.08, 0.05), (0.12, 0.08), (0.20, 0.12)])
def test_a_thrust_that_is_off_at_take_off_sinks_no_robot(preset: str, share: float, sag: float) -> None:
    for scale in (1.0 - share, 1.0 + share):
        keys = {"phases.hover": 3.0, "phases.tare": 1.0, "trajectory.duration": 0.5}
        run = skylimb.run("paper", preset, set={**HOVER, **keys, "plant.thrust_scale": scale})
        assert run.status == "OK", run.cause
        off = np.abs(run.log.cog_position.values - run.log.cog_position_reference.values)[:, 2]
        assert off.max() < sag
        assert off[-1] < 0.02


def test_both_corrections_in_one_step_in_numbers(model: RobotState) -> None:
    """To first order, in the measured axes: the body turned back by e, the centre of gravity moved by d."""
    force, torque = np.array([0.5, -0.4, 0.2]), np.array([0.2, 0.3, -0.1])
    weight = model.mass * GRAVITY
    e, d = np.array([-0.4, -0.5, 0.0]) / weight, np.array([0.3, -0.2, 0.0]) / weight
    R = rotation_from_rpy(0.1, -0.2, 0.7)
    measured = BodyState(np.array([1.0, 2.0, 3.0]), np.ones(3), R, np.ones(3), model)
    body, arm = calibrated(Calibration(attitude=True, cog=True), Correction(force, torque), measured)
    to_cog = model.R_root_C.T @ model.cog_root + d
    to_tip = model.tip_C - d
    np.testing.assert_allclose(body.position - measured.position, R @ (d - np.cross(e, to_cog)), atol=1e-12)
    np.testing.assert_allclose(arm, R @ (to_tip - np.cross(e, to_tip)), atol=1e-12)
    np.testing.assert_array_equal(body.R_WC, R)
    np.testing.assert_array_equal(body.velocity, measured.velocity)


def test_nothing_is_corrected_before_the_first_tick() -> None:
    state = Correction()
    assert not state.force.any()
    assert not state.torque.any()


def hover(**changes: Any) -> Any:
    on = {f"controller.estimation.calibration.{name}": True for name in ("feed", "attitude", "cog")}
    run = skylimb.run("paper", controller="following", set={**HOVER, **on, **changes})
    assert run.status == "OK", run.cause
    log = run.log
    return log.isel(time=np.flatnonzero(in_phase(log, "slide"))[-200:])


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
def test_in_flight_the_bias_tells_the_misalignment(axis: tuple[float, float, float]) -> None:
    turned = [np.radians(1.0) * entry for entry in axis]
    usual, log = hover(), hover(**{"sensors.attitude_misalignment": turned})
    robot = skylimb.load_robot("hydrus_xi_quad")
    state = robot.at(log.joint_angles.values[-1], log.vectoring_angles.values[-1])
    weight = state.mass * GRAVITY
    bias = (log.external_force_bias.values - usual.external_force_bias.values).mean(axis=0)
    yaw = log.attitude.values[:, 2].mean()
    f = rot_z(yaw).T @ bias
    found = np.array([f[1], -f[0], 0.0]) / weight
    wanted = state.R_root_C.T @ turned
    np.testing.assert_allclose(found[:2], wanted[:2], atol=np.radians(0.1))


def test_in_flight_corrections_bring_tip_and_robot_to_their_places() -> None:
    wrong = {"sensors.attitude_misalignment": list(MISALIGNED), "plant.cog_offset": list(SHIFTED)}
    log = hover(**wrong)
    raw = hover(
        **wrong, **{f"controller.estimation.calibration.{name}": False for name in ("attitude", "cog")}
    )

    def away(log: Any) -> float:
        return float(np.linalg.norm((log.tip_position_estimate - log.tip_position).values.mean(axis=0)))

    assert away(log) < 0.004
    assert away(raw) > 2.0 * away(log)
    off = (log.cog_position_estimate - log.cog_position).values.mean(axis=0)
    assert np.linalg.norm(off[:2]) < 0.003
