"""The drawing of frames and signs is up to date, and what it says is what the model does."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.control.missions.frame import contact_frame

ROOT = Path(__file__).parents[2]


def test_the_drawing_is_the_scripts():
    made = runpy.run_path(str(ROOT / "docs" / "conventions.py"))
    assert made["FILE"].read_text(encoding="utf-8") == made["drawing"](), "python docs/conventions.py"


def test_drag_turns_the_robot_against_the_spin():
    robot = skylimb.load_robot("hydrus_quad")
    q = robot.nominal_posture()
    wrench, poses = robot.wrench_function(q, np.zeros(0)).full(), robot.link_poses(q, np.zeros(0))
    cog = robot.at(q, np.zeros(0)).cog_root
    for rotor, column in zip(robot.description.rotors, wrench.T, strict=True):
        place, R = poses[rotor.link]
        force, torque = column[:3], column[3:]
        drag = torque - np.cross(place + R @ rotor.xyz - cog, force)
        np.testing.assert_allclose(force, R @ rotor.R[:, 2], atol=1e-12)
        against = -rotor.spin * abs(rotor.drag_torque_coefficient)
        np.testing.assert_allclose(drag, against * force, atol=1e-12)


@pytest.mark.parametrize(
    ("axis", "u", "v"),
    [
        ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)),
    ],
)
def test_the_path_lies_across_the_contact_axis(axis, u, v):
    frame = contact_frame(axis)
    np.testing.assert_allclose([frame.sliding_u, frame.sliding_v], [u, v], atol=1e-12)
    np.testing.assert_allclose(np.cross(frame.contact, frame.sliding_u), frame.sliding_v, atol=1e-12)


def test_the_hovering_frame_is_the_root_turned_without_yaw():
    robot = skylimb.load_robot("hydrus_xi_quad")
    R = robot.at(robot.nominal_posture(), robot.description.vectoring_start).R_root_C
    assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(0.0, abs=1e-12)
