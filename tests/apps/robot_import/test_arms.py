"""Multirotors with arms, from a stranger's URDF to a line on a board without a word of mapping."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

import skylimb
from armed_robots import SIX, TWO, multirotor_with_arm
from skylimb.apps.robot_import.checking import RobotReport, check_robot_file
from skylimb.control.controller import resolved_tables
from skylimb.robots.controlled_axes import kind_of
from skylimb.robots.description import RobotDescription

DOWN = "0 1.5708 0"
"""A tool frame whose z axis points forward, as URDFs of arms have it."""


Armed = tuple[list[str], Path, RobotReport]
"""Names of an arm's joints, a URDF that has it, and what a check of it found."""


@pytest.fixture(scope="module", params=[TWO, SIX], ids=["two joints", "six joints"])
def armed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Armed:
    path = multirotor_with_arm(tmp_path_factory.mktemp("armed") / "made.urdf", joints=request.param)
    return [name for name, _, _ in request.param], path, check_robot_file(path)


def joints_of(description: RobotDescription) -> list[str]:
    return list(description.shape_joints)


def test_the_joints_of_an_arm_are_used_by_their_names(armed: Armed) -> None:
    names, _, report = armed
    assert joints_of(report.description) == names
    assert report.description.tip.link == "tool0"
    assert report.can_touch, report.reasons
    assert not any(doubt.what.startswith("joint '") for doubt in report.doubts)


def test_an_arm_without_names_is_known_by_its_chain_and_said_as_a_doubt(tmp_path: Path) -> None:
    plain = tuple((f"m{k}", axis, length) for k, (_, axis, length) in enumerate(TWO))
    report = check_robot_file(multirotor_with_arm(tmp_path / "made.urdf", joints=plain))
    assert joints_of(report.description) == ["m0", "m1"]
    assert any("it belongs to the longest arm" in doubt.value for doubt in report.doubts)


@pytest.mark.parametrize("name", ["camera_tilt", "gripper", "landing_gear"])
def test_what_moves_something_else_is_no_arm(tmp_path: Path, name: str) -> None:
    joints = ((name, "0 1 0", 0.1), (f"{name}_2", "0 1 0", 0.1))
    report = check_robot_file(multirotor_with_arm(tmp_path / "made.urdf", joints=joints))
    assert joints_of(report.description) == []


def test_the_tip_stands_before_every_disc_as_the_engine_places_them(armed: Armed) -> None:
    _, path, report = armed
    description = report.description
    text = path.read_text().replace('type="continuous"', 'type="fixed"')
    tree = mujoco.MjSpec.from_string(text)
    tree.compiler.fusestatic = False
    tree.compiler.discardvisual = False
    model = tree.compile()
    data = mujoco.MjData(model)
    posture = description.posture
    for name, angle in zip(description.shape_joints, posture.offset, strict=True):
        data.joint(name).qpos[0] = angle
        assert abs(angle) < 1.57 - 0.1
    mujoco.mj_kinematics(model, data)
    x, y, _ = data.body("tool0").xpos
    for k in range(4):
        assert x > data.body(f"propeller_{k}").xpos[0] + 0.12 + 0.05
    assert abs(y) < 0.02


def test_where_a_tools_axes_point_changes_nothing(tmp_path: Path) -> None:
    forward = check_robot_file(multirotor_with_arm(tmp_path / "a.urdf"))
    turned = check_robot_file(multirotor_with_arm(tmp_path / "b.urdf", tool=DOWN))
    assert turned.can_touch
    assert turned.description.tip.heading == "root"
    np.testing.assert_allclose(turned.description.posture.offset, forward.description.posture.offset)
    assert turned.actuation is not None
    assert forward.actuation is not None
    assert turned.actuation.touch.room == pytest.approx(forward.actuation.touch.room, abs=1e-6)


@pytest.mark.parametrize(
    ("given", "force"),
    [
        ({"joints": TWO, "tool": DOWN}, 0.7),  # its yaw holds no more
        ({"joints": TWO[:1], "stick": 0.2}, 0.7),
        ({"joints": SIX, "rotors": 6, "place": 0.32, "mass": 2.2}, 1.0),
        ({"joints": (), "rotors": 6, "cant": 0.3, "place": 0.32, "stick": 0.4}, 1.0),
        pytest.param(
            {"joints": SIX, "rotors": 8, "cant": 0.3, "place": 0.36, "mass": 3.0, "radius": 0.1},
            1.0,
            marks=pytest.mark.slow,
        ),
        ({"joints": (), "stick": 0.45, "turning": 1.5}, 1.0),
    ],
    ids=[
        "quadrotor with two joints",
        "quadrotor with one joint",
        "hexarotor with six joints",
        "tilted hexarotor with a stick",
        "tilted octorotor with six joints",
        "quadrotor whose arms turn",
    ],
)
@pytest.mark.usefixtures("no_picture")
def test_it_draws_a_circle_within_8_mm(tmp_path: Path, given: dict, force: float) -> None:
    path = multirotor_with_arm(tmp_path / "made.urdf", **given)
    skylimb.import_robot(path, tmp_path / "robot")
    keys = {"robot": str(tmp_path / "robot"), "controller.translation.force": force}
    run = skylimb.run("board_tilted_hexarotor", "following", set=keys)
    assert run.metrics["done"], run.metrics["missed"]
    assert run.metrics["pen_line_rms"] < 0.008
    assert run.metrics["contact_fraction"] > 0.99


