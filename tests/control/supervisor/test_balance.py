"""Vectoring angles beside joints that no servo holds: they carry the robot level, and push past none."""

from __future__ import annotations

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.records import zero_measurement
from skylimb.control.estimation.servos import servo_lags
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.supervisor.balance import RATE, balanced
from skylimb.robots.loads import loads_function

ROBOT = skylimb.load_robot("hydrus_xi_quad")
Q, LEVEL = nominal_posture(ROBOT, "contact")
AXES = np.asarray(ROBOT.at(Q, LEVEL).R_root_C)
SEEN = zero_measurement(3, 4)._replace(joint_angles=Q)
DT = 0.005


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
        command = balanced(ROBOT, loose, 0.0, SEEN._replace(vectoring_angles=psi), speeds, AXES, last, DT)
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
    running = balanced(ROBOT, loose, 0.0, SEEN._replace(vectoring_angles=psi), speeds, AXES, LEVEL, DT)
    arrived = balanced(ROBOT, loose, 0.0, SEEN._replace(vectoring_angles=ahead), np.zeros(7), AXES, LEVEL, DT)
    np.testing.assert_array_equal(running, arrived)
    behind = balanced(ROBOT, loose, 0.0, SEEN._replace(vectoring_angles=psi), np.zeros(7), AXES, LEVEL, DT)
    assert np.abs(running - behind).max() > 1e-6


@pytest.mark.parametrize("joint", range(3))
@pytest.mark.parametrize("way", [0.35, -0.35])
def test_an_arm_that_a_servo_bends_elsewhere_is_carried_level(joint: int, way: float) -> None:
    q, command = Q + way * np.eye(3)[joint], LEVEL
    for _ in range(300):
        seen = SEEN._replace(joint_angles=q)
        command = balanced(ROBOT, np.zeros(7), 1.0, seen, np.zeros(7), AXES, command, DT)
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
        command = balanced(ROBOT, loose, 0.0, SEEN, np.zeros(7), AXES, command, DT)
    assert pushed(command) < 0.6 * pushed(LEVEL)


def test_where_all_is_held_nothing_moves() -> None:
    still = balanced(ROBOT, np.zeros(7), 0.0, SEEN, np.zeros(7), AXES, LEVEL + 0.3, DT)
    np.testing.assert_array_equal(still, LEVEL + 0.3)
    none = np.zeros(0)
    fixed = skylimb.load_robot("tilted_hexarotor")
    assert balanced(fixed, none, 0.0, zero_measurement(0, 0), none, np.eye(3), none, DT) is none
