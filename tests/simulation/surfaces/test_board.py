"""The board's placement and geometry, its motion, and that physics and analysis see the same board."""

import math

import numpy as np
import pytest

from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.simulation.surfaces import Board, surface_from_mapping


def test_slope_follows_the_papers_line():
    board = Board(position=(1.2, 0.1, 0.9), slope=0.35)
    y, z = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(0, 2, 4))
    x = 1.2 + (y - 0.1) * math.tan(0.35)
    np.testing.assert_allclose(board.signed_distance(np.stack([x, y, z], -1)), 0.0, atol=1e-12)
    assert np.all(board.normal(np.zeros(3)) == pytest.approx([-math.cos(0.35), math.sin(0.35), 0.0]))


def test_pitch_recedes_upward():
    board = Board(position=(1.0, 0.0, 1.0), pitch=0.2)
    ahead = board.distance_along(np.array([[0.0, 0.3, 1.0], [0.0, 0.3, 1.5]]))
    np.testing.assert_allclose(ahead, [1.0, 1.0 + 0.5 * math.tan(0.2)], atol=1e-12)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (0.6, 0.8, 0.0)])
def test_contact_axis_places_ceilings_floors_and_far_walls(axis):
    board = Board(position=(0.3, 0.2, 0.1), contact_axis=axis)
    np.testing.assert_allclose(board.normal(np.zeros(3)), -np.array(axis), atol=1e-12)
    assert np.linalg.det(board.R_WS) == pytest.approx(1.0)
    np.testing.assert_allclose(board.distance_along(np.array(board.position) - 0.7 * np.array(axis)), 0.7)


def test_round_trip_of_frames_and_projection():
    board = Board(position=(1.0, 0.2, 1.0), slope=-0.4, pitch=0.2, advance_distance=0.1)
    points = np.random.default_rng(0).normal(size=(20, 3))
    np.testing.assert_allclose(board.to_world(board.to_local(points, 2.0), 2.0), points, atol=1e-12)
    feet = board.project(points, 2.0)
    gaps = board.signed_distance(points, 2.0)
    np.testing.assert_allclose(feet + gaps[:, None] * board.normal(points, 2.0), points, atol=1e-12)


def test_the_slide_moves_the_board_as_the_motion_says(scene_of):
    board = Board(slope=0.2, advance_distance=0.1, advance_speed=0.05, advance_start=0.5, sway_amplitude=0.01)
    scene = scene_of(board)
    scene.data.joint(scene.parts.joint).qpos = board.motion(1.7)[0]
    foot = board.to_world(np.zeros(3), 1.7)
    [(distance, outward, _)] = scene.touch(foot + 0.002 * board.normal(foot, 1.7))
    assert distance == pytest.approx(0.002 - scene.radius, abs=1e-9)
    np.testing.assert_allclose(outward, board.normal(foot), atol=1e-9)


def test_motion_is_smooth_and_ends_where_it_should():
    board = Board(advance_distance=0.1, advance_speed=0.05, advance_start=0.5)
    t = np.linspace(0, 4, 4001)
    x, v = board.motion(t)
    assert (x[0], v[0]) == (0.0, 0.0)
    assert x[-1] == pytest.approx(0.1, abs=1e-12)
    assert v[-1] == 0.0
    assert v.max() == pytest.approx(0.05)
    np.testing.assert_allclose(np.gradient(x, t)[1:-1], v[1:-1], atol=1e-5)
    assert np.all(np.abs(np.diff(v)) < 0.05 * math.pi / 2 / 0.2 * 1e-3 * 1.01)
    assert not Board().moves


def test_tables_select_the_surface_and_survive_a_round_trip():
    board = surface_from_mapping({"kind": "board", "slope": 0.3, "position": [1, 0, 1], "friction": 0.2})
    assert board == Board(slope=0.3, position=(1.0, 0.0, 1.0), friction=0.2)
    assert surface_from_mapping(board.describe()["parameters"]) == board
    assert board.contact.friction == 0.2


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"kind": "boat"}, ["boat", "did you mean 'board'"]),
        ({"kind": 3}, ["surface.kind", "3"]),
        ({"slop": 0.3}, ["slop", "slope"]),
        ({"slope": 20.0}, ["surface.slope", "degrees", "0.349"]),
        ({"friction": -0.2}, ["surface.friction", "-0.2"]),
        ({"stiffness": 10}, ["surface.stiffness", "50"]),
        ({"contact_axis": [1.0, 1.0, 0.0]}, ["surface.contact_axis", "unit vector"]),
        ({"position": [1000.0, 0.0, 0.0]}, ["surface.position = 1000 m (entry 1 of 3)"]),
        ({"size": [0.0, 1.0]}, ["surface.size"]),
        ({"advance_speed": 0.0}, ["surface.advance_speed"]),
        ({"friction": "high"}, ["friction", "high"]),
    ],
)
def test_bad_tables_are_named(table, words):
    with pytest.raises((ConfigError, UnknownNameError)) as caught:
        surface_from_mapping(table)
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)
