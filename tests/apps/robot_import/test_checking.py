"""What a check says of descriptions in the laboratory's style, of broken ones, and of robots that ship."""

from importlib import import_module
from typing import Any

import numpy as np
import pytest

from armed_robots import multirotor_with_arm
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.apps.robot_import.repairs import nearest_inertia
from skylimb.apps.robot_import.report import report_text, verdict
from skylimb.base.errors import SkylimbError
from skylimb.robots import hover
from skylimb.robots.links import Inertial
from skylimb.robots.validation import check_inertial

# Pinocchio fills its module at run time, where a type checker cannot look.
pin: Any = import_module("pinocchio")


def doubt_about(report, what):
    found = [doubt for doubt in report.doubts if what in doubt.what]
    assert len(found) == 1, [str(doubt) for doubt in report.doubts]
    return found[0]


def test_the_laboratorys_names_are_recognised(lab_file):
    report = check_robot_file(lab_file())
    assert report.can_hover, report.reasons
    d = report.description
    assert d.vectoring_joints == ("gimbal1", "gimbal2", "gimbal3", "gimbal4")
    assert [rotor.link for rotor in d.rotors] == ["thrust1", "thrust2", "thrust3", "thrust4"]
    assert [rotor.spin for rotor in d.rotors] == [1, -1, 1, -1]
    assert [(rotor.thrust_min, rotor.thrust_max) for rotor in d.rotors] == [(0.5, 12.0)] * 4
    assert [rotor.drag_torque_coefficient for rotor in d.rotors] == [-0.0172, 0.0172, -0.0172, 0.0172]
    assert d.root == d.measured_link == "main"
    assert {*d.vectoring_servos.torque_limit, *d.vectoring_servos.speed_limit} == {3.0, 8.0}
    assert report.actuation is not None
    assert report.actuation.rank == 4
    assert report.actuation.rank_moving == 6
    assert "fully actuated when its vectoring angles move" in report_text(report)
    assert report_text(report).endswith("lab quad can hover and can touch.")


def test_a_tip_that_hangs_below_touches_no_wall_and_the_verdict_says_so(lab_file, tmp_path):
    mapping = tmp_path / "mapping.toml"
    mapping.write_text('[tip]\nlink = "main"\nposition = [0.0, 0.0, -0.4]\nradius = 0.004\n')
    report = check_robot_file(lab_file(), mapping=mapping)
    assert report.can_touch
    assert "can hover and can touch, but no wall ahead: 'rotor2'" in report_text(report).splitlines()[-1]
    assert report_text(report).endswith("m before the tip along (1.00, 0.00, 0.00)")


@pytest.mark.parametrize(
    ("robot", "said"), [({"mass": 40.0}, "but its rotors lift at most"), ({"rotors": 3}, "has 3 rotors")]
)
def test_no_posture_is_sought_for_a_robot_that_none_helps(tmp_path, monkeypatch, robot, said):
    """Where rotors turn on the links it takes half a minute to say that none hovers."""
    sought = []
    monkeypatch.setattr("skylimb.apps.robot_import.checking.choose_posture", sought.append)
    report = check_robot_file(multirotor_with_arm(tmp_path / "arm.urdf", **robot))
    assert said in str(report.reasons)
    assert sought == []


def test_mass_in_is_mass_out_and_pinocchios(lab_file):
    path = lab_file()
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    report = check_robot_file(path)
    expected = pin.computeTotalMass(model)
    assert report.mass_in == pytest.approx(expected, abs=1e-9)
    assert report.mass == pytest.approx(expected, abs=1e-9)
    assert report.collisions is not None
    assert report.collisions.mass == pytest.approx(expected, abs=1e-9)


