"""Where robots come from, and what is refused: messages name the thing, its value and what was allowed."""

import json

import mujoco
import numpy as np
import pytest

from skylimb.base.errors import AllocationError, ConfigError, DescriptionError, SkylimbError, UnknownNameError
from skylimb.robots import list_robots, load_robot, read_description
from skylimb.studies.planning.feasible_wrench import push_limit


def refused(path, error, *parts):
    with pytest.raises(error) as caught:
        load_robot(path)
    message = str(caught.value)
    assert "\n" not in message
    for part in parts:
        assert part in message, message


def test_robots_are_listed_with_a_line_each():
    robots = list_robots()
    assert "hydrus_xi_quad" in robots
    assert all(summary and "\n" not in summary for summary in robots.values())


def test_a_users_own_pair_loads_by_folder_and_by_file(shipped_folder):
    by_folder, by_file = load_robot(shipped_folder), load_robot(shipped_folder / "flight.toml")
    assert by_folder.mass == by_file.mass == load_robot("hydrus_xi_quad").mass
    assert by_folder.description.digest == load_robot("hydrus_xi_quad").description.digest


def test_the_digest_follows_the_content_not_the_line_ends(shipped_folder):
    before = read_description(shipped_folder).digest
    urdf = shipped_folder / "hydrus_xi_quad.urdf"
    text = urdf.read_bytes()
    urdf.write_bytes(text.replace(b"\n", b"\r\n"))
    assert read_description(shipped_folder).digest == before
    urdf.write_bytes(text.replace(b'value="0.193"', b'value="0.194"', 1))
    assert read_description(shipped_folder).digest != before


def test_a_changed_file_is_read_again(spoil):
    first = load_robot(spoil()).mass
    second = load_robot(spoil(urdf=('<mass value="0.030"/>', '<mass value="0.040"/>'))).mass
    assert second - first == pytest.approx(0.010)


def test_the_description_says_what_the_files_say():
    d = load_robot("hydrus_xi_quad").description
    assert d.root == d.measured_link == "link1"
    assert [rotor.spin for rotor in d.rotors] == [1, -1, 1, -1]
    assert [rotor.drag_torque_coefficient for rotor in d.rotors] == [-0.0182, 0.0182, -0.0182, 0.0182]
    joint = d.joint("joint2")
    assert (joint.lower, joint.upper, joint.effort, joint.speed) == (-1.57, 1.57, 3.3, 0.5)
    assert (joint.damping, joint.friction) == (0.8, 0.05)
    np.testing.assert_array_equal(d.joint("gimbal_joint1").R, np.diag([-1.0, -1.0, 1.0]))
    assert d.joint("gimbal_joint1").kind == "continuous"
    assert np.isinf(d.joint("gimbal_joint1").upper)
    shapes = {visual.shape for link in d.links for visual in link.visuals}
    assert shapes == {"box", "cylinder", "sphere"}


def test_a_servo_may_be_weaker_than_its_neighbours(spoil):
    robot = load_robot(spoil(toml=("torque_limit = 3.3", "torque_limit = [3.3, 2.5, 3.3]")))
    np.testing.assert_array_equal(robot.description.shape_servos.torque_limit, [3.3, 2.5, 3.3])
    found = push_limit(robot, np.array([1.0, 0.0, 0.0]))
    assert found
    assert found.limit is not None
    assert (found.limit.kind, found.limit.name, found.limit.value) == ("servo", "joint2", 2.5)


def test_a_description_cannot_be_changed_by_accident():
    d = load_robot("hydrus_xi_quad").description
    for array in (
        d.posture.offset,
        d.link("link1").inertial.com,
        d.joint("joint1").xyz,
        d.rotors[0].R,
        d.tip.position,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_mujoco_reads_the_urdf_and_drops_the_mass_that_we_keep():
    robot = load_robot("hydrus_xi_quad")
    model = mujoco.MjModel.from_xml_path(str(robot.description.folder / "hydrus_xi_quad.urdf"))
    assert model.nq == 7
    assert robot.mass - np.sum(model.body_mass) == pytest.approx(0.648, abs=5e-4)


def test_unknown_names():
    refused(
        "hydrus_xi_squad",
        UnknownNameError,
        "unknown robot 'hydrus_xi_squad'",
        "did you mean 'hydrus_xi_quad'",
    )
    refused("", SkylimbError)


def test_missing_and_unreadable_files(tmp_path, spoil):
    refused(tmp_path / "none.toml", ConfigError, "none.toml")
    refused(tmp_path / "robot.urdf", ConfigError, "name the flight TOML")
    refused(tmp_path, DescriptionError, "has no flight.toml")
    path = spoil(toml=('urdf = "hydrus_xi_quad.urdf"', 'urdf = "hydrus_xi_squad.urdf"'))
    refused(path, DescriptionError, "no such file", "did you mean '", "hydrus_xi_quad.urdf'")
    path = spoil()
    (path.parent / "hydrus_xi_quad.urdf").unlink()
    (path.parent / "hydrus_xi_quad.urdf").mkdir()
    refused(path, DescriptionError, "cannot read", "hydrus_xi_quad.urdf")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<robot",
        "<html/>",
        json.dumps({"robot": 1}),
        "<robot name='a'><link/></robot>",
        "<robot name='a'/>",
    ],
)
def test_what_is_no_urdf(spoil, text):
    path = spoil()
    (path.parent / "hydrus_xi_quad.urdf").write_text(text)
    refused(path, DescriptionError, "hydrus_xi_quad.urdf")


