"""Which way rotors turn where nothing says it, and what is believed where something does."""

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

import skylimb
from lab_style import lab_urdf
from made_robots import joint, link
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.apps.robot_import.writing import mapping_text
from skylimb.robots.model import Robot

SHIPPED = Path(skylimb.load_robot("tilted_hexarotor").description.folder).parent
CW, CCW = -1, 1


def frame(path: Path, places, *, names=None, cant=None) -> Path:
    """A multirotor with rotors on fixed joints, at degrees clockwise from the nose and a height."""
    parts = [link("base", 1.5, gyration=0.1)]
    for k, (angle, height) in enumerate(places):
        name, turn = (names or [f"rotor{n + 1}" for n in range(len(places))])[k], -math.radians(angle)
        at = f"{0.3 * math.cos(turn)} {0.3 * math.sin(turn)} {height}"
        parts.append(link(name, 0.02, gyration=0.04))
        text = joint(f"mount_{name}", "base", name, xyz=at)
        rpy = f"{cant[k] if cant else 0.0} 0 {turn}"
        parts.append(text.replace(f'xyz="{at}"', f'xyz="{at}" rpy="{rpy}"', 1))
    path.write_text(f'<robot name="made">{"".join(parts)}</robot>\n')
    return path


def spins(path: Path, **given) -> list[int]:
    return [rotor.spin for rotor in check_robot_file(path, **given).description.rotors]


def doubts(path: Path, **given) -> str:
    return " ".join(map(str, check_robot_file(path, **given).doubts))


def flat(*angles):
    return [(angle, 0.0) for angle in angles]


PX4 = {
    "quad x": (flat(45, -135, -45, 135), [CCW, CCW, CW, CW]),
    "quad +": (flat(90, -90, 0, 180), [CCW, CCW, CW, CW]),
    "hexa x": (flat(90, -90, -30, 150, 30, -150), [CW, CCW, CW, CCW, CCW, CW]),
    "hexa +": (flat(0, 180, -120, 60, -60, 120), [CW, CCW, CW, CCW, CCW, CW]),
    "octo x": (
        flat(22.5, -157.5, 67.5, 157.5, -22.5, -112.5, -67.5, 112.5),
        [CW, CW, CCW, CCW, CCW, CCW, CW, CW],
    ),
    "octo +": (flat(0, 180, 45, 135, -45, -135, -90, 90), [CW, CW, CCW, CCW, CCW, CCW, CW, CW]),
    "octo coaxial": (
        [(45, 0.1), (-45, 0.1), (-135, 0.1), (135, 0.1), (-45, -0.1), (45, -0.1), (135, -0.1), (-135, -0.1)],
        [CCW, CW, CCW, CW, CCW, CW, CCW, CW],
    ),
    "hexa coaxial": (
        [(60, 0.1), (60, -0.1), (180, 0.1), (180, -0.1), (-60, 0.1), (-60, -0.1)],
        [CW, CCW, CW, CCW, CW, CCW],
    ),
}
"""Motors in PX4's order: degrees clockwise from the nose with a height, and the senses of its airframes."""


@pytest.mark.parametrize("name", PX4)
def test_upright_rotors_turn_as_px4_orders_them(tmp_path: Path, name: str) -> None:
    places, expected = PX4[name]
    path = frame(tmp_path / "made.urdf", places)
    assert spins(path) == expected
    assert "spin of the rotors: is not said; they are taken to turn as PX4 orders" in doubts(path)


@pytest.mark.parametrize("name", ["quad x", "quad +", "hexa x", "octo x"])
def test_frames_in_px4s_order_hover(tmp_path: Path, name: str) -> None:
    """By turns along the order of the motors, yaw and pitch of a quadrotor were one."""
    report = check_robot_file(frame(tmp_path / "made.urdf", PX4[name][0]))
    assert report.can_hover, report.reasons


@pytest.mark.parametrize("name", ["tilted_hexarotor", "tiltable_hexarotor"])
def test_a_shipped_robots_urdf_alone_gives_the_spins_of_its_flight_file(tmp_path: Path, name: str) -> None:
    shutil.copy(SHIPPED / name / f"{name}.urdf", tmp_path / "made.urdf")
    said = [{"link": rotor.link} for rotor in skylimb.load_robot(name).description.rotors]
    mapping = tmp_path / "mapping.toml"
    mapping.write_text("".join(f'[[rotors]]\nlink = "{rotor["link"]}"\n' for rotor in said))
    expected = [rotor.spin for rotor in skylimb.load_robot(name).description.rotors]
    assert spins(tmp_path / "made.urdf", mapping=mapping) == expected


@pytest.mark.parametrize("side", [1, -1])
def test_the_drag_of_canted_rotors_turns_the_robot_as_their_thrust_does(tmp_path: Path, side: int) -> None:
    cant = [0.3 * side * (-1) ** k for k in range(6)]
    path = frame(tmp_path / "made.urdf", flat(30, 90, 150, 210, 270, 330), cant=cant)
    description = check_robot_file(path).description
    robot = Robot(description)
    wrench = robot.wrench_function(np.zeros(0), np.zeros(0)).full()
    poses = robot.link_poses(np.zeros(0), np.zeros(0))
    for rotor, column in zip(description.rotors, wrench.T, strict=True):
        drag = rotor.drag_torque_coefficient * poses[rotor.link][1][2, 2]
        assert drag * (column[5] - drag) > 0.0
    assert "so that its drag turns the robot as its canted thrust does" in doubts(path)


def test_names_that_say_it_come_first(tmp_path: Path) -> None:
    names = ["rotor_cw_1", "prop_ccw_2", "rotor_cw_3", "motor_CCW_4"]
    path = frame(tmp_path / "made.urdf", flat(45, -135, -45, 135), names=names)
    assert spins(path) == [CW, CCW, CW, CCW]
    assert "as their names say" in doubts(path)


def test_rotors_that_no_frame_has_turn_by_turns(tmp_path: Path) -> None:
    path = frame(tmp_path / "made.urdf", flat(0, 72, 144, 216, 288))
    assert spins(path) == [CCW, CW, CCW, CW, CCW]
    assert "are taken to turn one way and the other in turn" in doubts(path)


@pytest.mark.parametrize("rate", ["-0.0172", "0.0172"])
def test_what_an_import_writes_is_what_an_import_with_it_reads(tmp_path: Path, rate: str) -> None:
    path = tmp_path / "quad.urdf"
    path.write_text(lab_urdf().replace("-0.0172", rate))
    first = check_robot_file(path)
    assert [rotor.spin for rotor in first.description.rotors] == [
        sign if rate.startswith("-") else -sign for sign in (1, -1, 1, -1)
    ]
    assert first.flight is not None
    (tmp_path / "mapping.toml").write_text(mapping_text(first.flight, first.roles))
    again = check_robot_file(path, mapping=tmp_path / "mapping.toml")
    assert again.flight == first.flight


def test_spins_that_are_said_are_believed_though_all_are_one(tmp_path: Path) -> None:
    path = frame(tmp_path / "made.urdf", flat(45, -135, -45, 135))
    mapping = tmp_path / "mapping.toml"
    mapping.write_text("".join(f'[[rotors]]\nlink = "rotor{k}"\nspin = 1\n' for k in range(1, 5)))
    assert spins(path, mapping=mapping) == [1, 1, 1, 1]
    assert not check_robot_file(path, mapping=mapping).can_hover
