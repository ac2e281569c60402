"""Files as others have them: arguments of a xacro, tags of simulators, shapes that are none."""

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lab_style import MOVING, lab_urdf
from made_robots import link
from skylimb.apps.cli import main
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.apps.robot_import.writing import import_robot
from skylimb.base.errors import ConfigError, DescriptionError
from skylimb.control.planning.posture import posture_family
from skylimb.robots import load_robot
from skylimb.robots.model import Robot

# Pinocchio fills its module at run time, where a type checker cannot look.
pin: Any = import_module("pinocchio")

PLUGIN = """<gazebo><plugin name="motor{k}" filename="librotors_gazebo_motor_model.so">
<jointName>spin_{name}</jointName><linkName>{name}</linkName><turningDirection>{way}</turningDirection>
<timeConstantUp>0.0125</timeConstantUp><timeConstantDown>0.025</timeConstantDown>
<maxRotVelocity>838</maxRotVelocity><motorConstant>8.54858e-06</motorConstant>
<momentConstant>{moment}</momentConstant><motorNumber>{k}</motorNumber></plugin></gazebo>
"""
PLACES = {"a": (0.2, 0.2), "b": (-0.2, -0.2), "c": (0.2, -0.2), "d": (-0.2, 0.2)}


def gazebo_quad(moment: object = 0.016) -> str:
    """A quadrotor whose rotors no name tells, with the motors of RotorS and PX4, in another order."""
    parts = [link("base", 1.2, gyration=0.1)]
    for k, (name, (x, y)) in enumerate(PLACES.items()):
        parts.append(link(name, 0.02, gyration=0.03))
        limit = 'lower="-1e16" upper="1e16" effort="10" velocity="100"'
        given = {"kind": "revolute", "parent": "base", "child": name, "axis": "0 0 1", "limit": limit}
        parts.append(MOVING.format(name=f"spin_{name}", xyz=f"{x} {y} 0", **given))
        parts.append(PLUGIN.format(k=3 - k, name=name, way="ccw" if x * y > 0 else "cw", moment=moment))
    return f'<robot name="gazebo quad">{"".join(parts)}</robot>'


def test_motor_plugins_say_all_of_the_rotors(tmp_path: Path) -> None:
    (tmp_path / "quad.urdf").write_text(gazebo_quad())
    report = check_robot_file(tmp_path / "quad.urdf")
    assert report.can_hover, report.reasons
    rotors = report.description.rotors
    assert [rotor.link for rotor in rotors] == ["d", "c", "b", "a"]
    assert [rotor.spin for rotor in rotors] == [-1, -1, 1, 1]
    for rotor in rotors:
        assert rotor.thrust_max == pytest.approx(8.54858e-06 * 838**2, rel=1e-5)
        assert (rotor.thrust_factor, rotor.lag) == (8.54858e-06, 0.025)
        assert abs(rotor.drag_torque_coefficient) == 0.016
    said = {doubt.what for doubt in report.doubts}
    assert not said & {"drag torque per thrust", "greatest thrust", "lag of the rotors", "spin of the rotors"}


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_joint_whose_limits_leave_no_way_is_fixed_there(tmp_path: Path, kind: str) -> None:
    limits = {"kind": kind, "axis": "0 0 1", "limit": 'lower="0.2" upper="0.2" effort="1" velocity="1"'}
    mast = link("mast", 0.1, gyration=0.1) + MOVING.format(
        name="lift", xyz="0.3 0 0", parent="base", child="mast", **limits
    )
    path = tmp_path / "quad.urdf"
    path.write_text(gazebo_quad().replace("</robot>", f"{mast}</robot>"))
    report = check_robot_file(path)
    assert report.can_hover, report.reasons
    joint = report.description.joint("lift")
    assert joint.kind == "fixed"
    if kind == "prismatic":
        np.testing.assert_allclose(joint.xyz, [0.3, 0.0, 0.2], atol=1e-12)
    else:
        assert joint.R[1, 0] == pytest.approx(np.sin(0.2))