WORLD = """<link name="world"/>
  <joint name="weld" type="fixed"><parent link="world"/><child link="link1"/></joint>
"""
DUST = """<link name="dust"/>
  <joint name="weld" type="continuous"><parent link="dust"/><child link="link1"/><axis xyz="0 0 1"/></joint>
"""

URDF_FAULTS = {
    "an endless shape": (
        ('<cylinder radius="0.0125" length="0.58"/>', '<cylinder radius="0.0125" length="1e300"/>'),
        ["1e+300 m", "below 1 km"],
    ),
    "negative mass": (
        ('<mass value="0.535052"/>', '<mass value="-0.535052"/>'),
        ["mass of link 'link2' is -0.535052 kg", "must not be negative"],
    ),
    "mass that is no number": (
        ('<mass value="0.030"/>', '<mass value="nan"/>'),
        ["mass of link 'pen'", "nan"],
    ),
    "a mass whose forces overflow": (
        ('<mass value="0.030"/>', '<mass value="1e200"/>'),
        ["the mass of link 'pen'", "has 1e+200", "up to 1e+06"],
    ),
    "mass that is a word": (('<mass value="0.030"/>', '<mass value="light"/>'), ["light"]),
    "grams in one link": (
        ('<mass value="0.030"/>', '<mass value="30"/>'),
        ["grams", "'pen' with 30 kg", "120 N"],
    ),
    "triangle inequality": (
        ('ixx="0.000808" iyy="0.012747" izz="0.012027"', 'ixx="0.000808" iyy="0.022747" izz="0.012027"'),
        ["inertia of link 'link2'", "A + B >= C", "0.0227"],
    ),
    "not positive definite": (
        ('ixx="0.000785" iyy="0.007046"', 'ixx="-0.000785" iyy="0.007046"'),
        ["inertia of link 'link4' is not positive definite", "-0.000785"],
    ),
    "inertia in g mm^2": (
        ('ixx="0.000785" iyy="0.007046" izz="0.006334"', 'ixx="785" iyy="7046" izz="6334"'),
        ["inertia of link 'link4'", "m from its centre"],
    ),
    "inertial without a mass": (('<mass value="0.030"/>', ""), ["link 'pen'", "without <mass>"]),
    "degrees in limits": (
        ('lower="-1.57" upper="1.57"', 'lower="-90" upper="90"'),
        ["lower limit of joint 'joint1' is -90 rad", "is it degrees? -90 deg = -1.571 rad"],
    ),
    "degrees of a tilt": (
        ('xyz="0 0 0.05091" rpy="0 0.34906585 0"', 'xyz="0 0 0.05091" rpy="0 20 0"'),
        ['<joint name="rotor1_tilt">', "[0.0, 20.0, 0.0] rad", "is it degrees?"],
    ),
    "limits crossed": (('lower="-1.57" upper="1.57"', 'lower="1.57" upper="-1.57"'), ["joint1", "not below"]),
    "no effort": (('effort="3.3"', 'effort="0"'), ["effort limit of joint 'joint1' is 0"]),
    "negative damping": (('damping="0.8"', 'damping="-0.8"'), ["damping of joint", "-0.8"]),
    "unknown kind of joint": (
        ('name="joint1" type="revolute"', 'name="joint1" type="prismatic"'),
        ["prismatic"],
    ),
    "axis zero": (('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>'), ["axis", "direction"]),
    "unknown parent": (('<parent link="link1"/>', '<parent link="link9"/>'), ["link9", "did you mean"]),
    "two links of one name": (('<link name="battery2">', '<link name="battery1">'), ["battery1", "2 times"]),
    "a joint nobody names": (
        ('<joint name="pen_clamp" type="fixed">', '<joint name="pen_clamp" type="continuous">'),
        ["joint 'pen_clamp' moves", "shape.joints"],
    ),
    "bolted to a massless world": (
        ("</robot>", f"{WORLD}</robot>"),
        ["'world'", "drop 0.648 kg", 'root_link = "link1"'],
    ),
    "a floating base": (
        ("</robot>", f"{WORLD.replace('fixed', 'floating')}</robot>"),
        ["joint 'weld'", "type 'floating'", 'root_link = "link1"'],
    ),
    "a root of dust": (
        ("</robot>", f"{DUST}</robot>"),
        ["joint 'weld' moves"],
    ),
    "two roots": (("</robot>", '<link name="stray"/></robot>'), ["exactly one root", "stray"]),
    "the rotor's link gone": (('name="rotor3"', 'name="propeller3"'), ["rotor3"]),
}