def test_planting_another_root_moves_no_link(lab_file):
    """The centre of gravity in the new root's frame is Pinocchio's, whose root is the dummy above it."""
    path = lab_file()
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    data = model.createData()
    cog = pin.centerOfMass(model, data, pin.neutral(model))
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    main = data.oMf[model.getFrameId("main")]
    from skylimb.robots import Robot

    robot = Robot(check_robot_file(path).description)
    state_cog = robot.model(np.zeros(0), np.zeros(4)).cog_root
    np.testing.assert_allclose(np.ravel(np.array(state_cog)), main.actInv(cog), atol=1e-9)


def test_the_mass_that_a_welded_root_drops_is_told(lab_file):
    said = doubt_about(check_robot_file(lab_file()), "root link 'root'")
    assert "drops 1.300 kg, 87%" in said.value


def test_impossible_inertias_are_faults_and_mend_replaces_them(lab_file):
    broken = ('ixx="0.010000000000000002"', 'ixx="-0.01"')
    report = check_robot_file(lab_file(broken))
    assert not report.can_hover
    fault = doubt_about(report, "inertia of link 'main'")
    assert fault.fatal
    assert "is not positive definite: principal moments -0.01" in fault.value
    assert "--mend" in fault.remedy
    assert "cannot hover: inertia of link 'main'" in verdict(report)
    mended = check_robot_file(lab_file(broken), mend=True)
    assert mended.can_hover
    assert "mended to" in doubt_about(mended, "inertia of link 'main'").value


def test_a_point_mass_is_mended_to_a_ball_that_the_engine_takes(lab_file):
    ball = '<inertia ixx="0.00027" iyy="0.00027" izz="0.00027" ixy="0" ixz="0" iyz="0"/>'
    point = ball.replace("0.00027", "0.0")
    report = check_robot_file(lab_file((ball, point)), mend=True)
    assert report.can_hover, report.reasons
    inertia = report.description.link("battery").inertial.inertia
    np.testing.assert_allclose(inertia, 0.3 * 0.01**2 * np.eye(3))


def test_dust_far_from_its_centre_is_a_doubt(lab_file):
    report = check_robot_file(lab_file(dust=1e-3))
    assert report.can_hover
    said = doubt_about(report, "link 'thrust1'")
    assert said.what == "link 'thrust1' and 'thrust2', 'thrust3', 'thrust4', each"


def test_the_nearest_inertia_is_possible_and_leaves_a_possible_one():
    rng = np.random.default_rng(5)
    for _ in range(20):
        A = rng.normal(size=(3, 3))
        mended = nearest_inertia(A + A.T)
        check_inertial("x", Inertial(100.0, np.zeros(3), mended))
        np.testing.assert_allclose(nearest_inertia(mended), mended, atol=2e-3 * np.abs(mended).max())


LIMITS = '<limit lower="0" upper="1" effort="1" velocity="1"/>'
EXTRA = (
    '<link name="{0}_link"/><joint name="{0}" type="{1}"><parent link="main"/><child link="{0}_link"/>'
    '<axis xyz="0 1 0"/>' + LIMITS + "</joint></robot>"
)
PICTURE = '<link name="battery"><visual><geometry><mesh filename="package://a/b.dae"/></geometry></visual>'

CASES = {
    "no effort": (
        ('effort="3"', 'effort="-0.0156"'),
        "effort limit of joint 'gimbal1'",
        "-0.0156 N m; 3 N m",
    ),
    "unknown joint": (
        ("</robot>", EXTRA.format("zed_tilt", "revolute")),
        "joint 'zed_tilt'",
        "taken as locked, as it carries no rotor",
    ),
    "prismatic": (("</robot>", EXTRA.format("joint1", "prismatic")), "joint 'joint1'", "is prismatic"),
    "mesh": (('<link name="battery">', PICTURE), "mesh 'package://a/b.dae'", "is not there"),
    "strange names": (('name="gimbal1"', 'name="tilter_a"'), "joint 'tilter_a'", "taken as vectoring"),
    "no thrust": (
        ('lower="0.5" upper="12"', 'lower="-1e16" upper="1e16"'),
        "greatest thrust",
        "2 times the weight",
    ),
    "no drag": (('<m_f_rate value="-0.0172"/>', ""), "drag torque per thrust", "0.016 m is assumed"),
}


