"""Six directions at the tip: the laws alone, against the paper's, in flight, linearised and as C."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.base.packing import numeric
from skylimb.base.rotations import rot_z, rotation_from_rpy, rotation_from_vector
from skylimb.control.attitude.laws import impedance as paper_attitude
from skylimb.control.attitude.laws import task_frame as attitude
from skylimb.control.cascade import Cascade
from skylimb.control.contact.laws import task_frame as contact
from skylimb.control.estimation.records import Wrench
from skylimb.control.needs import Needs
from skylimb.control.records import LawInput, TipMove
from skylimb.control.task_frame import symmetric, task_axes, tip_wrench
from skylimb.control.translation.laws import impedance as paper_translation
from skylimb.control.translation.laws import task_frame as translation
from skylimb.flight.drivers.native import compile_native, fly_native
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import take_off
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState
from skylimb.studies.verification.stability import linearise, operating_point

DT = 0.005
TURNED = rotation_from_rpy(0.3, -0.4, 1.1)
Make = Callable[..., LawInput]


# ---- the frame ----


def test_the_axes_of_the_task_are_contact_sliding_and_their_product(make_inputs: Make) -> None:
    inputs = make_inputs(reference={"contact_axis": TURNED[:, 0], "sliding_axis": TURNED[:, 1]})
    np.testing.assert_allclose(task_axes(inputs.reference), TURNED, atol=1e-15)


def test_the_wrench_at_the_tip_is_without_the_lever_of_its_force(make_inputs: Make) -> None:
    R_WC, arm = rotation_from_rpy(0.1, 0.2, -0.5), np.array([0.9, 0.2, -0.1])
    force, twist = np.array([-3.0, 1.0, 0.5]), np.array([0.1, -0.2, 0.3])
    inputs = make_inputs(
        R=R_WC,
        arm=arm,
        force=TURNED @ force,
        torque=R_WC.T @ (np.cross(arm, TURNED @ force) + TURNED @ twist),
    )
    felt = tip_wrench(inputs.estimate, TURNED)
    np.testing.assert_allclose(felt.force, force, atol=1e-12)
    np.testing.assert_allclose(felt.torque, twist, atol=1e-12)


def test_its_lever_is_the_one_in_which_the_observer_works(make_inputs: Make) -> None:
    # The arm may be corrected for a measured attitude that is off; force and torque are not.
    force, lever = np.array([-3.0, 0.0, 0.0]), np.array([1.1, 0.0, 0.0])
    inputs = make_inputs(force=force, torque=np.cross(lever, force), arm=lever)
    corrected = rotation_from_rpy(0.0, 0.02, 0.0) @ lever
    estimate = inputs.estimate._replace(arm=corrected)
    np.testing.assert_allclose(tip_wrench(estimate, np.eye(3)).torque, 0.0, atol=1e-12)


def test_a_symmetric_matrix_from_its_diagonal_and_what_stands_beside() -> None:
    np.testing.assert_array_equal(symmetric((1, 2, 3), (4, 5, 6)), [[1, 4, 5], [4, 2, 6], [5, 6, 3]])


def test_a_rotation_from_its_vector() -> None:
    for vector in (np.array([0.3, -0.2, 0.5]), np.array([0.0, 0.0, 1e-7]), np.zeros(3)):
        expected = Rotation.from_rotvec(vector).as_matrix()
        np.testing.assert_allclose(rotation_from_vector(vector), expected, atol=1e-9)
    symbol = ca.SX.sym("v", 3)
    slope = ca.Function("slope", [symbol], [ca.jacobian(ca.vec(rotation_from_vector(symbol)), symbol)])
    assert np.isfinite(slope(np.zeros(3)).full()).all()


# ---- the admittance ----


def gains(**given: Any) -> Any:
    return numeric(contact.Gains(**given))


def pushed(
    inputs: LawInput, law: Any, force: Any, torque: Any = (0, 0, 0), ticks: int = 4000, state: Any = None
) -> contact.State:
    """The state after some time under a wrench at the tip, task axes along W; at first at the reference."""
    wrench = Wrench(np.asarray(force, dtype=float), np.cross(inputs.estimate.arm, force) + np.asarray(torque))
    inputs = inputs._replace(estimate=inputs.estimate._replace(wrench=wrench))
    state = state or contact.initial_state(law, NOBODY)
    for _ in range(ticks):
        state = contact.step(law, state, inputs)[0]
    return state


NOBODY: Any = None
TOUCHING = {"touch": 1.0, "wait": 1.0}
FREE = {"damping": (30.0, 40.0, 40.0), "travel": 2.0, "speed": 10.0, "turn": 1.0, "turn_speed": 10.0}


def test_the_tip_gives_way_by_its_stiffness_and_turns_by_that_of_its_rotation(make_inputs: Make) -> None:
    law = gains(**FREE, stiffness=(10.0, 20.0, 40.0), turn_stiffness=(10.0, 20.0, 5.0),
                turn_damping=(5.0, 5.0, 5.0), force=(0.0, 0.0, 0.0))  # fmt: skip
    state = pushed(make_inputs(reference=TOUCHING), law, [-1.0, 2.0, -2.0], [1.0, -1.0, 1.0])
    np.testing.assert_allclose(state.way, [-0.1, 0.1, -0.05], atol=1e-4)
    np.testing.assert_allclose(state.turn, [0.1, -0.05, 0.2], atol=1e-4)


def test_where_a_force_or_torque_is_kept_the_target_rests_only_at_that_push(make_inputs: Make) -> None:
    law = gains(**FREE, stiffness=(0.0, 0.0, 40.0), turn_stiffness=(500.0, 0.0, 500.0), load_time=0.1,
                force=(3.0, -1.0, 0.0), torque=(0.0, 0.2, 0.0))  # fmt: skip
    inputs = make_inputs(reference=TOUCHING)
    at_rest = pushed(inputs, law, [-3.0, 1.0, 0.0], [0.0, -0.2, 0.0])
    assert np.abs(np.concatenate([at_rest.rate, at_rest.turn_rate])).max() < 1e-6
    weak = pushed(inputs, law, [-2.0, 1.0, 0.0], [0.0, -0.1, 0.0], ticks=400)
    assert weak.rate[0] == pytest.approx(1.0 / 30.0, rel=1e-3)
    assert abs(weak.rate[1]) < 1e-6
    assert weak.turn_rate[1] == pytest.approx(0.1 / 50.0, rel=1e-3)


def test_out_of_touch_the_target_goes_home_and_turns_back_slowly(make_inputs: Make) -> None:
    law, inputs = gains(), make_inputs(reference={"touch": 0.0, "wait": 0.0})
    soft = gains(turn_stiffness=(0.0, 0.0, 0.0))
    state = contact.initial_state(law, NOBODY)._replace(way=np.full(3, 0.1), turn=np.full(3, 0.3))
    after = [state := contact.step(soft, state, inputs)[0] for _ in range(2400)]
    assert np.abs(after[1199].way).max() < 1e-4
    # At 0.5 1/s, where a spring of its own is not faster.
    np.testing.assert_allclose(after[1199].turn / after[799].turn, np.exp(-1.0), rtol=0.05)
    assert (contact.step(law, after[9], inputs)[0].turn_rate < after[10].turn_rate).all()
    assert contact.step(soft, state, inputs)[1].engaged == 0.0


def test_on_the_way_back_a_spring_still_gives_way_to_what_is_there(make_inputs: Make) -> None:
    law = gains(
        **FREE, stiffness=(0.0, 20.0, 20.0), turn_stiffness=(0.0, 10.0, 10.0), turn_damping=(5.0,) * 3
    )
    touching, after = (make_inputs(reference={"touch": touch, "wait": touch}) for touch in (1.0, 0.0))
    met = pushed(touching, law, [-1.0, 0.0, 0.0], ticks=1)
    # Before the first touch nothing is felt, as nothing is tared.
    state = pushed(after, law, [-1.0, 2.0, 0.0], [1.0, -1.0, 0.0])
    assert not np.any(state.way)
    assert not np.any(state.turn)
    state = pushed(after, law, [-1.0, 2.0, 0.0], [1.0, -1.0, 0.0], state=met)
    np.testing.assert_allclose(state.way, [0.0, 0.1, 0.0], atol=1e-4)
    np.testing.assert_allclose(state.turn, [0.0, -0.1, 0.0], atol=1e-4)


def test_nothing_is_pushed_for_in_the_approach(make_inputs: Make) -> None:
    state = pushed(
        make_inputs(reference={"touch": 1.0, "wait": 0.0}), gains(force=(3.0, 0.0, 0.0)), [0, 0, 0]
    )
    assert not np.any(state.way)


def test_limits_of_way_and_rate_hold(make_inputs: Make) -> None:
    law = gains(travel=0.02, speed=0.01, turn=0.1, turn_speed=0.05, turn_stiffness=(0.0, 0.0, 0.0))
    state = pushed(make_inputs(reference=TOUCHING), law, [50.0, 0, 0], [0, 0, 20.0], ticks=100)
    assert state.rate[0] == pytest.approx(0.01)
    assert state.turn_rate[2] == pytest.approx(0.05)
    state = pushed(make_inputs(reference=TOUCHING), law, [50.0, 0, 0], [0, 0, 20.0])
    assert state.way[0] == pytest.approx(0.02)
    assert state.turn[2] == pytest.approx(0.1)


def test_the_target_waits_for_rotors_at_their_limits(make_inputs: Make) -> None:
    inputs = make_inputs(reference=TOUCHING)
    short = inputs._replace(residual=Wrench(np.array([1.0, 0.0, 0.0]), np.zeros(3)))
    assert pushed(inputs, gains(), [0, 0, 0], ticks=200).way[0] > 0.01
    assert pushed(short, gains(), [0, 0, 0], ticks=200).way[0] == 0.0


def test_what_the_rotors_fall_short_of_is_of_the_world_and_of_the_body(make_inputs: Make) -> None:
    """Along the task's own axes the same target waits, in whatever direction they point."""
    reference = {**TOUCHING, "contact_axis": TURNED[:, 0], "sliding_axis": TURNED[:, 1]}
    inputs, R = make_inputs(R=rot_z(0.8), reference=reference), rot_z(0.8)
    law = gains(force=(1.0, 1.0, 1.0), torque=(0.2, 0.2, 0.2))
    free = {name: getattr(pushed(inputs, law, [0, 0, 0], ticks=20), name) for name in ("way", "turn")}
    assert np.abs([*free.values()]).min() > 1e-6
    for axis in range(3):
        others = [each for each in range(3) if each != axis]
        along = TURNED @ np.where(np.arange(3) == axis, 1.0, -0.1)  # too much of the others is no shortage
        short = inputs._replace(residual=Wrench(along, R.T @ along))
        found = pushed(short, law, [0, 0, 0], ticks=20)
        for name, went in free.items():
            assert getattr(found, name)[axis] == 0.0
            assert (getattr(found, name)[others] == went[others]).all()


