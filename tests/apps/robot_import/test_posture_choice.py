"""Postures of chains that carry their rotors: the tip ahead of all, and a hover with room."""

from dataclasses import replace

import numpy as np
import pytest

import skylimb
from skylimb.apps.robot_import.posture_choice import choose_posture
from skylimb.robots.hover import find_hover
from skylimb.robots.model import Robot
from skylimb.robots.touch import can_touch


@pytest.mark.parametrize("name", ["hydrus_quad", "hydrus_xi_quad", "hydrus_xi_hex", "dragon"])
def test_a_chain_stands_so_that_it_can_touch_a_wall_ahead(name: str) -> None:
    described = skylimb.load_robot(name).description
    family = choose_posture(Robot(described))
    robot = Robot(replace(described, posture=family))
    q = robot.nominal_posture()
    hover = find_hover(robot, q)
    assert hover
    assert hover.room > 0.2
    assert can_touch(robot, q, hover.vectoring_angles, np.array([1.0, 0.0, 0.0]))
