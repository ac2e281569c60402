"""Vectoring angles beside joints that no servo holds: they carry the robot level, and push past none."""

from __future__ import annotations

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.records import Measurement, zero_measurement
from skylimb.control.estimation.servos import servo_lags
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.supervisor.balance import RATE, balanced
from skylimb.robots.loads import loads_function

ROBOT = skylimb.load_robot("hydrus_xi_quad")
Q, LEVEL = nominal_posture(ROBOT, "contact")
AXES = np.asarray(ROBOT.at(Q, LEVEL).R_root_C)
SEEN = zero_measurement(3, 4)._replace(joint_angles=Q)
DT = 0.005
LIFT = np.array([0.0, 0.0, ROBOT.weight])


def turned(
    loose: np.ndarray,
    seen: Measurement,
    speeds: np.ndarray,
    angles: np.ndarray,
    astray: float = 0.0,
    there: np.ndarray | None = None,
    push: np.ndarray = LIFT,
) -> np.ndarray:
    """Vectoring angles of the next tick."""
    there = np.ones(4) if there is None else there
    return balanced(ROBOT, loose, astray, there, seen, speeds, AXES, push, angles, DT)


def best(psi: np.ndarray, q: np.ndarray = Q) -> tuple[np.ndarray, np.ndarray]:
    """What is left over sideways (N) and of yaw (N m) by the thrusts that give lift, roll and pitch."""
    wrench, *_ = loads_function(ROBOT)(q, psi)
    A = np.kron(np.eye(2), AXES.T) @ wrench.full()
    wanted = np.array([0.0, 0.0, ROBOT.weight, 0.0, 0.0, 0.0])
    counts = np.array([1.0, 1.0, 1e3, 1e3, 1e3, 1.0])
    thrusts = np.linalg.lstsq(counts[:, None] * A, counts * wanted, rcond=None)[0]
    return (A @ thrusts)[[0, 1, 5]], thrusts


@pytest.mark.parametrize("servo", range(4))
@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_three_rotors_turn_along_with_a_servo_that_runs_away(servo: int, speed: float) -> None:
    psi, command, left = LEVEL.copy(), LEVEL.copy(), []
    loose, speeds = np.zeros(7), np.zeros(7)
    loose[3 + servo], speeds[3 + servo] = 1.0, speed
    lag = servo_lags(ROBOT)[3:]
    for _ in range(650):  # more than a turn
        last = command
        command = turned(loose, SEEN._replace(vectoring_angles=psi), speeds, last)
        assert np.abs(command - last).max() <= RATE * DT * (1.0 + 1e-9)
        assert command[servo] == LEVEL[servo]
        psi = psi + DT * (command - psi) / lag
        psi[servo] = LEVEL[servo] + speed * DT * (len(left) + 1)
        side, thrusts = best(psi)
        left.append([np.hypot(*side[:2]) / ROBOT.weight, abs(side[2])])
        assert thrusts.min() > 1.0
        assert thrusts.max() < 28.0
    lean, yaw = np.array(left).max(axis=0)
    assert lean < 0.08
    assert yaw < 2.5
    # The others left where they were, more is left over.
    alone, _ = best(LEVEL + np.pi * np.eye(4)[servo])
    assert (
        np.linalg.norm(alone) > 3.0 > ROBOT.weight * np.median(left, axis=0)[0] + np.median(left, axis=0)[1]
    )


def test_a_servo_that_runs_away_is_taken_where_the_others_will_have_followed() -> None:
    loose, speeds, psi = np.eye(7)[4], 1.5 * np.eye(7)[4], LEVEL + 0.4 * np.eye(4)[1]
    ahead = psi + (speeds * servo_lags(ROBOT))[3:]
    running = turned(loose, SEEN._replace(vectoring_angles=psi), speeds, LEVEL)
    arrived = turned(loose, SEEN._replace(vectoring_angles=ahead), np.zeros(7), LEVEL)
    np.testing.assert_array_equal(running, arrived)
    behind = turned(loose, SEEN._replace(vectoring_angles=psi), np.zeros(7), LEVEL)
    assert np.abs(running - behind).max() > 1e-6


@pytest.mark.parametrize("joint", range(3))
@pytest.mark.parametrize("way", [0.35, -0.35])
def test_an_arm_that_a_servo_bends_elsewhere_is_carried_level(joint: int, way: float) -> None:
    q, command = Q + way * np.eye(3)[joint], LEVEL
    for _ in range(300):
        seen = SEEN._replace(joint_angles=q)
        command = turned(np.zeros(7), seen, np.zeros(7), command, astray=1.0)
    side, thrusts = best(command, q)
    assert np.abs(side).max() < 0.05 < 0.5 < np.abs(best(LEVEL, q)[0]).max()
    assert np.ptp(thrusts) < np.ptp(best(LEVEL, q)[1])


@pytest.mark.parametrize("joint", range(3))
def test_a_limp_joint_is_pushed_less(joint: int) -> None:
    loose, command = np.eye(7)[joint], LEVEL

    def pushed(psi: np.ndarray) -> float:
        _, loads, *_ = loads_function(ROBOT)(Q, psi)
        return abs(float((loads.full() @ best(psi)[1])[joint]))

    for _ in range(300):
        command = turned(loose, SEEN, np.zeros(7), command)
    assert pushed(command) < 0.6 * pushed(LEVEL)


@pytest.mark.parametrize("lost", [1, 2])
@pytest.mark.parametrize("side", [(0.0, 0.0), (5.0, 0.0), (0.0, -5.0)])
def test_without_a_rotor_the_angles_turn_the_push_of_the_others_upright_and_aside(
    lost: int, side: tuple[float, float]
) -> None:
    there, command = 1.0 - np.eye(4)[lost], LEVEL
    push = np.array([*side, ROBOT.weight])

    def off(psi: np.ndarray) -> float:
        wrench = np.kron(np.eye(2), AXES.T) @ loads_function(ROBOT)(Q, psi)[0].full() @ np.diag(there)
        thrusts = np.linalg.pinv(wrench[2:5]) @ np.array([ROBOT.weight, 0.0, 0.0])
        return float(np.linalg.norm((wrench @ thrusts)[[0, 1, 5]] - [*side, 0.0]))

    for _ in range(300):
        last = command
        command = turned(np.zeros(7), SEEN, np.zeros(7), last, 1.0, there, push)
        assert np.abs(command - last).max() <= RATE * DT * (1.0 + 1e-9)
    assert off(command) < 0.7 * off(LEVEL)


def test_where_all_is_held_nothing_moves() -> None:
    still = turned(np.zeros(7), SEEN, np.zeros(7), LEVEL + 0.3)
    np.testing.assert_array_equal(still, LEVEL + 0.3)
    none = np.zeros(0)
    fixed = skylimb.load_robot("tilted_hexarotor")
    nothing = zero_measurement(0, 0)
    assert balanced(fixed, none, 0.0, np.ones(6), nothing, none, np.eye(3), LIFT, none, DT) is none