def test_the_targets_rate_knows_that_the_axes_turn(make_inputs: Make) -> None:
    law, state = gains(), contact.initial_state(gains(), NOBODY)._replace(way=np.array([0.2, 0.0, 0.0]))
    axes = rot_z(0.01)
    reference = {**TOUCHING, "contact_axis": axes[:, 0], "sliding_axis": axes[:, 1]}
    state = state._replace(place=np.array([0.2, 0.0, 0.0]), axes=np.eye(3))
    _, view, _ = contact.step(law, state, make_inputs(reference=reference))
    assert view.tip.velocity[1] == pytest.approx(0.2 * np.sin(0.01) / DT, rel=0.05)
    np.testing.assert_allclose(view.tip.rotation_rate, [0.0, 0.0, 0.01 / DT], atol=1e-4)
    first = contact.step(law, contact.initial_state(gains(), NOBODY), make_inputs(reference=reference))[1]
    assert not np.any(first.tip.rotation_rate)


# ---- the impedances ----


def test_with_diagonal_matrices_along_the_world_it_is_the_papers_impedance(make_inputs: Make) -> None:
    arm, e = np.array([0.9, 0.2, -0.1]), np.array([0.03, -0.02, 0.05])
    tip = np.array([1.0, 0.5, 1.2])
    given = {
        "position": tip - arm + e,
        "velocity": np.array([0.1, -0.2, 0.3]),
        "force": np.array([-2.0, 0.5, 0.3]),
        "arm": arm,
        "reference": {
            "tip_position": tip, "position": tip - arm, "tip_velocity": np.array([0.0, 0.1, 0.0]),
            "velocity": np.array([0.0, 0.1, 0.0]), "tip_acceleration": np.array([0.0, 0.0, 0.2]),
            "acceleration": np.array([0.0, 0.0, 0.2]),
        },
    }  # fmt: skip
    K, zeta, ratio = np.array([2.5, 2.5, 1.5]), np.array([0.6, 0.6, 0.7]), (1.0, 3.0, 2.0)
    printed = numeric(paper_translation.Gains(ratio, tuple(K), tuple(zeta)))
    mine = numeric(
        translation.Gains(stiffness=tuple(K), damping=tuple(2.0 * zeta * K**0.5), mass_ratio=ratio)
    )
    inputs = make_inputs(**given)
    _, expected, _ = paper_translation.step(printed, (), inputs)
    np.testing.assert_allclose(translation.step(mine, (), inputs)[1], expected, atol=1e-12)


