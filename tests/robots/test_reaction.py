"""Zeros of lift and torque by the rotors' reaction."""

import dataclasses
import math

import numpy as np
import pytest

from skylimb.control.planning.vectoring import nominal_posture
from skylimb.robots import load_robot
from skylimb.robots.model import Robot
from skylimb.robots.reaction import reaction_zeros, slowest_unstable_zero

ROBOT = load_robot("hydrus_xi_quad")
Q = ROBOT.nominal_posture()


def contact_angles() -> np.ndarray:
    """Those for contact on the paper's side, nearly: the mirror image of the table's."""
    return -nominal_posture(ROBOT, "contact")[1]


def test_the_determinant_is_zero_there_and_nowhere_else() -> None:
    rng = np.random.default_rng(5)
    for psi in (contact_angles(), *rng.uniform(-np.pi, np.pi, (5, 4))):
        state = ROBOT.at(Q, psi)
        if state.hover_thrusts.min() < 1.0:
            continue
        allocation, reaction = state.allocation_C[2:], np.zeros((4, 4))
        for i, rotor in enumerate(ROBOT.description.rotors):
            speed = math.sqrt(state.hover_thrusts[i] / 4.04e-5)
            # A newton more is so many rad/s more, and the body takes up their momentum.
            reaction[1:, i] = -rotor.spin * 2e-4 / (2.0 * 4.04e-5 * speed) * state.allocation_C[:3, i]
        for zero in reaction_zeros(ROBOT, Q, psi):
            shares = np.abs(np.linalg.svd(allocation + zero * reaction, compute_uv=False))
            assert shares[-1] < 1e-8 * shares[0]
        sample = np.abs(np.linalg.svd(allocation + 37.7j * reaction, compute_uv=False))
        assert sample[-1] > 1e-4 * sample[0]


def test_twice_the_inertia_halves_the_zeros() -> None:
    psi = contact_angles()
    once, twice = (reaction_zeros(ROBOT, Q, psi, inertia) for inertia in (2e-4, 4e-4))
    np.testing.assert_allclose(once, 2.0 * twice, rtol=1e-9)
    assert slowest_unstable_zero(once) == pytest.approx(23.6, abs=0.1)


def test_in_contact_the_robot_stands_on_the_side_where_reaction_helps() -> None:
    assert slowest_unstable_zero(reaction_zeros(ROBOT, *nominal_posture(ROBOT, "contact"))) > 150.0


def test_without_inertia_there_is_none() -> None:
    assert slowest_unstable_zero(reaction_zeros(ROBOT, Q, contact_angles(), 0.0)) == math.inf
    dragon = load_robot("dragon")  # pairs of fans, whose momenta cancel
    psi = dragon.description.vectoring_start
    assert len(reaction_zeros(dragon, dragon.nominal_posture(), psi)) == 0


def test_turning_the_other_way_round_moves_the_zero_to_the_other_side() -> None:
    """Only the spins decide on which side it is: kappa is small beside the tilt of the rotors."""
    d = ROBOT.description
    flipped = tuple(
        dataclasses.replace(rotor, spin=-rotor.spin, drag_torque_coefficient=-rotor.drag_torque_coefficient)
        for rotor in d.rotors
    )
    other = Robot(dataclasses.replace(d, rotors=flipped))
    assert slowest_unstable_zero(reaction_zeros(other, Q, contact_angles())) > 150.0
