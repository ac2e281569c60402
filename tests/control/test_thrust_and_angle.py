"""The seam between laws that fly pairs of fixed rotors and a robot whose joints turn its rotors."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from made_robots import chain
from skylimb.base.packing import Layout
from skylimb.control.allocation.rotor_lag import time_constants
from skylimb.control.allocation.rotor_reaction import reaction, reaction_torque
from skylimb.control.estimation.records import BodyState, zero_measurement
from skylimb.control.missions.reference import zero_reference
from skylimb.control.records import Command
from skylimb.control.thrust_and_angle import as_pairs, from_pairs, with_angles, without_angles
from skylimb.robots.loader import load_robot, read_description
from skylimb.robots.model import Robot
from skylimb.robots.reaction import reaction_zeros

SPINNING = "inertia = 1e-4\nthrust_factor = 1e-5\n"
THRUSTS, PSI = np.array([9.0, 11.0, 10.0]), np.array([0.1, -0.2, 0.05])


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path = chain(tmp_path_factory.mktemp("three"), links=3, turns=("1 0 0",))
    path.write_text(path.read_text().replace("lag = 0.03\n", f"lag = 0.03\n{SPINNING}"))
    return Robot(read_description(path))


def test_a_command_comes_back_from_its_pairs(robot: Robot) -> None:
    given = Command(THRUSTS, np.zeros(2), PSI)
    pairs = as_pairs(robot, given)
    assert pairs.thrusts.shape == (6,)
    assert pairs.vectoring_angles.shape == (0,)
    for one, other in zip(from_pairs(robot, pairs), given, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_symbols_give_what_numbers_give(robot: Robot) -> None:
    given = Command(THRUSTS, np.zeros(2), PSI)
    layout = Layout(given)
    symbols = ca.SX.sym("given", layout.size)
    made = from_pairs(robot, as_pairs(robot, layout.unpack(symbols)))
    function = ca.Function("seam", [symbols], [layout.pack(made)])
    np.testing.assert_allclose(function(layout.pack(given)).full().ravel(), layout.pack(given), atol=1e-12)


def test_laws_see_no_vectoring_angles_whether_one_or_many(robot: Robot, tmp_path: Path) -> None:
    reference = zero_reference(2, 3)._replace(ahead=(zero_reference(2, 3),))
    bare = without_angles(robot, reference)
    assert bare.vectoring_angles.shape == bare.ahead[0].vectoring_angles.shape == (0,)
    measured = zero_measurement(2, 3)._replace(vectoring_angles=PSI)
    assert with_angles(robot, without_angles(robot, measured), measured) == measured
    # Of a single symbol CasADi would make a row of nothing.
    one = zero_measurement(0, 1)._replace(vectoring_angles=ca.SX.sym("psi"))
    assert without_angles(robot, one).vectoring_angles.shape == (0,)


def test_four_rotors_pass_as_they_are() -> None:
    robot = load_robot("hydrus_quad")
    given = Command(np.ones(4), np.zeros(robot.n_joints), np.zeros(0))
    assert as_pairs(robot, given) is from_pairs(robot, given) is given
    measured = zero_measurement(robot.n_joints, 0)
    assert without_angles(robot, measured) is measured
    assert time_constants(robot, 0.05) == 0.05


def test_a_side_is_as_slow_as_its_servo(robot: Robot) -> None:
    np.testing.assert_allclose(time_constants(robot.pairs, 0.05), [0.05] * 3 + [2.0 / 50.0] * 3)


def momentum(robot: Robot, thrusts: np.ndarray, psi: np.ndarray) -> np.ndarray:
    """Angular momentum of the rotors about their axes, sum spin J Omega u, in {C}, N m s, (3,)."""
    state = robot.at(robot.nominal_posture(), psi)
    speeds = np.sqrt(thrusts / 1e-5)
    spins = np.array([rotor.spin for rotor in robot.description.rotors])
    return state.allocation_C[:3] @ (spins * 1e-4 * speeds)


def test_the_reaction_of_pairs_is_the_change_of_the_rotors_momentum(robot: Robot) -> None:
    """Motors that change their speed and servos that turn what spins, about the first angles."""
    dt, dT, dpsi = 1e-3, np.array([1e-3, -2e-3, 5e-4]), np.array([2e-4, 1e-4, -3e-4])
    turned, still = robot.turned, np.zeros(3)
    assert turned is not None
    truth = -(momentum(robot, THRUSTS + dT, dpsi) - momentum(robot, THRUSTS, still)) / dt
    pairs = robot.pairs
    body = BodyState(still, still, np.eye(3), still, pairs.at(robot.nominal_posture(), []))
    before, after = turned.pairs(THRUSTS, still), turned.pairs(THRUSTS + dT, dpsi)
    found = reaction_torque(pairs, body, before, after, dt)
    np.testing.assert_allclose(found, truth, rtol=1e-3, atol=1e-6)
    assert np.abs(truth).max() > 0.01
    # Thrusts are chosen for what servos turn.
    turning = -(momentum(robot, THRUSTS, dpsi) - momentum(robot, THRUSTS, still)) / dt
    known = reaction(pairs, body, before, np.full(6, 25.0))
    change = turned.pairs(THRUSTS, dpsi) - before
    np.testing.assert_allclose(known.matrix[3:] @ change / 25.0 / dt, turning, rtol=1e-3, atol=1e-5)


def test_zeros_know_what_servos_turn(robot: Robot) -> None:
    q = robot.nominal_posture()
    zeros = reaction_zeros(robot.pairs, q, np.zeros(0))
    assert len(zeros) > 0
    assert not np.allclose(zeros, reaction_zeros(robot.pairs, q, np.zeros(0), 2e-4))