@pytest.mark.parametrize("name", CASES)
def test_each_doubt_by_name_with_its_value(lab_file, name):
    change, what, value = CASES[name]
    report = check_robot_file(lab_file(change))
    assert report.can_hover, report.reasons
    assert value in doubt_about(report, what).value


def test_three_rotors_load_and_cannot_hover(lab_file, tmp_path, monkeypatch):
    asked, searched = [], hover.hovers_and_margins
    monkeypatch.setattr(
        hover,
        "hovers_and_margins",
        lambda robot, q, psi, within: asked.append(within.tilt) or searched(robot, q, psi, within),
    )
    mapping = tmp_path / "mapping.toml"  # no posture that hovers is looked for in vain
    mapping.write_text(
        "[posture]\noffset = [0.0]\nslope = [1.0]\ntheta_min = -0.1\ntheta_max = 0.1\ntheta_nominal = 0.0\n"
    )
    path = lab_file(("rotor4", "spare"), ("thrust4", "spare_end"))
    report = check_robot_file(path, mapping=mapping)
    assert not report.can_hover
    assert "3 rotors" in verdict(report)
    assert asked == [hover.LEVEL, hover.TILTED]  # each once, though three parts of the check ask


def test_too_heavy_loads_and_cannot_hover(lab_file):
    report = check_robot_file(lab_file(('<mass value="1.0"/>', '<mass value="10"/>')))
    assert "weighs" in verdict(report)
    assert "rotors lift at most 48 N" in verdict(report)


UNREADABLE = {
    "empty": "",
    "half": '<robot name="a"><link name="b">',
    "no robot": "<html/>",
    "no links": '<robot name="a"/>',
    "no rotors": '<robot name="a"><link name="b"/></robot>',
    "entities": '<!DOCTYPE a [<!ENTITY b "c">]><robot name="a"/>',
    "a loop": '<robot name="a"><link name="b"/><link name="c"/>'
    '<joint name="x" type="fixed"><parent link="b"/><child link="c"/></joint>'
    '<joint name="y" type="fixed"><parent link="c"/><child link="b"/></joint></robot>',
    "no parent": '<robot name="a"><link name="b"/><joint name="x" type="fixed"><child link="b"/></joint>'
    "</robot>",
}


def test_a_part_without_links_is_told_from_a_loop(tmp_path):
    path = tmp_path / "bad.urdf"
    for name, words in (("no links", "has no links"), ("a loop", "joints form a loop")):
        path.write_text(UNREADABLE[name])
        with pytest.raises(SkylimbError, match=words):
            check_robot_file(path)


@pytest.mark.parametrize("name", UNREADABLE)
def test_what_cannot_be_read_is_refused_in_a_line(tmp_path, name):
    path = tmp_path / "bad.urdf"
    path.write_text(UNREADABLE[name])
    with pytest.raises(SkylimbError) as caught:
        check_robot_file(path)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_robot_that_ships_can_be_checked_by_name():
    report = check_robot_file("hydrus_xi_quad")
    assert report.can_hover
    assert report.actuation is not None
    assert report.actuation.hover is not None
    assert report.actuation.hover.margin is not None
    assert report.actuation.hover.margin > 0.2
    assert report.actuation.rank_moving == 6


def armed(tmp_path, *changes, **made):
    """A check of a quadrotor with an arm, some of whose text is another."""
    path = multirotor_with_arm(tmp_path / "made.urdf", **made)
    text = path.read_text()
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text)
    return check_robot_file(path)


def test_lengths_in_millimetres_are_named_by_their_joint(tmp_path):
    with pytest.raises(SkylimbError, match=r"joint 'tool0_fixed' puts link 'tool0' 250 m from .* 0.25 m$"):
        armed(tmp_path, ('<origin xyz="0.25 0.0', '<origin xyz="250 0.0'))


