"""The other contact: spring and damper along the normal, a bristle across it."""

from __future__ import annotations

import numpy as np
import pytest

from skylimb.flight.experiments.experiment import load_experiment
from skylimb.simulation.spring_contact import SpringContact
from skylimb.simulation.surfaces import Surface

RADIUS, MASS, STEP = 0.004, 1.6, 1e-3
STILL = np.zeros(3)


def surface(**keys: float) -> Surface:
    return load_experiment("paper", {f"surface.{key}": value for key, value in keys.items()}).surface


def pressed(board: Surface, depth: float) -> np.ndarray:
    """Centre of a tip that is so deep in a board, W."""
    return np.asarray(board.position) - (RADIUS - depth) * board.R_WS[:, 0]


def test_it_presses_as_a_spring_and_a_damper_and_never_pulls() -> None:
    board = surface(stiffness=4000.0, friction=0.3)
    outward = -board.R_WS[:, 0]
    contact = SpringContact(board, RADIUS, MASS, STEP)
    force, point = contact(pressed(board, 5e-4), STILL, 0.0)
    np.testing.assert_allclose(force, 2.0 * outward, atol=1e-9)
    np.testing.assert_allclose(board.signed_distance(point[None])[0], -2.5e-4, atol=1e-9)
    damping = board.contact.normal_damping(MASS)
    force, _ = contact(pressed(board, 5e-4), -0.01 * outward, 0.0)
    np.testing.assert_allclose(force, (2.0 + 0.01 * damping) * outward, atol=1e-9)
    for depth, velocity in ((-1e-6, STILL), (1e-5, 1.0 * outward)):
        np.testing.assert_array_equal(contact(pressed(board, depth), velocity, 0.0)[0], STILL)


def test_a_tip_that_slides_is_braked_by_the_cone_against_its_slip() -> None:
    board = surface(stiffness=4000.0, friction=0.3)
    contact, across = SpringContact(board, RADIUS, MASS, STEP), board.R_WS[:, 1]
    force = [contact(pressed(board, 5e-4), 0.02 * across, 0.0)[0] for _ in range(50)][-1]
    np.testing.assert_allclose(force + 2.0 * board.R_WS[:, 0], -0.3 * 2.0 * across, atol=1e-9)


def test_a_tip_that_sticks_holds_its_load_without_a_creep() -> None:
    """Under half of what the cone holds it stays where its bristle has bent to."""
    board = surface(stiffness=4000.0, friction=0.3)
    contact, across = SpringContact(board, RADIUS, MASS, STEP), board.R_WS[:, 1]
    place, speed, mass = 0.0, 0.0, 0.5
    places = []
    for _ in range(4000):
        force, _ = contact(pressed(board, 5e-4) + place * across, speed * across, 0.0)
        speed += STEP * (0.3 + float(force @ across)) / mass
        place += STEP * speed
        places.append(place)
    assert places[-1] == pytest.approx(0.3 / (10.0 * 4000.0), rel=1e-3)
    assert abs(places[-1] - places[-2000]) < 1e-9


def test_a_surface_that_moves_takes_the_tip_along() -> None:
    board = surface(sway_amplitude=0.05, sway_frequency=0.5)
    contact, time = SpringContact(board, RADIUS, MASS, STEP), 0.4
    moved = pressed(board, 5e-4) + board.motion(time)[0] * board.motion_axis
    force, _ = contact(moved, board.velocity(time), time)
    np.testing.assert_allclose(force, -board.stiffness * 5e-4 * board.R_WS[:, 0], atol=1e-9)