def test_a_motor_faster_than_numbers_reach_is_refused_in_a_line(tmp_path: Path) -> None:
    (tmp_path / "quad.urdf").write_text(gazebo_quad().replace(">838<", ">1e300<"))
    with pytest.raises(ConfigError, match="the motor plugin of link 'a': thrust_max = inf N"):
        check_robot_file(tmp_path / "quad.urdf")


@pytest.mark.parametrize("moment", ["nan", "-1", "1e9", "", "many"])
def test_a_plugin_with_a_number_that_is_none_is_proposed_or_refused_in_a_line(
    tmp_path: Path, moment: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "quad.urdf").write_text(gazebo_quad(moment))
    code = main(["robot", "check", str(tmp_path / "quad.urdf")])
    shown = capsys.readouterr()
    assert code == 2 if moment == "1e9" else code == 0
    assert "the motor plugin of link" in shown.err if code else "drag torque per thrust" in shown.out


XACRO = """<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">{arg}
{inside}</robot>"""


def test_arguments_of_a_xacro(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    inside = lab_urdf().partition('"lab quad">')[2].removesuffix("</robot>\n")
    inside = inside.replace('<mass value="1.0"/>', '<mass value="$(arg mass)"/>')
    path = tmp_path / "quad.urdf.xacro"
    path.write_text(XACRO.format(arg='<xacro:arg name="mass" default="1.0"/>', inside=inside))
    usual, heavy = check_robot_file(path), check_robot_file(path, args={"mass": "1.5"})
    assert heavy.mass - usual.mass == pytest.approx(0.5)
    with pytest.raises(DescriptionError, match="it has no argument 'mas', only mass"):
        check_robot_file(path, args={"mas": "1.5"})
    path.write_text(XACRO.format(arg="", inside=inside))
    assert main(["robot", "check", str(path)]) == 2
    assert "say --args mass=VALUE" in capsys.readouterr().err
    assert main(["robot", "check", str(path), "--args", "mass=1.5"]) == 0
    assert main(["robot", "check", str(path), "--args", "mass"]) == 2
    assert "must be NAME=VALUE" in capsys.readouterr().err
    (tmp_path / "quad.urdf").write_text(lab_urdf())
    with pytest.raises(DescriptionError, match=r"is no xacro file and takes no arguments \(mass\)"):
        check_robot_file(tmp_path / "quad.urdf", args={"mass": "1"})


@pytest.mark.parametrize("kind", ["visual", "collision"])
def test_a_shape_that_is_none_is_named_with_its_link(tmp_path: Path, kind: str) -> None:
    shape = f'<{kind}><geometry><box size="0.2 -0.1 0.1"/></geometry></{kind}>'
    text = lab_urdf().replace('<link name="battery">', f'<link name="battery">{shape}')
    (tmp_path / "quad.urdf").write_text(text)
    with pytest.raises(DescriptionError, match=r"link 'battery' .* box of 0.2, -0.1, 0.1 m"):
        check_robot_file(tmp_path / "quad.urdf")


def test_a_root_called_world_is_the_engines_and_no_link(tmp_path: Path) -> None:
    """Simulators hang a robot into a link of that name; the engine has its own."""
    text = gazebo_quad().replace(
        '<link name="base">', '<link name="world"/><link name="odom"/><link name="base">'
    )
    for name, parent, child in (("hung", "world", "odom"), ("held", "odom", "base")):
        fixed = f'<joint name="{name}" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'
        text = text.replace("</robot>", fixed + "</robot>")
    (tmp_path / "quad.urdf").write_text(text)
    report = check_robot_file(tmp_path / "quad.urdf")
    assert report.can_hover, report.reasons
    assert report.description.root == "base"
    assert "world" not in {link.name for link in report.description.links}
    assert report.mass == pytest.approx(report.mass_in, abs=1e-12)


def test_joints_that_slide_or_mimic_are_held_and_said(tmp_path: Path) -> None:
    slide = MOVING.format(
        name="slide", kind="prismatic", parent="main", child="rail", xyz="0 0 0.1", axis="0 0 1",
        limit='lower="0" upper="1" effort="1" velocity="1"',
    )  # fmt: skip
    mimic = slide.replace("slide", "finger").replace("rail", "pad")
    mimic = mimic.replace("</joint>", '<mimic joint="slide"/></joint>')
    extra = link("rail", 0.02) + link("pad", 0.02) + slide + mimic
    (tmp_path / "quad.urdf").write_text(lab_urdf(extra=extra))
    report = check_robot_file(tmp_path / "quad.urdf")
    assert report.can_hover, report.reasons
    said = {doubt.what: doubt.value for doubt in report.doubts}
    assert "locked" in said["joint 'slide'"]
    assert "mimics another; it is locked" in said["joint 'finger'"]


@pytest.mark.parametrize(("lower", "expected"), [(0.0, 0.1), (0.2, 0.5)])
def test_who_mimics_a_joint_that_cannot_be_at_zero_is_held_where_that_puts_it(
    tmp_path: Path, lower: float, expected: float
) -> None:
    slide = MOVING.format(
        name="slide", kind="prismatic", parent="main", child="rail", xyz="0 0 0.1", axis="0 0 1",
        limit=f'lower="{lower}" upper="1" effort="1" velocity="1"',
    )  # fmt: skip
    free = slide.replace("slide", "finger").replace("rail", "pad").replace(f'lower="{lower}"', 'lower="-1"')
    mimic = free.replace("</joint>", '<mimic joint="slide" multiplier="2" offset="0.1"/></joint>')
    # The one that mimics stands first: its master is not held yet.
    (tmp_path / "quad.urdf").write_text(
        lab_urdf(extra=link("rail", 0.02) + link("pad", 0.02) + mimic + slide)
    )
    joints = check_robot_file(tmp_path / "quad.urdf").description
    assert joints.joint("finger").xyz[2] == pytest.approx(0.1 + expected)
    assert joints.joint("slide").xyz[2] == pytest.approx(0.1 + lower)


ARM = (
    ("shoulder", "base", "upper", "0.1 0 -0.05", "0 1.5708 0"),
    ("elbow", "upper", "fore", "0.25 0 0", "0 0 0"),
    ("mount", "fore", "tool", "0.2 0 0", "0 0 0"),
)
STICK = '<visual><origin xyz="{x} 0 0" rpy="0 1.5708 0"/><geometry>{shape}</geometry></visual>'
ROD = '<cylinder radius="0.005" length="0.2"/>'
NEW_TIP = '[tip]\nlink = "tool"\nposition = [0.2, 0.0, 0.0]\nradius = 0.01\n'


def with_arm(drawn: str) -> str:
    """The quadrotor above with an arm of fixed links that hangs down, its tool drawn."""
    parts = [link(name, 0.05, gyration=0.02) for name in ("upper", "fore")]
    parts.append(link("tool", 0.02, gyration=0.02).replace("</link>", f"{drawn}</link>"))
    for name, parent, child, xyz, rpy in ARM:
        parts.append(
            f'<joint name="{name}" type="fixed"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{xyz}" rpy="{rpy}"/></joint>'
        )
    return gazebo_quad().replace("</robot>", "".join(parts) + "</robot>")


@pytest.mark.parametrize(
    ("drawn", "depth", "radius"),
    [
        ("", 0.5, 0.01),
        (STICK.format(x=0.1, shape=ROD), 0.7, 0.01),
        (STICK.format(x=0.1, shape='<box size="0.01 0.01 0.2"/>'), 0.7, 0.01),
        (STICK.format(x=0.1, shape=ROD) + STICK.format(x=0.2, shape='<sphere radius="0.015"/>'), 0.7, 0.015),
    ],
)
def test_the_tip_is_the_farthest_end_of_tree_and_drawing(
    tmp_path: Path, drawn: str, depth: float, radius: float
) -> None:
    (tmp_path / "arm.urdf").write_text(with_arm(drawn))
    report = check_robot_file(tmp_path / "arm.urdf")
    tip = report.description.tip
    assert (tip.link, tip.radius) == ("base", radius)
    assert tip.position == pytest.approx([0.1, 0.0, -depth], abs=1e-4)
    assert report.can_touch
    assert any("the farthest end that is drawn" in doubt.value for doubt in report.doubts)


@pytest.mark.usefixtures("no_picture")
def test_a_tool_that_points_down_gives_no_heading_and_the_root_does(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(with_arm(""))
    (tmp_path / "mapping.toml").write_text(NEW_TIP + 'heading = "tool"\n')
    report = check_robot_file(tmp_path / "arm.urdf", mapping=tmp_path / "mapping.toml")
    assert "points down in the nominal posture, so its x axis gives no heading" in report.reasons[0].value
    (tmp_path / "mapping.toml").write_text(NEW_TIP)
    report = import_robot(tmp_path / "arm.urdf", tmp_path / "robot", mapping=tmp_path / "mapping.toml")
    assert report.can_touch, report.reasons
    robot = load_robot(tmp_path / "robot")
    state = robot.at([], [])
    assert float(state.tip_heading) == 0.0
    assert state.tip_root == pytest.approx([0.1, 0.0, -0.7], abs=1e-4)
    # Measured forward of the centre of gravity, which is under the base's middle, and not behind it.
    assert posture_family(robot).reach_nominal == pytest.approx(0.1 - float(state.cog_root[0]), abs=1e-4)


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_joint_that_cannot_be_at_zero_is_held_within_its_limits(tmp_path: Path, kind: str) -> None:
    """The centre of gravity is Pinocchio's, at the limit that is nearest to zero."""
    limit = 'lower="0.4" upper="1" effort="1" velocity="1"'
    joint = MOVING.format(
        name="lid", kind=kind, parent="main", child="cover", xyz="0.1 0 0.1", axis="0 0.6 0.8", limit=limit
    )
    text = lab_urdf(extra=link("cover", 0.1, com="0.1 0.02 0.03", gyration=0.02) + joint)
    path = tmp_path / "quad.urdf"
    path.write_text(text)
    report = check_robot_file(path)
    assert any("held at 0.4" in doubt.value for doubt in report.doubts)
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    q = pin.neutral(model)
    q[model.joints[model.getJointId("lid")].idx_q] = 0.4
    data = model.createData()
    cog = np.ravel(pin.centerOfMass(model, data, q))
    pin.framesForwardKinematics(model, data, q)
    place = data.oMf[model.getFrameId("main")]
    found = Robot(report.description).at(np.zeros(0), np.zeros(4)).cog_root
    np.testing.assert_allclose(np.ravel(found), place.actInv(cog), atol=1e-12)


def test_equal_doubts_are_one_that_names_what_it_is_about(tmp_path: Path) -> None:
    limit = 'lower="-1" upper="1" effort="1" velocity="1"'
    extra = "".join(
        link(f"tip{k}", 0.001)
        + MOVING.format(
            name=f"finger{k}",
            kind="revolute",
            parent="main",
            child=f"tip{k}",
            xyz="0 0 0",
            axis="0 0 1",
            limit=limit,
        )
        for k in range(20)
    )
    (tmp_path / "quad.urdf").write_text(lab_urdf(extra=extra))
    doubts = check_robot_file(tmp_path / "quad.urdf").doubts
    (found,) = [doubt for doubt in doubts if "finger0" in doubt.what]
    assert found.what == "joint 'finger0' and 19 more, each"
    assert "taken as locked" in found.value


def test_each_servo_has_the_limits_of_its_joint_and_assumed_gains_are_said(tmp_path: Path) -> None:
    extra = "".join(
        link(f"a{k}", 0.05, gyration=0.02)
        + MOVING.format(
            name=f"joint{k}", kind="revolute", parent=f"a{k - 1}" if k > 1 else "main", child=f"a{k}",
            xyz="0.1 0 0", axis="0 1 0", limit=f'lower="-1" upper="1" effort="{5 - k}" velocity="2"',
        )
        for k in (1, 2, 3)
    )  # fmt: skip
    (tmp_path / "quad.urdf").write_text(lab_urdf(extra=extra))
    report = check_robot_file(tmp_path / "quad.urdf")
    said = {doubt.what: doubt.value for doubt in report.doubts}
    assert "50 N m/rad and 2 N m s/rad are assumed" in said["gains of the servos of joints"]
    servos = report.description.shape_servos
    np.testing.assert_array_equal(servos.torque_limit, [4.0, 3.0, 2.0])
    for numbers, alike in ((servos.stiffness, 50.0), (servos.damping, 2.0), (servos.speed_limit, 2.0)):
        np.testing.assert_array_equal(numbers, alike)