def test_with_diagonal_matrices_along_the_body_it_is_the_papers_rotational_impedance(
    make_inputs: Make, model: RobotState
) -> None:
    R_WC, R_target = rotation_from_rpy(0.1, -0.2, 0.5), rotation_from_rpy(0.05, 0.0, 0.4)
    inputs = make_inputs(
        model, R=R_WC, omega=np.array([0.1, 0.2, -0.3]), torque=np.array([0.4, -0.3, 0.2]),
        reference={"contact_axis": R_WC[:, 0], "sliding_axis": R_WC[:, 1]},
    )  # fmt: skip
    K, zeta, ratio = np.array([40.0, 30.0, 10.0]), np.array([1.1, 1.0, 0.8]), (10.0, 8.0, 5.0)
    printed = numeric(paper_attitude.Gains(ratio, tuple(K), tuple(zeta)))
    mine = numeric(
        attitude.Gains(stiffness=tuple(K), damping=tuple(2.0 * zeta * K**0.5), inertia_ratio=ratio)
    )
    _, expected, _ = paper_attitude.step(printed, (), inputs, R_target)
    # The paper scales after its inertia, the matrices of the task before: equal where its axes are principal.
    inertia = np.diag(np.diag(model.inertia_C))
    inputs = inputs._replace(
        estimate=inputs.estimate._replace(
            body=inputs.estimate.body._replace(model=model._replace(inertia_C=inertia))
        )
    )
    _, expected, _ = paper_attitude.step(printed, (), inputs, R_target)
    np.testing.assert_allclose(attitude.step(mine, (), inputs, R_target)[1], expected, atol=1e-12)