def test_limits_in_degrees_are_no_silent_lack_of_limits(tmp_path):
    report = armed(tmp_path, ('lower="-1.57" upper="1.57"', 'lower="-90" upper="90"'))
    assert "-90 .. 90 rad, more than a turn" in report_text(report)
    assert "write -1.571 .. 1.571" in report_text(report)
    none = armed(tmp_path, ('lower="-1.57" upper="1.57"', 'lower="-1e16" upper="1e16"'))
    assert "more than a turn" not in report_text(none)


def test_a_joint_that_slides_is_said_to(tmp_path):
    report = armed(tmp_path, ('name="elbow_pitch" type="revolute"', 'name="elbow_pitch" type="prismatic"'))
    assert "only joints that turn are simulated" in doubt_about(report, "'elbow_pitch'").value


def test_an_axis_that_is_left_out_is_said(tmp_path):
    report = armed(tmp_path, ('<axis xyz="0 1 0"/>', ""))
    assert "has no <axis>" in doubt_about(report, "'shoulder_pitch'").value
    assert any("do not move its tip ahead" in doubt.value for doubt in report.reasons)


def test_a_mass_below_zero_is_not_for_mend(tmp_path):
    report = armed(tmp_path, ('<mass value="1.6"/>', '<mass value="-1.6"/>'))
    assert report.reasons[0].what == "mass of link 'base_link'"
    assert "--mend" not in report.reasons[0].remedy


def test_grams_are_guessed_where_the_mass_is_a_thousandfold_only(tmp_path):
    assert "in grams" not in str(armed(tmp_path, thrust=2.0).reasons[0])
    assert "in grams" in str(armed(tmp_path, ('<mass value="1.6"/>', '<mass value="1600"/>')).reasons[0])


def test_one_fault_of_a_body_is_told_once(tmp_path):
    path = multirotor_with_arm(tmp_path / "made.urdf")
    head, name, rest = path.read_text().partition('<link name="elbow_link">')
    path.write_text(head + name + rest.partition("</inertial>")[2])
    report = check_robot_file(path)
    assert [doubt.what for doubt in report.reasons] == ["a moving body"]


def test_a_rotor_whose_frame_is_upside_down_is_said_to_push_down(tmp_path):
    report = armed(tmp_path, ('rpy="-0.0 0 0.785', 'rpy="3.14159 0 0.785'))
    assert not report.can_hover
    assert doubt_about(report, "rotor at link").what == "rotor at link 'propeller_0'"


def test_axles_along_x_that_point_both_ways_say_the_spins(tmp_path):
    """A URDF from CAD may turn every propeller about x of its link; thrust is up all the same."""
    report = armed(
        tmp_path,
        ('<axis xyz="0 0 1"/>', '<axis xyz="1 0 0"/>'),
        ('<axis xyz="0 0 -1"/>', '<axis xyz="-1 0 0"/>'),
        ('rpy="-0.0 0 ', 'rpy="0.0 0 '),
        ('rpy="0.0 0 ', 'rpy="0 -1.5707963 '),
    )
    assert report.can_hover, report.reasons
    assert [rotor.spin for rotor in report.description.rotors] == [-1, 1, -1, 1]
    assert not any(doubt.what == "spin of the rotors" for doubt in report.doubts)


def test_thin_discs_in_turned_frames_are_bodies(tmp_path):
    """A + B = C by the file's numbers; the engine refused a third of them for rounding."""
    i = 0.02 * 0.05**2
    old = f'<origin xyz="0 0 0"/><mass value="0.02"/><inertia ixx="{i}" iyy="{i}" izz="{1.5 * i}"'
    for roll in (0.3, 1.1, 3.14159):
        new = old.replace('xyz="0 0 0"', f'xyz="0 0 0" rpy="{roll} 0.7 0.1"').replace(
            f"{1.5 * i}", f"{2 * i}"
        )
        report = armed(tmp_path, (old, new))
        assert report.can_hover, report.reasons
