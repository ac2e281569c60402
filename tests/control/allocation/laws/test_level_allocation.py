"""Force and torque in six directions with the body level: alone, in flight and as C."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.base.packing import Layout, numeric
from skylimb.base.rotations import rot_z
from skylimb.control.allocation.laws import level, pseudoinverse
from skylimb.control.allocation.level_moves import LevelMoves, level_move, nominal_rotation
from skylimb.control.estimation.records import Start, Wrench
from skylimb.control.needs import Needs
from skylimb.control.records import Demand, LawInput
from skylimb.flight.drivers.native import compile_native, fly_native
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import take_off
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState

DT = 0.005
YAW = rot_z(0.4)
TORQUE = np.array([0.1, -0.15, 0.2])
PRESETS = Path(pseudoinverse.__file__).parents[2] / "presets"
Make = Callable[..., LawInput]


def flat(value: Any) -> np.ndarray:
    return np.asarray(ca.DM(value)).ravel()


@pytest.fixture
def seen(make_inputs: Make, robot: Robot, joint_angles: Any, vectoring_angles: Any) -> Callable[..., Any]:
    """What the law sees once the angles have moved and the body is still level at a yaw of 0.4 rad."""
    nominal = robot.at(joint_angles, vectoring_angles)

    def build(move: np.ndarray) -> LawInput:
        psi = vectoring_angles + move
        model = robot.at(joint_angles, psi)
        R_WC = YAW @ nominal.R_root_C.T @ model.R_root_C
        at = make_inputs(model, robot=robot, R=R_WC, q=joint_angles, psi=psi)
        return at._replace(reference=at.reference._replace(vectoring_angles=vectoring_angles))

    return build


@pytest.fixture
def demand(model: RobotState, joint_angles: Any, vectoring_angles: Any) -> Demand:
    force = model.mass * model.gravity + np.array([1.5, -1.0, 0.5])
    return Demand(force, force, TORQUE, joint_angles, vectoring_angles)


def settled(seen: Any, demand: Demand, start: Start, gains: Any, ticks: int = 60) -> Any:
    """State, output, signals and inputs once servos that follow at once have done so."""
    state, inputs = level.initial_state(gains, start), seen(np.zeros(4))
    for _ in range(ticks):
        state = level.step(gains, state, inputs, demand)[0]
        state = state._replace(**{name: flat(getattr(state, name)) for name in state._fields[:-1]})
        state = state._replace(residual=Wrench(*map(flat, state.residual)))
        inputs = seen(state.move)
    _, given, signals = level.step(gains, state, inputs, demand)
    return state, given, signals, inputs


QUICK = LevelMoves(cutoff=100.0, rate=100.0, damping=1e-6, margin=0.0, limit=2.0)


def gains_with(moves: LevelMoves) -> Any:
    vectoring = level.Vectoring(**{name: getattr(moves, name) for name in moves.__dataclass_fields__})
    return numeric(level.Gains(vectoring=vectoring))


def test_a_level_body_gives_all_six_directions_as_wanted(
    seen: Any, demand: Demand, robot: Robot, model: RobotState
) -> None:
    start, gains = Start(robot, 1.09, model.hover_thrusts), gains_with(QUICK)
    state, given, signals, inputs = settled(seen, demand, start, gains)
    np.testing.assert_allclose(flat(given.wrench.force), demand.force, atol=2e-3)
    np.testing.assert_allclose(flat(given.wrench.torque), TORQUE, atol=1e-6)
    assert np.abs(flat(signals["allocation_residual_force"])).max() < 1e-9
    # The target attitude of {C} is the one that it has: the body need not move.
    aimed = flat(level.aim(gains, state, inputs, demand.force))
    np.testing.assert_allclose(aimed / np.linalg.norm(aimed), inputs.estimate.body.R_WC[:, 2], atol=1e-6)
    assert aimed[2] == pytest.approx(demand.force[2])
    level_again = nominal_rotation(robot, inputs.estimate.body, demand.joint_angles, demand.vectoring_angles)
    np.testing.assert_allclose(flat(level_again[:, 2]), [0, 0, 1], atol=1e-9)


def test_what_the_angles_cannot_give_is_left_to_the_tilt(
    seen: Any, demand: Demand, robot: Robot, model: RobotState
) -> None:
    start = Start(robot, 1.09, model.hover_thrusts)
    narrow = gains_with(LevelMoves(cutoff=100.0, limit=0.05, margin=0.0))
    narrow = narrow.__class__(**{**narrow.__dict__, "tilt_cutoff": np.float64(20.0)})
    state, given, signals, inputs = settled(seen, demand, start, narrow)
    missing = flat(signals["allocation_residual_force"])[:2]
    assert np.linalg.norm(missing) > 0.5
    # It is said in W, whatever the heading: with it the given force is the wanted one.
    np.testing.assert_allclose(flat(given.wrench.force)[:2] + missing, demand.force[:2], atol=0.05)
    np.testing.assert_allclose(flat(state.short)[:2], missing, atol=1e-3)
    assert np.abs(flat(state.move)).max() <= 0.05 + 1e-12
    without = flat(level.aim(narrow, state._replace(short=np.zeros(3)), inputs, demand.force))
    np.testing.assert_allclose(
        flat(level.aim(narrow, state, inputs, demand.force)) - without, [*flat(state.short)[:2], 0.0]
    )


def test_the_null_space_keeps_margin_and_not_the_force(
    seen: Any, demand: Demand, robot: Robot, model: RobotState
) -> None:
    start, found = Start(robot, 1.09, model.hover_thrusts), {}
    highest = np.array([rotor.thrust_max for rotor in robot.description.rotors])
    for margin in (0.0, 1.0):
        gains = gains_with(LevelMoves(cutoff=100.0, rate=100.0, damping=1e-6, margin=margin, limit=2.0))
        _, given, _, _ = settled(seen, demand, start, gains)
        np.testing.assert_allclose(flat(given.wrench.force), demand.force, atol=2e-3)
        found[margin] = float(np.sum((flat(given.command.thrusts) / highest) ** 2))
    assert found[1.0] < found[0.0] - 5e-5


def test_the_null_space_keeps_thrusts_near_those_of_the_hover(
    seen: Any, demand: Demand, robot: Robot, model: RobotState
) -> None:
    start, away, calm = Start(robot, 1.09, model.hover_thrusts), [], demand._replace(torque=np.zeros(3))
    hover = model.hover_thrusts * calm.force[2] / (model.mass * model.gravity[2])
    for steady in (0.0, 8.0):
        moves = LevelMoves(cutoff=100.0, rate=100.0, damping=1e-6, margin=0.0, steady=steady, limit=2.0)
        _, given, _, _ = settled(seen, calm, start, gains_with(moves), ticks=400)
        np.testing.assert_allclose(flat(given.wrench.force), calm.force, atol=2e-3)
        away.append(float(np.linalg.norm(flat(given.command.thrusts) - hover)))
    assert away[1] < 0.8 * away[0]


def test_the_pull_toward_the_hovers_thrusts_comes_slowly(seen: Any, demand: Demand) -> None:
    law, at = numeric(LevelMoves(margin=0.0, steady=8.0)), seen(np.zeros(4))
    pull = flat(level_move(law, np.full(4, 0.3), np.zeros(4), at, demand).pull)
    whole = pull / -np.expm1(-2.0 * np.pi * 0.3 * DT)
    np.testing.assert_allclose(flat(level_move(law, np.full(4, 0.3), whole, at, demand).pull), whole)
    assert np.linalg.norm(pull) < 0.02 * np.linalg.norm(whole)
    # However steep the thrusts are there, it is no more than twice the limit of the moves.
    steep = numeric(LevelMoves(margin=0.0, steady=100.0, limit=0.01))
    pull = flat(level_move(steep, np.full(4, 0.3), np.zeros(4), at, demand).pull)
    assert np.abs(pull).max() == pytest.approx(-0.02 * np.expm1(-2.0 * np.pi * 0.3 * DT))
    none = level_move(numeric(LevelMoves(margin=0.0)), np.full(4, 0.3), np.zeros(4), at, demand)
    assert not np.any(flat(none.pull))


def test_no_angle_moves_faster_than_its_rate(seen: Any, demand: Demand) -> None:
    slow = numeric(LevelMoves(rate=2.0, cutoff=100.0))
    moved = flat(level_move(slow, np.zeros(4), np.zeros(4), seen(np.zeros(4)), demand).move)
    assert np.abs(moved).max() == pytest.approx(2.0 * DT)


def test_limits_of_the_joints_hold_and_other_joints_make_up(
    seen: Any, demand: Demand, monkeypatch: pytest.MonkeyPatch, robot: Robot
) -> None:
    free = flat(level_move(numeric(QUICK), np.zeros(4), np.zeros(4), seen(np.zeros(4)), demand).move)
    most = int(np.argmax(np.abs(free)))
    lower, upper = np.full(4, -np.inf), np.full(4, np.inf)
    at = demand.vectoring_angles[most] + 0.5 * free[most]
    (upper if free[most] > 0 else lower)[most] = at
    monkeypatch.setattr(robot, "vectoring_limits", lambda: (lower, upper))
    moved = level_move(numeric(QUICK), np.zeros(4), np.zeros(4), seen(np.zeros(4)), demand)
    assert abs(flat(moved.move)[most]) <= abs(0.5 * free[most]) + 1e-9
    np.testing.assert_allclose(flat(moved.short), 0.0, atol=1e-3)


def test_needs_and_refusals(make_start: Callable[..., Start]) -> None:
    gains = level.Gains(vectoring=level.Vectoring(purpose="contact", limit=0.7))
    assert level.needs(gains) == Needs(vectoring="contact", moves=0.7)
    with pytest.raises(ConfigError, match=r"'tilted_hexarotor' turn about 0.*'bounded'"):
        level.initial_state(gains, make_start(robot=skylimb.load_robot("tilted_hexarotor")))


def test_numbers_and_symbols_give_the_same(
    seen: Any, demand: Demand, robot: Robot, model: RobotState
) -> None:
    gains, state = (
        numeric(level.Gains()),
        level.initial_state(level.Gains(), Start(robot, 1.09, model.hover_thrusts)),
    )
    layout = Layout(state)
    x = ca.SX.sym("x", layout.size)
    traced = level.step(gains, layout.unpack(x), seen(np.zeros(4)), demand)
    function = ca.Function("law", [x], [ca.densify(Layout(traced).pack(traced))])
    found = level.step(gains, state, seen(np.zeros(4)), demand)
    expected = np.concatenate([flat(part) for part in _leaves(found)])
    np.testing.assert_allclose(function(layout.pack(state)).full().ravel(), expected, atol=1e-9)


def _leaves(value: Any) -> list[Any]:
    if isinstance(value, dict):
        return [leaf for key in value for leaf in _leaves(value[key])]
    return [leaf for part in value for leaf in _leaves(part)] if isinstance(value, tuple) else [value]


# ---- in flight, and as C ----


@pytest.fixture(scope="module")
def preset(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The paper's impedance without its feedback of the force in y, and with this allocation."""
    text = (PRESETS / "impedance.toml").read_text(encoding="utf-8")
    text = text.replace("[1.0, 3.0, 1.0]", "[1.0, 1.0, 1.0]").replace('"pseudoinverse"', '"level"')
    path = tmp_path_factory.mktemp("preset") / "level.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