def test_the_same_task_in_another_direction_is_the_same_force_turned(make_inputs: Make) -> None:
    law = numeric(translation.Gains(stiffness_coupling=(1.0, -0.5, 2.0), mass_ratio=(1.0, 3.0, 2.0)))
    level = numeric(translation.Gains())
    e, v, f = np.array([0.03, -0.02, 0.05]), np.array([0.1, 0.2, -0.1]), np.array([-2.0, 1.0, 0.5])

    def force(Q: np.ndarray, gains: Any) -> np.ndarray:
        inputs = make_inputs(
            position=Q @ e, velocity=Q @ v, force=Q @ f, arm=np.zeros(3),
            reference={"contact_axis": Q[:, 0], "sliding_axis": Q[:, 1]},
        )  # fmt: skip
        return translation.step(gains, (), inputs)[1] - 4.0 * np.array([0.0, 0.0, 9.80665])

    np.testing.assert_allclose(force(TURNED, law), TURNED @ force(np.eye(3), law), atol=1e-12)
    assert np.abs(force(np.eye(3), law) - force(np.eye(3), level)).max() > 0.1


def test_targets_of_the_tip_move_the_body(make_inputs: Make, model: RobotState) -> None:
    arm, turn = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.2])
    inputs = make_inputs(model, arm=arm, reference={"tip_position": arm})
    moved = inputs._replace(
        contact=inputs.contact._replace(
            tip=TipMove(np.array([0.1, 0, 0]), np.zeros(3), turn, np.array([0.0, 0.0, 0.1]))
        )
    )
    law = numeric(translation.Gains(stiffness=(5.0, 5.0, 5.0), damping=(4.0, 4.0, 4.0)))
    change = translation.step(law, (), moved)[1] - translation.step(law, (), inputs)[1]
    # To turn about its tip to the left, the centre of gravity behind it goes to the right.
    np.testing.assert_allclose(change, model.mass * np.array([0.5 + 0.01, -0.4, 0.0]), atol=1e-12)
    turning = numeric(attitude.Gains())
    torque = (
        attitude.step(turning, (), moved, np.eye(3))[1] - attitude.step(turning, (), inputs, np.eye(3))[1]
    )
    assert torque[2] == pytest.approx(model.inertia_C[2, 2] * (20.0 * np.sin(0.2) + 8.0 * 0.1), rel=1e-6)


