"""How far a robot's discs and shapes reach."""

import numpy as np
import pytest

import skylimb
from skylimb.robots.extent import drawn_radius, parts_of, rim
from skylimb.robots.links import Link, Visual
from skylimb.robots.touch import can_touch

UP, HERE = np.array([0.0, 0.0, 1.0]), np.zeros(3)


def drawn(shape, size, xyz=(0.0, 0.0, 0.0), R=None):
    turned = np.eye(3) if R is None else R
    return Link("hub", visuals=(Visual(shape, size, np.array(xyz), turned, (0.5, 0.5, 0.5, 1.0)),))


@pytest.mark.parametrize(
    ("link", "radius"),
    [
        (drawn("cylinder", (0.13, 0.006)), 0.13),
        (drawn("cylinder", (0.13, 0.006), (0.0, 0.0, 0.05)), 0.13),
        (drawn("box", (0.24, 0.1, 0.01)), 0.13),
        (drawn("cylinder", (0.13, 0.1)), None),  # no disc
        (drawn("cylinder", (0.13, 0.006), (0.2, 0.0, 0.0)), None),  # beside the axis
        (drawn("cylinder", (0.13, 0.006), R=np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])), None),  # upright
        (drawn("sphere", (0.13,)), None),
    ],
)
def test_a_propeller_is_known_by_what_draws_it(link, radius):
    assert drawn_radius([link], "hub", HERE, UP) == (None if radius is None else pytest.approx(radius))


def test_every_rotor_that_ships_has_its_drawn_disc():
    expected = {
        "dragon": 0.07,
        "hydrus_quad": 0.178,
        "hydrus_xi_hex": 0.178,
        "hydrus_xi_quad": 0.18,
        "hydrus_xi_quad_mast": 0.18,
        "tiltable_hexarotor": 0.12,
        "tilted_hexarotor": 0.13,
    }
    found = {
        name: {rotor.radius for rotor in skylimb.load_robot(name).description.rotors} for name in expected
    }
    assert found == {name: {radius} for name, radius in expected.items()}


def test_the_rim_lies_on_the_disc():
    rotor = skylimb.load_robot("hydrus_quad").description.rotors[0]
    assert rotor.radius is not None
    away = rim(rotor) - rotor.xyz
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), rotor.radius)
    np.testing.assert_allclose(away @ rotor.R[:, 2], 0.0, atol=1e-12)


def test_the_tool_is_no_part_that_must_not_touch():
    names = [part.name for part in parts_of(skylimb.load_robot("hydrus_xi_quad").description)]
    assert names.count("pen") == 1  # its body; nib and ball are the tool
    assert names.count("rotor1") == 3  # the disc, and what draws rotor and hub


def test_a_disc_before_the_tip_is_in_the_way(tmp_path):
    source = skylimb.load_robot("tilted_hexarotor").description.folder
    for path in source.iterdir():
        text = path.read_text(encoding="utf-8").replace('link = "rotor1"', 'link = "rotor1"\nradius = 0.4')
        (tmp_path / path.name).write_text(text, encoding="utf-8")
    robot = skylimb.load_robot(tmp_path)
    touch = can_touch(robot, np.zeros(0), np.zeros(0), np.array([1.0, 0.0, 0.0]))
    assert not touch
    assert touch.nearest == "rotor1"