@pytest.mark.parametrize("name", URDF_FAULTS)
def test_faults_of_a_urdf(spoil, name):
    change, parts = URDF_FAULTS[name]
    refused(spoil(urdf=change), SkylimbError, *parts)


ROTOR = """[[rotors]]
link = "rotor4"
spin = -1
drag_torque_coefficient = 0.0182
thrust_min = 1.0
thrust_max = 30.0
lag = 0.05
thrust_factor = 4.04e-5
inertia = 2.0e-4
torque_limit = 0.8
"""

TOML_FAULTS = {
    "a rotor missing": ((ROTOR, ""), DescriptionError, ["has 3 rotors", "joints that turn one rotor each"]),
    "unknown link of a rotor": (
        ('link = "rotor4"', 'link = "roto4"'),
        UnknownNameError,
        ["roto4", "'rotor4'"],
    ),
    "unknown shape joint": (
        ('"joint3"]', '"joint33"]'),
        UnknownNameError,
        ["joint33", "did you mean 'joint3'"],
    ),
    "a fixed joint to bend": (('"joint3"]', '"pen_clamp"]'), UnknownNameError, ["moving joint", "pen_clamp"]),
    "a joint left out": (('"joint2", "joint3"]', '"joint2"]'), DescriptionError, ["joint3", "moves"]),
    "a joint named twice": (
        ('"joint2", "joint3"]', '"joint3", "joint3"]'),
        DescriptionError,
        ["joint3", "2 times"],
    ),
    "unknown measured link": (
        ('measured_link = "link1"', 'measured_link = "head"'),
        UnknownNameError,
        ["head"],
    ),
    "unknown tip link": (
        ('[tip]\nlink = "link4"', '[tip]\nlink = "link44"'),
        UnknownNameError,
        ["link44", "link4"],
    ),
    "unknown key": (("lag = 0.05", "lagg = 0.05"), UnknownNameError, ["lagg", "lag"]),
    "wrong type": (("spin = -1", 'spin = "left"'), ConfigError, ["spin", "left"]),
    "degrees of a rotor": (
        ('link = "rotor1"', 'link = "gimbal1"\nxyz = [0.0, 0.0, 0.05]\nrpy = [0.0, 20.0, 0.0]'),
        ConfigError,
        ["rotors.0.rpy = 20 rad (entry 2 of 3)", "20 deg = 0.3491 rad"],
    ),
    "spin of two": (("spin = -1", "spin = -2"), ConfigError, ["rotors.1.spin = -2 is not one of 1, -1"]),
    "thrust limits crossed": (
        ("thrust_max = 30.0", "thrust_max = 0.5"),
        ConfigError,
        ["rotors.0.thrust_min = 1 N must be below thrust_max = 0.5 N"],
    ),
    "a negative inertia": (
        ("inertia = 2.0e-4", "inertia = -2.0e-4"),
        ConfigError,
        ["rotors.0.inertia = -0.0002 kg m^2 is outside of 0 .. 0.1 kg m^2"],
    ),
    "an inertia in g m^2": (
        ("inertia = 2.0e-4", "inertia = 0.2"),
        ConfigError,
        ["rotors.0.inertia = 0.2 kg m^2 is outside of 0 .. 0.1 kg m^2"],
    ),
    "a current without its torque": (
        ("torque_limit = 0.8", "current_limit = 30.0"),
        ConfigError,
        ["rotors.0.current_limit = 30 A needs torque_constant beside it"],
    ),
    "a motor too weak for the least thrust": (
        ("torque_limit = 0.8", "torque_limit = 0.018"),
        ConfigError,
        ["rotors.0.torque_limit = 0.018 N m holds", "up to 0.989 N only", "thrust_min = 1 N"],
    ),
    "motors too weak for the weight": (
        ("torque_limit = 0.8", "torque_limit = 0.15"),
        DescriptionError,
        ["lift at most 32.967 N (a motor of 0.15 N m turns rotor1", "8.24 N; see rotors.torque_limit"],
    ),
    "motors too weak to hover": (
        ("torque_limit = 0.8", "torque_limit = 0.187"),
        AllocationError,
        ["cannot hover", "a motor of 0.187 N m turns rotor1", "rotors.torque_limit"],
    ),
    "signed drag": (
        ("drag_torque_coefficient = 0.0182", "drag_torque_coefficient = -0.0182"),
        ConfigError,
        ["rotors.0.drag_torque_coefficient = -0.0182 m is outside of 0 .. 1 m"],
    ),
    "lag zero": (("lag = 0.05", "lag = 0.0"), ConfigError, ["rotors.0.lag = 0 s must be above 0"]),
    "servo without stiffness": (
        ("stiffness = 50.0", "stiffness = 0.0"),
        ConfigError,
        ["shape.servo.stiffness = 0 N m/rad must be above 0"],
    ),
    "servos of two of three joints": (
        ("torque_limit = 3.3", "torque_limit = [3.3, 2.0]"),
        DescriptionError,
        ["shape.servo.torque_limit has 2 numbers for 3 joints (joint1, joint2, joint3)"],
    ),
    "one servo of no torque": (
        ("torque_limit = 3.3", "torque_limit = [3.3, 0.0, 3.3]"),
        ConfigError,
        ["shape.servo.torque_limit = 0 N m (entry 2 of 3) must be above 0"],
    ),
    "degrees of theta": (
        ("theta_nominal = 0.5235987755982988", "theta_nominal = 30.0"),
        ConfigError,
        ["posture.theta_nominal = 30 rad", "degrees"],
    ),
    "theta without a range": (
        ("theta_max = 1.25", "theta_max = 0.2"),
        ConfigError,
        ["posture.theta_min = 0.2 rad must be below theta_max = 0.2 rad"],
    ),
    "theta outside": (
        ("theta_nominal = 0.5235987755982988", "theta_nominal = 1.3"),
        ConfigError,
        ["posture.theta_nominal = 1.3 rad", "theta_max = 1.25 rad"],
    ),
    "posture outside of the joint limits": (
        ("theta_nominal = 0.5235987755982988", "theta_nominal = 1.0"),
        DescriptionError,
        ["'joint2' at 2 rad", "-1.57 .. 1.57"],
    ),
    "too few vectoring angles": (
        ("start = [3.141592653589793, 0.0,", "start = [0.0,"),
        DescriptionError,
        ["vectoring.start", "3 entries"],
    ),
    "all rotors in one place": (
        ('link = "rotor', 'link = "rotor1" # '),
        AllocationError,
        ["singular", "spins"],
    ),
    "not TOML": (("[tip]", "[tip"), ConfigError, ["not valid TOML"]),
    "an unknown root": (
        ('measured_link = "link1"', 'measured_link = "link1"\nroot_link = "link0"'),
        UnknownNameError,
        ["root_link", "link0", "did you mean"],
    ),
    "a root that would drop mass": (
        ('measured_link = "link1"', 'measured_link = "link2"\nroot_link = "link2"'),
        DescriptionError,
        ["would drop link 'link1' (0.455151 kg)"],
    ),
}