def test_the_tip_turns_as_its_target_does_in_whatever_attitude(make_inputs: Make, model: RobotState) -> None:
    """eq:impedance control 1 in the axes of the task, for a target that turns in W."""
    R, rotation, rate = (
        rotation_from_rpy(0.3, -0.2, 0.7),
        np.array([0.1, 0.2, -0.1]),
        np.array([0.2, 0.1, 0.3]),
    )
    omega, felt = np.array([0.1, -0.3, 0.2]), np.array([0.4, -0.3, 0.2])
    inputs = make_inputs(
        model, R=R, omega=omega, torque=felt,
        reference={"contact_axis": TURNED[:, 0], "sliding_axis": TURNED[:, 1]},
    )  # fmt: skip
    tip = TipMove(np.zeros(3), np.zeros(3), rotation, rate)
    law = attitude.Gains(stiffness_coupling=(3.0, -2.0, 5.0), damping_coupling=(1.0, -2.0, 0.5))
    target = rotation_from_rpy(0.2, 0.1, 0.5)
    _, torque, _ = attitude.step(
        numeric(law), (), inputs._replace(contact=inputs.contact._replace(tip=tip)), target
    )
    inertia, R_TC = model.inertia_C, TURNED.T @ R
    goal = rotation_from_vector(rotation) @ target
    off = 0.5 * (goal.T @ R - R.T @ goal)
    e_R = R_TC @ np.array([off[2, 1], off[0, 2], off[1, 0]])
    e_omega = TURNED.T @ (R @ omega - rate)
    K = symmetric(law.stiffness, law.stiffness_coupling)
    D = symmetric(law.damping, law.damping_coupling)
    L = symmetric(law.inertia_ratio, law.inertia_ratio_coupling)
    pull = R_TC.T @ (np.linalg.solve(L, R_TC @ felt) - R_TC @ felt)
    expected = pull - inertia @ R_TC.T @ (K @ e_R + D @ e_omega) + np.cross(omega, inertia @ omega)
    np.testing.assert_allclose(torque, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("law", "given", "name"),
    [
        (translation.Gains, {"stiffness_coupling": (20.0, 0.0, 0.0)}, "stiffness"),
        (translation.Gains, {"damping": (0.0, 1.0, 1.0)}, "damping"),
        (attitude.Gains, {"inertia_ratio_coupling": (0.0, 60.0, 0.0)}, "inertia_ratio"),
    ],
)
def test_a_matrix_that_would_give_energy_is_refused(law: Any, given: Any, name: str) -> None:
    with pytest.raises(ConfigError, match=f"{name}.*not positive definite"):
        law(**given)


def test_it_tells_the_force_that_it_commands() -> None:
    assert contact.needs(contact.Gains(force=(2.5, 9.0, 0.0))) == Needs(force=2.5)


# ---- in flight, linearised and as C ----

BOARD = {
    "surface.slope": 0.0,
    "surface.friction": 0.2,
    "trajectory.feedforward": "velocity",
    "phases.hover": 0.5,
    "phases.tare": 1.5,
    "phases.settle": 3.0,
    "phases.hover_end": 0.0,
}