POSTURE = """[posture]
offset = [1.2, 0.0]
slope = [0.0, 0.6]
theta_min = 0.3
theta_max = 1.0
theta_nominal = 0.6
"""


@pytest.mark.parametrize(
    ("given", "posture"),
    [
        ({"joints": (), "stick": 0.45, "mount": "0 0 0", "turned": DOWN}, ""),
        ({"joints": TWO}, POSTURE),
        ({"joints": TWO, "rotors": 6, "place": 0.32, "mass": 2.2}, POSTURE),
    ],
    ids=["stick", "two joints", "two joints under a hexarotor"],
)
@pytest.mark.usefixtures("no_picture")
def test_with_its_tool_down_it_draws_a_circle_on_the_floor(tmp_path: Path, given: dict, posture: str) -> None:
    (tmp_path / "mapping.toml").write_text(posture)
    path = multirotor_with_arm(tmp_path / "made.urdf", **given)
    skylimb.import_robot(path, tmp_path / "robot", mapping=tmp_path / "mapping.toml")
    floor = {"contact_axis": [0.0, 0.0, -1.0], "surface.position": [0.6, 0.0, 0.5]}
    run = skylimb.run("board_tilted_hexarotor", "following", set={"robot": str(tmp_path / "robot"), **floor})
    assert run.metrics["done"], run.metrics["missed"]
    assert run.metrics["pen_line_rms"] < 0.008
    assert run.metrics["contact_fraction"] > 0.99


def test_a_bare_frame_that_is_called_a_tool_is_the_tip_of_a_stick_that_is_short(tmp_path: Path) -> None:
    given: dict = {"joints": (), "stick": 0.25, "mount": "0 0 0", "turned": DOWN}
    report = check_robot_file(multirotor_with_arm(tmp_path / "made.urdf", **given))
    assert report.description.tip.link == "tool0"
    assert report.actuation is not None
    np.testing.assert_allclose(report.actuation.touch.direction, [0.0, 0.0, -1.0], atol=1e-6)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("hydrus_quad", "chain"),
        ("tilted_hexarotor", "pushing"),
        ("hydrus_xi_quad", "vectoring"),
        ("tiltable_hexarotor", "tilting"),
    ],
)
def test_the_kind_of_a_robot(name: str, kind: str) -> None:
    assert kind_of(skylimb.load_robot(name)) == kind


def test_a_preset_knows_robots_of_a_kind_that_it_does_not_name() -> None:
    robot = skylimb.load_robot("tilted_hexarotor")
    other = type(robot)(replace(robot.description, name="a stranger"))
    own, its = (skylimb.load_controller("following", one) for one in (robot, other))
    assert resolved_tables(own)["attitude"] == resolved_tables(its)["attitude"]


def test_an_arm_whose_limits_leave_out_zero_stands_within_them(tmp_path: Path) -> None:
    """The search begins where the joints can be: such a robot was refused for its own proposal."""
    path = multirotor_with_arm(tmp_path / "made.urdf")
    elbow = path.read_text().replace('lower="-1.57"', 'lower="0.5"').rpartition('lower="0.5"')
    path.write_text(path.read_text().rpartition('lower="-1.57"')[0] + 'lower="0.5"' + elbow[2])
    report = check_robot_file(path)
    assert report.can_touch, report.reasons
    assert report.description.joint("elbow_pitch").lower == 0.5
    assert report.description.posture.nominal[1] > 0.5


def test_a_pen_that_is_drawn_ends_where_it_is_drawn(tmp_path: Path) -> None:
    """The tip was taken at the pen's frame, at its joint, behind the pen's own end, and could not touch."""
    path = multirotor_with_arm(tmp_path / "made.urdf", joints=(*TWO, ("wrist_pitch", "0 1 0", 0.05)))
    text = path.read_text().replace("wrist_link", "pen").replace('size="0.05 ', 'size="0.2 ')
    text = text.replace('<origin xyz="0.025 0 0"/><geometry>', '<origin xyz="0.1 0 0"/><geometry>')
    path.write_text(text.partition('<link name="tool0">')[0] + "</robot>\n")
    report = check_robot_file(path)
    tip = report.description.tip
    assert (tip.link, tip.position.tolist()) == ("pen", [0.2, 0.0, 0.0])
    assert report.can_touch
