"""Robots other than the paper's: other axes, limits, no vectoring, no bending, frames without mass."""

import logging
import math

import numpy as np
import pytest

from made_robots import chain, joint, link
from skylimb.base.errors import AllocationError, DescriptionError
from skylimb.robots import load_robot, read_description
from skylimb.robots.controlled_axes import not_given
from skylimb.robots.equilibrium import can_hold
from skylimb.robots.equilibrium_results import Within
from skylimb.robots.hover import LEVEL, TILTED, find_hover
from skylimb.robots.starts import within_limits

PITCH, YAW, ROLL = "0 1 0", "0 0 1", "1 0 0"


@pytest.fixture(scope="module")
def dragon(tmp_path_factory):
    """Four links with pitch and yaw between them, two-axis vectoring within half a turn."""
    return load_robot(chain(tmp_path_factory.mktemp("dragon"), bends=(PITCH, YAW)))


def hover_of(robot):
    hover = find_hover(robot, robot.nominal_posture())
    assert hover
    return hover


def tip_yaw(robot, q, psi):
    x_axis = robot.link_poses(q, psi)[robot.description.tip.link][1][:, 0]
    return math.atan2(x_axis[1], x_axis[0])


@pytest.mark.parametrize("name", ["tilted_hexarotor", "tiltable_hexarotor"])
def test_a_hover_that_was_searched_before_is_what_is_held(name):
    robot = load_robot(name)
    q, start = robot.nominal_posture(), robot.description.vectoring_start
    level, tilted = (Within(tilt, math.inf) for tilt in (LEVEL, TILTED))
    held = can_hold(robot, q, start, None, level) or can_hold(robot, q, start, None, tilted)
    assert held
    for hover in (find_hover(robot, q), find_hover(robot, q)):
        assert hover
        np.testing.assert_array_equal(hover.thrusts, held.thrusts)
        np.testing.assert_array_equal(hover.vectoring_angles, held.vectoring_angles)
        assert hover.margin == held.margin


def test_the_tips_heading_is_that_of_its_link_whatever_the_axes_above_it(dragon):
    psi = hover_of(dragon).vectoring_angles
    rng = np.random.default_rng(3)
    for q in rng.uniform(-0.6, 0.6, (20, 6)):
        heading = dragon.at(q, psi).tip_heading
        assert math.remainder(heading - tip_yaw(dragon, q, psi), 2 * math.pi) == pytest.approx(0.0, abs=1e-12)


def test_the_heading_does_not_jump_near_the_nominal_posture(dragon):
    q = dragon.nominal_posture()
    psi = hover_of(dragon).vectoring_angles
    # 3 rad, and past half a turn: the paper's formula for parallel axes counts on.
    for factor in (0.9, 1.0, 1.1, 1.3):
        assert dragon.at(factor * q, psi).tip_heading == pytest.approx(factor * 3.0, abs=1e-12)


def test_a_robot_whose_rotors_are_parallel_at_the_start_hovers(dragon):
    """All thrusts along z give no yaw torque and a singular matrix; a little turn of the rotors mends it."""
    with pytest.raises(AllocationError, match="singular"):
        dragon.at(np.zeros(6), np.zeros(8))
    hover = hover_of(dragon)
    assert hover.room > 0.4
    assert hover.tilt < 0.006
    wrench = dragon.wrench_function(hover.joint_angles, hover.vectoring_angles).full() @ hover.thrusts
    np.testing.assert_allclose(wrench, [*wrench[:2], dragon.mass * 9.80665, 0, 0, 0], atol=1e-3)
    assert np.hypot(*wrench[:2]) < 0.006 * dragon.mass * 9.80665
    lower, upper = dragon.vectoring_limits()
    assert np.all(lower <= hover.vectoring_angles)
    assert np.all(hover.vectoring_angles <= upper)


def test_a_hover_outside_of_the_vectoring_joints_limits_is_none(tmp_path):
    """Rotors that lie on their side, with joints that turn them up by less than the least that carries."""
    free = chain(tmp_path / "free", turns=(ROLL,), turn_limit=None, tilt=1.2, bends=(YAW,))
    narrow = chain(
        tmp_path / "narrow", turns=(ROLL,), turn_limit=0.05, tilt=1.2, bends=(YAW,), thrust_max=17.0
    )
    assert load_robot(free).n_vectoring == 4
    with pytest.raises(AllocationError, match=r"cannot hover .* within their limits"):
        load_robot(narrow)