@pytest.mark.parametrize("name", TOML_FAULTS)
def test_faults_of_a_flight_file(spoil, name):
    change, error, parts = TOML_FAULTS[name]
    refused(spoil(toml=change), error, *parts)


def test_a_robot_that_cannot_hover_is_refused(spoil):
    path = spoil(toml=("thrust_max = 30.0", "thrust_max = 10.2"))
    refused(path, AllocationError, "cannot hover at q = [", "the greatest thrust of 'rotor", "(10.2 N) is in")


@pytest.mark.parametrize("kind", ["fixed", "floating"])
def test_a_massless_root_can_be_cut_away_by_name(spoil, kind):
    path = spoil(
        urdf=("</robot>", f"{WORLD.replace('fixed', kind)}</robot>"),
        toml=('measured_link = "link1"', 'measured_link = "link1"\nroot_link = "link1"'),
    )
    robot = load_robot(path)
    assert robot.description.root == "link1"
    assert robot.mass == pytest.approx(4.120637, abs=1e-9)


def test_the_axis_of_what_does_not_turn_is_none(spoil):
    mount = '<joint name="battery1_mount" type="fixed">'
    robot = load_robot(spoil(urdf=(mount, f'{mount}<axis xyz="0 0 0"/>')))
    assert robot.mass == pytest.approx(4.120637, abs=1e-9)
