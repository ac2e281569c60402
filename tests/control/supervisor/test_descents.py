"""Ways down without a rotor: which there are, that the others carry the robot there, how it goes there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import skylimb
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.supervisor.balance import RATE
from skylimb.control.supervisor.descents import (
    LEANS,
    NEAR,
    ROOM,
    Descents,
    descents_of,
    protecting_posture,
)
from skylimb.control.supervisor.limits import Limits
from skylimb.robots.equilibrium import hovers
from skylimb.robots.equilibrium_results import Held, Within
from skylimb.robots.model import Robot

LOOKING = Limits(losses=True)


@pytest.mark.parametrize(
    ("name", "purpose", "protected"),
    [
        ("hydrus_xi_quad", "contact", [False, True, True, False]),
        pytest.param("hydrus_xi_quad", "torque", [False, True, True, False], marks=pytest.mark.slow),
        pytest.param("hydrus_xi_hex", "torque", [True] * 6, marks=pytest.mark.slow),
        ("tilted_hexarotor", "torque", [False, False, True, True, False, False]),
    ],
)
def test_where_there_is_a_way_down_the_other_rotors_carry_the_robot(
    name: str, purpose: str, protected: list[bool]
) -> None:
    robot = skylimb.load_robot(name)
    angles = descents_of(robot, purpose, LOOKING).angles
    assert [one is not None for one in angles] == protected
    q, _ = nominal_posture(robot, purpose)
    for lost, psi in enumerate(angles):
        if psi is None or robot.n_rotors > 4:
            continue
        Q = np.delete(robot.wrench_function(q, psi).full(), lost, axis=1)
        thrusts = np.cross(Q[3], Q[4])  # those without a torque in roll and pitch
        force = Q[:3] @ thrusts
        thrusts *= robot.weight / np.linalg.norm(force) * np.sign(force[2])
        low, high = (np.delete(ends, lost) for ends in robot.thrust_limits())
        assert ((thrusts > low) & (thrusts < high)).all()
        assert np.arccos(abs(force[2]) / np.linalg.norm(force)) < LEANS[-1] + 0.05
        assert abs(Q[5] @ thrusts) < 1.0


def test_a_posture_in_which_a_rotor_could_be_lost_carries_the_robot() -> None:
    robot = skylimb.load_robot("hydrus_xi_quad")
    q = protecting_posture(robot, "contact", 3)
    assert q is not None
    nominal, psi = nominal_posture(robot, "contact")
    assert 0.05 < np.abs(q - nominal).max() < 0.6
    others = robot.description.rotors[:3]
    rest = Robot(replace(robot.description, rotors=others))
    found = hovers(rest, q, psi, Within(LEANS[-1], np.inf))
    rooms = [one.room for one in found if isinstance(one, Held)]
    assert max(rooms) >= ROOM


def test_nobody_searches_where_nobody_looks() -> None:
    assert descents_of(skylimb.load_robot("hydrus_xi_quad"), "torque", Limits()) == Descents()


def test_the_angles_go_straight_to_their_end_and_stay_there() -> None:
    ways, here, dt = Descents((None, np.array([1.0, -0.5]))), np.zeros(2), 0.005
    np.testing.assert_array_equal(ways.followed(np.ones(2), np.zeros(0), here, dt), here)
    np.testing.assert_array_equal(ways.followed(np.array([0.0, 1.0]), np.zeros(0), here, dt), here)
    path = [here]
    for _ in range(80):
        path.append(ways.followed(np.array([1.0, 0.0]), np.zeros(0), path[-1], dt))
    np.testing.assert_array_equal(path[-1], [1.0, -0.5])
    np.testing.assert_allclose(np.array(path) @ [0.5, 1.0], 0.0, atol=1e-12)
    assert np.abs(np.diff(path, axis=0)).max() == pytest.approx(RATE * dt)
    assert [ways.missing(np.array(left)) for left in ([1.0, 0.0], [0.0, 1.0], [1.0, 1.0])] == [0.0, 1.0, 0.0]


def test_a_limp_joint_needs_no_torque_with_near_angles() -> None:
    robot = skylimb.load_robot("hydrus_xi_quad")
    q, psi = nominal_posture(robot, "contact")
    ways = descents_of(robot, "contact", Limits(losses=True))
    free, *others = ways.limp
    assert free is not None
    assert others == [None, None]  # they are too far: those are found in flight
    np.testing.assert_array_equal(ways.unanswered(np.ones(7)), [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    assert np.abs(free - psi).max() <= NEAR + 1e-6
    found = [next(hovers(robot, q, angles, Within(LEANS[-1], 0.0))) for angles in (free, psi)]
    now, before = (abs(one.joint_torques[0]) for one in found if isinstance(one, Held))
    assert now < 0.1 < 0.3 < before
    there, limp = psi, np.array([1.0, 0.0, 0.0])
    for _ in range(80):
        there = ways.followed(np.ones(4), limp, there, 0.005)
    np.testing.assert_allclose(there, free, atol=1e-12)