PUSH = {
    "events.0.time": 2.0,
    "events.0.duration": 4.0,
    "phases.hover": 0.5,
    "phases.tare": 1.0,
    "phases.hover_end": 0.0,
    "trajectory.duration": 5.0,
}


def body_tilt(run: Any) -> float:
    """Greatest angle between the body's z axis and where it was before the push, degrees."""
    z = Rotation.from_quat(run.log.configuration.values[:, [4, 5, 6, 3]]).as_matrix()[:, :, 2]
    before = z[(run.log.time.values > 1.0) & (run.log.time.values < 2.0)].mean(axis=0)
    tilts = np.degrees(np.arccos(np.clip(z @ before / np.linalg.norm(before), -1.0, 1.0)))
    return float(tilts[run.log.time.values > 1.0].max())


@pytest.mark.parametrize(("robot_name", "force"), [("hydrus_xi_quad", 1.0), ("tiltable_hexarotor", 5.0)])
def test_a_sideways_push_leaves_the_body_level(preset: str, robot_name: str, force: float) -> None:
    push = {**PUSH, "robot": robot_name, "events.0.force": [0.0, force, 0.0]}
    run = skylimb.run("push", controller=preset, set=push)
    assert run.status == "OK"
    # The preset does not know the reaction of its rotors: the hexarotor leans by .58, not .31 degrees.
    assert body_tilt(run) < 0.6
    # The rotors push back by as much: {C} has turned in the body.
    assert np.degrees(run.log.tilt.values.max()) > 1.0


def test_the_native_driver_flies_the_same_to_the_bit(preset: str) -> None:
    short = {**PUSH, "events.0.force": [0.0, 5.0, 0.0], "trajectory.duration": 1.5}
    (takeoff,) = take_off("push", (preset,), 0, short)
    compile_native(takeoff.tick.function)
    (native,) = fly_native([takeoff])
    here = fly_here(takeoff)
    for name in ("thrusts_command", "vectoring_move", "allocation_residual_force"):
        np.testing.assert_array_equal(native.signal(name), here.signal(name))


def test_as_c_it_passes_its_test_vector(preset: str, run_as_c: Callable[..., None]) -> None:
    run_as_c(skylimb.load_controller(preset, skylimb.load_robot("hydrus_xi_quad")))