def test_folded_angles_are_within_limits_and_those_inside_stay(dragon):
    angles = np.linspace(-9.0, 9.0, 50)[:, None] * np.ones(8)
    folded = within_limits(dragon, angles)
    assert np.all(np.abs(folded) <= math.pi)
    inside = np.abs(angles) < math.pi
    np.testing.assert_allclose(folded[inside], angles[inside], atol=1e-12)


FEW = {
    "three that turn, though not across their thrust": (
        {"links": 3, "turns": ("0.6 0 0.8",)},
        r"3 rotors; .* hold every axis, but its laws need joints that turn one rotor each, .*torque",
    ),
    "three that do not turn": (
        {"links": 3, "turns": (), "tilt": 0.3},
        "3 rotors; 'made' cannot hover at q = ",
    ),
}


@pytest.mark.parametrize("given", FEW)
def test_few_rotors_are_refused_for_what_they_lack(tmp_path, given):
    kind, said = FEW[given]
    path = chain(tmp_path, **kind)
    with pytest.raises(DescriptionError, match=said):
        load_robot(path)


def test_the_axes_that_inputs_leave_out_have_their_names():
    assert not_given(np.eye(4)) == ""
    assert not_given(np.eye(4)[:, [0, 1, 2]]) == "yaw torque"
    assert not_given(np.eye(4)[:, [0, 3]]) == "roll torque and pitch torque"
    mixed = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]])
    assert not_given(mixed) == "a combination of roll torque and pitch torque"


def test_frames_without_mass_load(tmp_path):
    camera = '<link name="camera"/>\n' + joint("mount", "link1", "camera", xyz="0.1 0 0.02")
    zeros = link("lidar", 0.0) + joint("lidar_mount", "link2", "lidar")
    robot = load_robot(chain(tmp_path, turns=(), tilt=0.3, theta=(1.2, 1.6, 1.5), more_urdf=camera + zeros))
    assert robot.mass == pytest.approx(4.8)


MESHES = """<link name="cover"><visual><geometry><mesh filename="{}"/></geometry></visual></link>
<joint name="cover_mount" type="fixed"><parent link="link1"/><child link="cover"/></joint>"""


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("package://somewhere/mesh/cover.stl", "is not there"),
        ("cover.dae", "is none of .stl"),
        ("package://" + "x" * 5000, "is not there"),
    ],
)
def test_a_mesh_that_cannot_be_drawn_is_left_out_with_a_warning(tmp_path, caplog, name, reason):
    (tmp_path / "cover.dae").write_text("<COLLADA/>")
    with caplog.at_level(logging.WARNING):
        description = read_description(chain(tmp_path, more_urdf=MESHES.format(name)))
    assert not description.link("cover").visuals
    assert reason in caplog.text


@pytest.mark.parametrize("name", ["cover.stl", "package://mine/cover.stl", "package://mine/meshes/cover.stl"])
def test_a_mesh_of_a_package_is_found(tmp_path, name):
    package = tmp_path / "somewhere"
    path = chain(package / "urdf", more_urdf=MESHES.format(name))
    (package / "package.xml").write_text("<package><name>mine</name></package>")
    for place in (package / "meshes" / "cover.stl", package / "cover.stl", package / "urdf" / "cover.stl"):
        place.parent.mkdir(exist_ok=True)
        place.write_bytes(b"")
    mesh = read_description(path).link("cover").visuals[0].mesh
    assert mesh is not None
    expected = {"cover.stl": "urdf/cover.stl"}.get(name, name.removeprefix("package://mine/"))
    assert mesh.relative_to(package.resolve()).as_posix() == expected


def test_a_root_of_milligrams_counts_as_none(tmp_path):
    root = link("root", 1e-5, gyration=0.3) + joint("root_joint", "root", "link1")
    path = chain(tmp_path, more_urdf=root)
    text = path.read_text()
    path.write_text(text.replace('measured_link = "link1"', 'measured_link = "link1"\nroot_link = "link1"'))
    assert load_robot(path).description.root == "link1"


def test_bending_joints_without_postures_are_refused(tmp_path):
    path = chain(tmp_path)
    text = path.read_text()
    path.write_text(text[: text.index("[posture]")] + text[text.index("[vectoring]") :])
    with pytest.raises(Exception, match=r"posture .* is missing: it says how the joints of \[shape\] stand"):
        load_robot(path)
