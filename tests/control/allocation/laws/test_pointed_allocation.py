"""A wrench in all six directions around planned vectoring angles: DRAGON turns without being pushed aside."""

import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.base.packing import numeric
from skylimb.control.allocation.laws import planned, pointed
from skylimb.control.allocation.pointing import Pointed, Pointing
from skylimb.control.allocation.pointing import pointed as point
from skylimb.control.controller import load_controller
from skylimb.control.estimation.records import Start
from skylimb.control.laws.preset import PRESETS
from skylimb.control.planning.vectoring_step import RATE, STEP, first_vectoring
from skylimb.flight.drivers import machine_code
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.takeoff import prepare
from skylimb.robots.description import GRAVITY


@pytest.fixture(scope="module")
def dragon():
    return skylimb.load_robot("dragon")


def hovering(robot):
    q, plan = robot.nominal_posture(), first_vectoring(robot).angles
    return q, plan, Pointed(robot.at(q, plan).hover_thrusts, np.zeros(robot.n_vectoring))


def given(robot, q, plan, found):
    """The wrench of thrusts and angles, root axes."""
    return robot.wrench_function(q, plan + found.move).full() @ found.thrusts


def steps(robot, wrench, count=400, **gains):
    q, plan, found = hovering(robot)
    missing = np.zeros(0)
    for _ in range(count):
        found, missing = point(numeric(Pointing(**gains)), robot, found, q, plan, wrench, 0.005)
    return given(robot, q, plan, found), found, np.asarray(missing)


def test_a_hover_needs_no_move(dragon):
    q, plan, still = hovering(dragon)
    wrench = given(dragon, q, plan, still)
    assert wrench[2] == pytest.approx(dragon.mass * GRAVITY, rel=1e-3)
    _, found, missing = steps(dragon, wrench, 5)
    assert np.allclose(found.move, 0.0, atol=1e-3)
    assert np.allclose(found.thrusts, still.thrusts, atol=0.05)
    assert np.allclose(missing, 0.0, atol=1e-9)


@pytest.mark.parametrize("axis", range(6))
def test_a_wrench_is_given_in_every_direction_without_the_others(dragon, axis):
    q, plan, still = hovering(dragon)
    hover = given(dragon, q, plan, still)
    wanted = hover + np.eye(6)[axis] * (3.0 if axis < 3 else 1.0)
    made, _, _ = steps(dragon, wanted)
    assert np.allclose(made, wanted, atol=0.15)


@pytest.mark.parametrize("axis", range(6))
def test_one_step_gives_a_small_wrench_up_to_its_square(dragon, axis):
    """B is the derivative of the wrench by thrusts and by angles alike."""
    q, plan, still = hovering(dragon)
    hover, small = given(dragon, q, plan, still), 0.05 * np.eye(6)[axis]
    made, found, _ = steps(dragon, hover + small, 1, damping=1e-9, rate=100.0)
    assert np.abs(found.move).max() > 1e-4
    # Of the hover itself, which is not all of its plan's wrench, the step gives the rest too.
    same, _, _ = steps(dragon, hover, 1, damping=1e-9, rate=100.0)
    np.testing.assert_allclose(made - same, small, atol=2e-3)


def test_thrusts_alone_would_push_it_aside(dragon):
    """The reason for the law: newtons of side force for a newton metre."""
    q, plan, _ = hovering(dragon)
    Q = dragon.at(q, plan).allocation_C
    leak = np.linalg.norm((Q[:2] @ np.linalg.pinv(Q[2:]))[:, 1:], 2)
    assert leak > 1.0


def test_thrusts_and_moves_keep_their_limits_and_what_is_missing_is_told(dragon):
    q, plan, still = hovering(dragon)
    hover = given(dragon, q, plan, still)
    _, found, missing = steps(dragon, hover + np.array([60.0, 0.0, 30.0, 15.0, 0.0, 0.0]), limit=0.3)
    rotors = dragon.description.rotors
    assert np.all(found.thrusts <= [rotor.thrust_max + 1e-9 for rotor in rotors])
    assert np.all(found.thrusts >= [rotor.thrust_min - 1e-9 for rotor in rotors])
    assert np.abs(found.move).max() <= 0.3 + 1e-9
    assert np.abs(missing).max() > 1.0


def test_a_move_is_no_faster_than_its_rate(dragon):
    q, plan, still = hovering(dragon)
    hover = given(dragon, q, plan, still)
    _, found, _ = steps(dragon, hover + np.eye(6)[0] * 20.0, 1, rate=1.0)
    assert 0.004 < np.abs(found.move).max() <= 0.005 + 1e-12


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    preset = tmp_path_factory.mktemp("preset") / "pid_pointed.toml"
    text = (PRESETS / "pid.toml").read_text()
    preset.write_text(
        text.replace('law = "pseudoinverse"', 'law = "pointed"')
        .replace("[40.0, 40.0, 10.0]", "[4.0, 4.0, 3.0]")
        .replace("virtual_inertia_ratio = [10.0, 10.0, 5.0]", "virtual_inertia_ratio = [1.0, 1.0, 1.0]")
    )
    # A posture out of the plane, where the plain law of planned angles loses the robot.
    posture = {"posture.waypoints": [[0.3, 0.8, -0.4, 0.9, 0.3, 0.6]], "posture.hold": 1.0}
    return skylimb.run("free_flight", controller=str(preset), set={"robot": "dragon", **posture})


def test_dragon_bends_out_of_its_plane_and_stays_on_its_place(flight):
    assert flight.status == "OK"
    log = flight.log
    away = np.linalg.norm(log["cog_position"].values - log["cog_position_reference"].values, axis=1)
    assert away.max() < 0.05
    assert np.degrees(log["tilt"].values.max()) < 6.0


@pytest.mark.parametrize("law", ["bounded", "pointed"])
def test_its_tick_fits_the_native_driver(dragon, law, tmp_path):
    """Searches within limits are nested functions, whose work space adds up."""
    path = tmp_path / f"{law}.toml"
    text = (PRESETS / "pid.toml").read_text()
    path.write_text(text.replace('law = "pseudoinverse"', f'law = "{law}"'))
    robot = dragon if law == "pointed" else skylimb.load_robot("hydrus_quad")
    experiment = load_experiment("free_flight", {"robot": robot.name, "posture.waypoints": []})
    tick = prepare(experiment, robot, load_controller(str(path), robot)).tick.function
    assert tick.sz_arg() <= machine_code.MOST_ARGUMENTS
    assert tick.sz_res() <= machine_code.MOST_RESULTS
    assert tick.sz_iw() == 0


def test_the_plan_never_jumps(flight):
    plan = flight.log["vectoring_angles_command"].values - flight.log["vectoring_move"].values
    assert np.abs(np.diff(plan, axis=0)).max() * 200.0 <= STEP * RATE + 1e-6


def test_a_robot_whose_rotors_do_not_turn_is_refused():
    robot = skylimb.load_robot("tilted_hexarotor")
    start = Start(robot, 0.4, np.ones(6))
    with pytest.raises(ConfigError, match="about 0 vectoring joints"):
        pointed.initial_state(pointed.Gains(), start)


def test_a_control_rate_below_that_of_the_plans_is_refused():
    pointed.require(pointed.Gains(), 1.0 / RATE)
    with pytest.raises(ConfigError, match=r"law 'pointed' plans .* 10 Hz is too low"):
        pointed.require(pointed.Gains(), 0.1)
    assert pointed.needs(pointed.Gains()) == planned.needs(planned.Gains())
