"""The laws of the allocation slot and their parts: leak, small moves of the vectoring angles."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from made_robots import multirotor
from skylimb.base.errors import ConfigError
from skylimb.base.packing import numeric
from skylimb.base.rotations import rotation_from_rpy
from skylimb.control.allocation.lateral import Moves, lateral_move
from skylimb.control.allocation.laws import pseudoinverse, vectored
from skylimb.control.allocation.leak import Leak, TorqueLeak, follow_leak, side_force, without_leak
from skylimb.control.allocation.rotor_lag import RotorLag, at_rest, lead_thrusts
from skylimb.control.allocation.thrusts import Thrusts, allocate
from skylimb.control.estimation.body_state import rotor_wrench
from skylimb.control.estimation.records import Start, Wrench
from skylimb.control.needs import Needs
from skylimb.control.records import Demand, LawInput
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState
from skylimb.symbolic import right_inverse

DT = 0.005
R = rotation_from_rpy(0.05, -0.1, 0.4)
TORQUE, FELT = np.array([0.1, -0.2, 0.15]), np.array([0.3, -0.1, 0.2])
AWAY = np.array([0.02, -0.03, 0.04, 0.01])
"""Of the measured vectoring angles from the nominal ones, rad."""

Make = Callable[..., LawInput]


def flat(value: Any) -> np.ndarray:
    return np.asarray(value, dtype=float).ravel()


@pytest.fixture
def at(
    make_inputs: Make, robot: Robot, model: RobotState, joint_angles: Any, vectoring_angles: Any
) -> LawInput:
    return make_inputs(
        model,
        robot=robot,
        R=R,
        q=joint_angles,
        psi=vectoring_angles + AWAY,
        torque=np.array([0.3, -0.1, 0.2]),
    )


@pytest.fixture
def demand(model: RobotState, joint_angles: Any, vectoring_angles: Any) -> Demand:
    force = model.mass * model.gravity + np.array([0.6, -0.4, 0.3])
    return Demand(force, force - np.array([0.2, 0.1, 0.05]), TORQUE, joint_angles, vectoring_angles)


# ---- leak ----


def test_the_leak_is_the_force_of_the_thrusts_that_turn(at: LawInput) -> None:
    thrusts = Thrusts(np.zeros(4), np.array([1.0, -2.0, 0.5, 1.5]))
    Q = at.estimate.body.model.allocation_C
    np.testing.assert_allclose(side_force(TorqueLeak(), at, thrusts), R @ Q[:3] @ thrusts.rotation)


def test_the_steady_leak_is_that_of_the_torque_that_holds_against_contact_and_bias(
    at: LawInput, make_inputs: Make
) -> None:
    Q = at.estimate.body.model.allocation_C
    bias = np.array([0.05, 0.02, -0.04])
    at = at._replace(estimate=at.estimate._replace(bias=Wrench(np.zeros(3), bias)))
    holding = -FELT - bias
    rotation = np.linalg.pinv(Q[2:]) @ np.array([0.0, *holding])
    found = side_force(TorqueLeak(steady=True), at, Thrusts(np.zeros(4), np.ones(4)))
    np.testing.assert_allclose(found, R @ Q[:3] @ rotation, atol=1e-9)
    np.testing.assert_allclose((Q @ rotation)[2:], [0.0, *holding], atol=1e-9)


def test_a_known_leak_is_taken_off_only_where_it_is_compensated() -> None:
    leak, force = np.array([0.1, -0.2, 0.3]), np.array([1.0, 2.0, 40.0])
    np.testing.assert_array_equal(without_leak(Leak(), leak, force), force)
    np.testing.assert_allclose(without_leak(Leak(compensate=True), leak, force), [0.9, 2.2, 39.7])


def test_the_leak_is_low_passed_at_its_cutoff() -> None:
    gains, leak, now = Leak(cutoff=2.0), np.zeros(3), np.array([1.0, -2.0, 3.0])
    for _ in range(40):
        leak = follow_leak(gains, leak, now, DT)
    np.testing.assert_allclose(leak, (1.0 - np.exp(-2.0 * np.pi * 2.0 * 40 * DT)) * now)


# ---- small moves ----


def side_of(robot: Robot, model: RobotState, q: Any, psi: Any, move: Any, lift: float, torque: Any) -> Any:
    """Side force of the thrusts for lift and torque at moved angles, N, in {C} of the nominal ones."""
    moved = robot.at(q, psi + move)
    turn = model.R_root_C.T @ moved.R_root_C
    Q = np.kron(np.eye(2), turn) @ moved.allocation_C
    return (Q @ (right_inverse(Q[2:, :]) @ np.array([lift, *torque])))[:2]


def test_small_moves_give_the_side_force_that_is_missing(
    robot: Robot, model: RobotState, make_inputs: Make, joint_angles: Any, vectoring_angles: Any
) -> None:
    q, psi, lift = joint_angles, vectoring_angles, model.mass * 9.80665
    wanted = side_of(robot, model, q, psi, np.zeros(4), lift, TORQUE) + np.array([0.1, -0.05])
    at = make_inputs(model, robot=robot, R=R, q=q, psi=psi)
    force = R @ np.array([*wanted, lift])
    gains, move = numeric(Moves(damping=1e-6, cutoff=1000.0)), np.zeros(4)
    for _ in range(20):
        move = flat(lateral_move(gains, move, at, Demand(force, force, TORQUE, q, psi))[0])
    np.testing.assert_allclose(side_of(robot, model, q, psi, move, lift, TORQUE), wanted, atol=1e-4)


def slopes(robot: Robot, model: RobotState, q: Any, psi: Any, move: Any, lift: float) -> np.ndarray:
    """dh/dpsi by differences, N/rad, (2, 4)."""
    step = 1e-5
    sides = [
        [side_of(robot, model, q, psi, move + sign * step * e, lift, TORQUE) for sign in (1, -1)]
        for e in np.eye(4)
    ]
    return np.array([(ahead - behind) / (2 * step) for ahead, behind in sides]).T


@pytest.mark.parametrize("damping", [0.5, 20.0])
def test_one_step_is_the_damped_least_move_behind_a_low_pass(
    robot: Robot, model: RobotState, at: LawInput, demand: Demand, damping: float
) -> None:
    q, psi, move = demand.joint_angles, demand.vectoring_angles, np.array([0.05, -0.02, 0.03, 0.01])
    force = R.T @ demand.force
    h = side_of(robot, model, q, psi, move, force[2], TORQUE)
    J = slopes(robot, model, q, psi, move, force[2])
    missing = force[:2] - h + J @ move
    wanted = J.T @ np.linalg.solve(J @ J.T + damping * np.eye(2), missing)
    decay = np.exp(-2.0 * np.pi * 3.0 * DT)
    found, side = lateral_move(numeric(Moves(damping=damping, cutoff=3.0, limit=3.0)), move, at, demand)
    np.testing.assert_allclose(flat(found), decay * move + (1.0 - decay) * wanted, atol=1e-7)
    np.testing.assert_allclose(flat(side), [*(h - J @ move), 0.0], atol=1e-6)


def test_no_angle_moves_beyond_its_limit(at: LawInput, demand: Demand) -> None:
    far = demand._replace(force=demand.force + R @ np.array([40.0, 40.0, 0.0]))
    gains = numeric(Moves(damping=1e-3, cutoff=1e3, limit=0.2))
    move = flat(lateral_move(gains, np.zeros(4), at, far)[0])
    assert np.abs(move).max() == pytest.approx(0.2, rel=1e-6)
    other = flat(lateral_move(gains, np.zeros(4), at, far._replace(force=2 * demand.force - far.force))[0])
    assert move.max() == pytest.approx(0.2, rel=1e-6) or move.min() == pytest.approx(-0.2, rel=1e-6)
    assert np.abs(other).max() == pytest.approx(0.2, rel=1e-6)
    assert (np.sign(other[np.abs(move) > 0.19]) == -np.sign(move[np.abs(move) > 0.19])).all()


def test_no_angle_moves_beyond_its_joints_stops(make_inputs: Make, tmp_path: Path) -> None:
    """The stops are of the angle, and the move is from the nominal one."""
    turning = skylimb.load_robot(multirotor(tmp_path, rotors=4, turn_limit=0.5))
    none, nominal = np.zeros(0), np.array([0.3, -0.3, 0.3, -0.3])
    model = turning.at(none, nominal)
    at = make_inputs(model, robot=turning, q=none, psi=nominal)
    gains = numeric(Moves(damping=1e-3, cutoff=1e3, limit=3.0))
    weight = model.mass * model.gravity
    for side in (50.0, -50.0):
        force = weight + np.array([side, 0.7 * side, 0.0])
        move = flat(lateral_move(gains, np.zeros(4), at, Demand(force, force, np.zeros(3), none, nominal))[0])
        assert np.abs(nominal + move).max() == pytest.approx(0.5, abs=1e-6)


# ---- laws ----

START = np.array([9.0, 10.0, 11.0, 12.0])


@pytest.mark.parametrize("law", [pseudoinverse, vectored])
def test_both_laws_begin_hovering_and_aim_without_the_leak(
    law: Any, at: LawInput, demand: Demand, make_start: Callable[..., Start], robot: Robot
) -> None:
    gains = law.Gains()
    state = law.initial_state(gains, make_start(robot=robot, hover_thrusts=START))
    assert not np.any(state.leak)
    np.testing.assert_array_equal(state.rotors.thrusts, START)
    leaking = state._replace(leak=np.array([0.1, 0.2, 0.3]))
    np.testing.assert_array_equal(law.aim(gains, leaking, at, demand.force), demand.force)
    compensated = law.Gains(leak=type(gains.leak)(compensate=True))
    np.testing.assert_allclose(
        law.aim(compensated, leaking, at, demand.force), demand.force - np.array([0.1, 0.2, 0.3])
    )
    moves = getattr(gains.vectoring, "limit", 0.0)
    assert law.needs(gains) == Needs(moves=moves)
    contact = law.Gains(vectoring=law.Vectoring(purpose="contact"))
    assert law.needs(contact) == Needs(vectoring="contact", moves=moves)
    with pytest.raises(ConfigError, match="purpose"):
        law.Vectoring(purpose="contakt")


@pytest.mark.parametrize("hold_lift", [False, True])
def test_the_papers_law_gives_thrusts_for_the_aimed_force(
    at: LawInput, demand: Demand, robot: Robot, hold_lift: bool
) -> None:
    gains = numeric(pseudoinverse.Gains(hold_lift=hold_lift, leak=TorqueLeak(cutoff=3.0)))
    body, before = at.estimate.body, pseudoinverse.State(np.array([0.1, 0.0, -0.2]), at_rest(START))
    wanted = allocate(body, demand.aimed, TORQUE, robot.thrust_limits(), hold_lift)
    state, given, signals = pseudoinverse.step(gains, before, at, demand)
    np.testing.assert_array_equal(given.command.thrusts, wanted.total)
    np.testing.assert_array_equal(given.command.joint_angles, demand.joint_angles)
    np.testing.assert_array_equal(given.command.vectoring_angles, demand.vectoring_angles)
    made = rotor_wrench(body, wanted.total)
    np.testing.assert_array_equal(given.wrench.force, made.force)
    np.testing.assert_array_equal(given.wrench.torque, made.torque)
    np.testing.assert_array_equal(state.rotors.thrusts, wanted.total)
    leak = side_force(gains.leak, at, wanted)
    np.testing.assert_allclose(state.leak, follow_leak(gains.leak, before.leak, leak, DT))
    assert signals == {}


def test_rotors_that_lag_are_led_and_known(at: LawInput, demand: Demand, robot: Robot) -> None:
    gains = numeric(pseudoinverse.Gains(rotor_lag=RotorLag(compensate=True, lead=3.0)))
    body, limits = at.estimate.body, robot.thrust_limits()
    wanted = allocate(body, demand.aimed, TORQUE, limits).total
    led = lead_thrusts(gains.rotor_lag, at_rest(START), wanted, limits, gains.rotor_lag.time_constant, DT)
    assert np.abs(led.command - wanted).max() > 0.1
    state, given, _ = pseudoinverse.step(gains, pseudoinverse.State(np.zeros(3), at_rest(START)), at, demand)
    np.testing.assert_array_equal(given.command.thrusts, led.command)
    np.testing.assert_array_equal(state.rotors.thrusts, led.end)
    np.testing.assert_allclose(given.wrench.force, rotor_wrench(body, led.mean).force)


@pytest.mark.parametrize("lead", [1.0, 2.5])
def test_the_law_with_moves_leaves_the_side_force_to_them(
    at: LawInput, demand: Demand, robot: Robot, lead: float
) -> None:
    gains = numeric(
        vectored.Gains(
            leak=Leak(compensate=True, cutoff=3.0),
            rotor_lag=RotorLag(compensate=True),
            vectoring=vectored.Vectoring(lead=lead, cutoff=2.0),
        )
    )
    body, limits = at.estimate.body, robot.thrust_limits()
    before = vectored.State(np.array([0.1, 0.0, -0.2]), at_rest(START), np.array([0.05, -0.02, 0.03, 0.01]))
    state, given, signals = vectored.step(gains, before, at, demand)
    wanted = allocate(body, demand.force, TORQUE, limits, hold_lift=True).total
    led = lead_thrusts(gains.rotor_lag, at_rest(START), wanted, limits, gains.rotor_lag.time_constant, DT)
    np.testing.assert_array_equal(given.command.thrusts, led.command)
    np.testing.assert_array_equal(state.rotors.thrusts, led.end)
    np.testing.assert_allclose(given.wrench.torque, rotor_wrench(body, led.mean).torque)
    move, side = (flat(x) for x in lateral_move(gains.vectoring, before.move, at, demand))
    np.testing.assert_allclose(flat(state.move), move)
    angles = demand.vectoring_angles + move
    measured = demand.vectoring_angles + AWAY
    np.testing.assert_allclose(
        flat(given.command.vectoring_angles), measured + lead * (angles - measured), atol=1e-12
    )
    np.testing.assert_allclose(flat(state.leak), follow_leak(gains.leak, before.leak, R @ side, DT))
    np.testing.assert_array_equal(given.command.joint_angles, demand.joint_angles)
    assert signals == {}


def test_without_holding_the_lift_the_thrusts_for_a_torque_are_the_least(
    at: LawInput, demand: Demand, robot: Robot
) -> None:
    gains = numeric(vectored.Gains(hold_lift=False))
    before = vectored.State(np.zeros(3), at_rest(START), np.zeros(4))
    _, given, _ = vectored.step(gains, before, at, demand)
    wanted = allocate(at.estimate.body, demand.force, TORQUE, robot.thrust_limits()).total
    np.testing.assert_array_equal(given.command.thrusts, wanted)


def test_no_move_is_made_before_the_first_tick(make_start: Callable[..., Start], robot: Robot) -> None:
    assert vectored.initial_state(vectored.Gains(), make_start(robot=robot)).move.tolist() == [0.0] * 4