def test_a_force_is_kept_while_the_tip_draws_with_the_body_level() -> None:
    log = skylimb.run("paper", "task_frame", set=BOARD).log
    slide = log.where(log.phase == 4, drop=True)
    assert slide.contact_force_normal.values.mean() == pytest.approx(1.0, abs=0.05)
    assert slide.contact_force_normal.values.std() < 0.15
    z = Rotation.from_quat(slide.configuration.values[:, [4, 5, 6, 3]]).as_matrix()[:, :, 2]
    assert np.degrees(np.arccos(np.clip(z @ z.mean(axis=0), -1.0, 1.0))).max() < 0.5
    assert slide.tip_force_estimate.attrs["units"] == "N"
    off = slide.tip_position - slide.tip_position_reference
    assert np.quantile(np.abs(off.sel(axis=["y", "z"]).values), 0.9) < 0.02


QUICK = {"phases.hover": 0.5, "phases.tare": 1.5, "phases.settle": 3.0, "phases.hover_end": 0.0}


def test_it_drags_once_around_a_pipe_with_the_body_level() -> None:
    log = skylimb.run("pipe_around", "task_frame", set=QUICK).log
    slide = log.where(log.phase == 4, drop=True)
    assert slide.contact_force_normal.values.mean() == pytest.approx(1.0, abs=0.1)
    off = np.linalg.norm((slide.tip_position - slide.tip_position_reference).values, axis=1)
    assert np.quantile(off, 0.95) < 0.03
    z = Rotation.from_quat(slide.configuration.values[:, [4, 5, 6, 3]]).as_matrix()[:, 2, 2]
    assert np.degrees(np.arccos(np.clip(z / z.max(), -1.0, 1.0))).max() < 1.0
    turned = np.unwrap(slide.attitude_estimate.values[:, 2])
    assert abs(turned[-1] - turned[0]) == pytest.approx(2.0 * np.pi, abs=0.2)


def test_it_pushes_with_a_wanted_force_in_three_directions() -> None:
    wanted = {
        "controller.contact.force": [2.0, 0.5, -0.4],
        "controller.contact.stiffness": [0.0, 0.0, 0.0],
        "controller.contact.damping": [30.0, 60.0, 60.0],
    }
    log = skylimb.run("tilted_push", "task_frame", set={**QUICK, **wanted}).log
    end = log.where((log.phase == 4) & (log.time > float(log.time[-1]) - 8.0), drop=True)
    c, s = np.cos(np.radians(20.0)), np.sin(np.radians(20.0))
    axes = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    np.testing.assert_allclose(axes @ end.contact_force.values.mean(axis=0), [-2.0, -0.5, 0.4], atol=0.1)


def test_it_is_stable_in_contact(robot: Robot) -> None:
    controller = skylimb.load_controller("task_frame", robot)
    assert isinstance(controller, Cascade)
    hold = {**BOARD, "surface.friction": 0.0, "trajectory.shape": "hold", "sensors.latency": 0.02}
    point = operating_point(skylimb.load_experiment("paper", hold), controller)
    loop = linearise(point)
    assert loop.stable
    assert loop.growth < -0.3
    assert not linearise(point.with_gains({"translation.stiffness": [5.0, 40.0, 6.0]})).stable


def test_the_native_driver_flies_the_same_to_the_bit() -> None:
    short = {**BOARD, "approach.standoff": 0.02, "trajectory.shape": "hold", "trajectory.duration": 0.5}
    (takeoff,) = take_off("paper", ("task_frame",), 0, short)
    compile_native(takeoff.tick.function)
    (native,) = fly_native([takeoff])
    here = fly_here(takeoff)
    for name in ("thrusts_command", "tip_move", "tip_torque_estimate"):
        np.testing.assert_array_equal(native.signal(name), here.signal(name))
    assert np.abs(here.signal("tip_move")).max() > 1e-3


def test_as_c_it_passes_its_test_vector(robot: Robot, run_as_c: Callable[..., None]) -> None:
    run_as_c(skylimb.load_controller("task_frame", robot))
