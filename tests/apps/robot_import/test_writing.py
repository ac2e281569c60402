"""From a description to a robot that flies: what an import writes, xacro, packages, mapping files."""

import shutil

import numpy as np
import pytest
import trimesh

import skylimb
from lab_style import FIXED, lab_urdf
from made_robots import link
from skylimb.apps.cli.main import main
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.apps.robot_import.mapping import read_mapping
from skylimb.apps.robot_import.writing import import_robot
from skylimb.base.errors import DescriptionError, OutputError, UnknownNameError

VISUAL = '<link name="battery"><visual><geometry><mesh filename="{}"/></geometry></visual>'


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """The folder of one import, for all tests that only look at it."""
    folder = tmp_path_factory.mktemp("lab")
    (folder / "quad.urdf").write_text(lab_urdf(gimbal="revolute"))
    import_robot(folder / "quad.urdf", folder / "robot")
    return folder / "robot"


def test_an_import_loads_with_all_its_mass(imported):
    robot = skylimb.load_robot(imported)
    assert robot.mass == pytest.approx(1.0 + 0.3 + 0.2 + 5e-5, abs=1e-9)
    assert sorted(path.name for path in imported.iterdir()) == [
        "check.txt", "flight.toml", "mapping.toml", "robot.links.json", "robot.png", "robot.urdf",
    ]  # fmt: skip
    assert "can hover" in (imported / "check.txt").read_text()
    assert "lag of the rotors: is not said" in (imported / "flight.toml").read_text()


@pytest.mark.usefixtures("no_picture")
def test_an_import_flies(tmp_path):
    (tmp_path / "quad.urdf").write_text(lab_urdf(gimbal="fixed"))
    import_robot(tmp_path / "quad.urdf", tmp_path / "robot")
    changes = {"robot": str(tmp_path / "robot"), "posture.waypoints": []}
    run = skylimb.run("free_flight", controller="pid", set=changes)
    assert run.status == "OK", run.metrics
    assert run.metrics["displacement_median"] < 0.02


def test_the_drafted_mapping_says_what_was_proposed(imported, tmp_path):
    text = (imported / "mapping.toml").read_text()
    changed = tmp_path / "mapping.toml"
    changed.write_text(
        text.replace("thrust_max = 12.0", "thrust_max = 9.0").replace("lag = 0.05", "lag = 0.02")
    )
    report = check_robot_file(imported.parent / "quad.urdf", mapping=changed)
    assert report.can_hover
    assert {(rotor.thrust_max, rotor.lag) for rotor in report.description.rotors} == {(9.0, 0.02)}
    assert not any("assumed" in doubt.value for doubt in report.doubts), [str(d) for d in report.doubts]
    assert read_mapping(changed).role_of("gimbal2") == "vectoring"


def test_a_mapping_of_what_is_not_there_is_refused(lab_file, tmp_path):
    path = tmp_path / "m.toml"
    path.write_text('joints = [{ name = "gimbal9", role = "locked" }]')
    with pytest.raises(UnknownNameError, match=r"gimbal9.*did you mean 'gimbal4'"):
        check_robot_file(lab_file(), mapping=path)


def test_a_mapping_locks_a_joint(lab_file, tmp_path):
    path = tmp_path / "m.toml"
    path.write_text('joints = [{ name = "gimbal1", role = "locked" }]')
    report = check_robot_file(lab_file(), mapping=path)
    assert report.description.vectoring_joints == ("gimbal2", "gimbal3", "gimbal4")
    assert report.description.joint("gimbal1").kind == "fixed"


def test_nothing_is_written_over(imported):
    with pytest.raises(OutputError, match="exists already"):
        import_robot(imported.parent / "quad.urdf", imported)


def test_nothing_is_left_of_an_import_that_fails(tmp_path):
    (tmp_path / "bad.urdf").write_text('<robot name="a"><link name="b"/></robot>')
    with pytest.raises(DescriptionError):
        import_robot(tmp_path / "bad.urdf", tmp_path / "robot")
    assert [path.name for path in tmp_path.iterdir()] == ["bad.urdf"]


def test_meshes_are_copied_and_other_kinds_turned_into_stl(lab_file, tmp_path):
    package = tmp_path / "elsewhere" / "parts"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>parts</name></package>")
    trimesh.creation.box((0.1, 0.1, 0.05)).export(package / "box.ply")
    trimesh.creation.box((0.1, 0.1, 0.05)).export(package / "cell.stl")
    cell = VISUAL.format("package://parts/cell.stl")
    path = lab_file(
        ('<link name="battery">', cell),
        ('<link name="main">', VISUAL.format("package://parts/box.ply").replace("battery", "main")),
    )
    import_robot(path, tmp_path / "robot", packages=tmp_path / "elsewhere")
    meshes = sorted(file.name for file in (tmp_path / "robot" / "meshes").iterdir())
    assert meshes == ["box.stl", "cell.stl"]
    shutil.rmtree(tmp_path / "elsewhere")
    description = skylimb.load_robot(tmp_path / "robot").description
    assert [v.shape for name in ("main", "battery") for v in description.link(name).visuals] == ["mesh"] * 2


XACRO = """<?xml version="1.0"?>
<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:include filename="$(find quads)/urdf/body.xacro"/>
</robot>
"""


@pytest.fixture
def package(tmp_path):
    """A package with a xacro file that includes another, and a motor table of its name."""
    folder = tmp_path / "quads"
    (folder / "urdf").mkdir(parents=True)
    (folder / "robots" / "small").mkdir(parents=True)
    (folder / "config" / "small").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>quads</name></package>")
    inside = lab_urdf().partition("?>")[2].replace('<robot name="lab quad">', '<robot name="body">')
    (folder / "urdf" / "body.xacro").write_text(inside)
    (folder / "robots" / "small" / "robot.urdf.xacro").write_text(XACRO)
    (folder / "config" / "small" / "MotorInfo.yaml").write_text(
        "motor_info:\n  min_thrust: 0.4\n  m_f_rate: -0.02\n  rotor_damping_rate: 0.0909090909\n"
        "  ref1: {voltage: 25.2, max_thrust: 12}\n  ref2: {voltage: 23.2, max_thrust: 10}\n"
        "  ref3: {voltage: 21.2, max_thrust: 8}\n"
    )
    (folder / "config" / "small" / "Servo.yaml").write_text(
        "servo_controller:\n  gimbals:\n    simulation: {pid: {p: 7.0, i: 0.1, d: 0.3}}\n"
    )
    return folder


def test_xacro_with_the_tables_of_its_name(package):
    report = check_robot_file(package / "robots" / "small")
    assert report.can_hover, report.reasons
    rotor, servo = report.description.rotors[0], report.description.vectoring_servos
    assert (rotor.thrust_min, rotor.thrust_max, rotor.lag) == (0.5, 10.0, pytest.approx(0.01))
    assert {*servo.stiffness, *servo.damping} == {7.0, 0.3}
    said = {doubt.what: doubt.value for doubt in report.doubts}
    assert "12 N in the URDF and 10 N in MotorInfo.yaml (at 23.2 V)" in said["greatest thrust"]
    assert "0.0172 m in the URDF and 0.02 m" in said["drag torque per thrust"]


def test_servos_without_damping_are_given_some_and_it_is_said(package):
    table = package / "config" / "small" / "Servo.yaml"
    table.write_text("servo_controller:\n  gimbals:\n    simulation: {pid: {p: 7.0, i: 0.1, d: 0.0}}\n")
    report = check_robot_file(package / "robots" / "small")
    servo = report.description.vectoring_servos
    assert {*servo.stiffness} == {7.0}
    np.testing.assert_allclose(servo.damping, 0.14)
    said = {doubt.what: doubt.value for doubt in report.doubts}
    assert "without damping" in said["damping of the servos of gimbals"]


def test_a_package_that_is_not_there_is_named(package):
    path = package / "robots" / "small" / "robot.urdf.xacro"
    path.write_text(XACRO.replace("$(find quads)", "$(find octos)"))
    with pytest.raises(UnknownNameError, match=r"needs package 'octos'.*--packages DIR \(known: quads\)"):
        check_robot_file(path)


def test_a_xacro_without_end_is_refused(package):
    path = package / "robots" / "small" / "robot.urdf.xacro"
    endless = '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>'
    path.write_text(XACRO.replace('<xacro:include filename="$(find quads)/urdf/body.xacro"/>', endless))
    with pytest.raises(DescriptionError, match="cannot be expanded"):
        check_robot_file(path)


def test_a_folder_with_several_descriptions_names_them(package):
    with pytest.raises(DescriptionError, match=r"has no \.urdf, \.urdf\.xacro or \.sdf file"):
        check_robot_file(package / "config")
    (package / "urdf" / "other.urdf").write_text("<robot/>")
    with pytest.raises(DescriptionError, match="has 2 descriptions; name one: robots/small/"):
        check_robot_file(package)


@pytest.mark.usefixtures("no_picture")
def test_a_flight_controller_is_taken_for_the_imu_and_told(tmp_path):
    board = link("fc", 0.05, gyration=0.02)
    mount = FIXED.format(name="main2fc", parent="main", child="fc", xyz="0.02 0 0.03")
    (tmp_path / "quad.urdf").write_text(lab_urdf(gimbal="revolute", extra=board + mount))
    report = import_robot(tmp_path / "quad.urdf", tmp_path / "robot")
    (doubt,) = [one for one in report.doubts if one.what == "the IMU"]
    assert str(doubt).startswith("the IMU: is taken to be link 'fc', by its name")
    assert skylimb.load_robot(tmp_path / "robot").description.imu.link == "fc"
    mapping = tmp_path / "mapping.toml"
    mapping.write_text('[imu]\nlink = "battery"\nxyz = [0.0, 0.0, 0.01]\n')
    said = check_robot_file(tmp_path / "quad.urdf", mapping=mapping)
    assert said.description.imu.link == "battery"
    assert not [one for one in said.doubts if one.what == "the IMU"]


def test_a_robot_that_cannot_hover_is_written_and_its_report_is_shown(tmp_path, capsys):
    """Exit codes are those of a check; no flight is proposed that would be refused."""
    text = lab_urdf(gimbal="fixed").replace('upper="12"', 'upper="2"')
    assert 'upper="2"' in text
    (tmp_path / "weak.urdf").write_text(text)
    assert main(["robot", "import", str(tmp_path / "weak.urdf"), "--out", str(tmp_path / "robot")]) == 1
    said = capsys.readouterr()
    assert "FAULT     the description" in said.out
    assert "skylimb run" not in said.out
    assert said.err == ""
    assert (tmp_path / "robot" / "robot.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("kind", ["spoilt.stl", "empty.stl", "fine.stl"])
def test_a_mesh_that_cannot_be_drawn_keeps_no_robot_from_hovering(kind, lab_file, tmp_path):
    """The check and the imported robot leave out the same."""
    (tmp_path / "spoilt.stl").write_bytes(bytes(50))
    (tmp_path / "empty.stl").write_bytes(b"")
    if kind == "fine.stl":
        trimesh.creation.icosphere(subdivisions=7, radius=0.02).export(tmp_path / kind)  # 16 MB
    report = check_robot_file(lab_file(('<link name="battery">', VISUAL.format(kind))))
    assert report.can_hover, report.reasons
    assert any("cannot be drawn" in doubt.value and kind in doubt.what for doubt in report.doubts)
    assert report.description.link("battery").visuals == ()


def test_a_mesh_in_millimetres_is_asked_about(lab_file, tmp_path):
    trimesh.creation.box((100.0, 80.0, 20.0)).export(tmp_path / "cell.stl")
    drawn = VISUAL.format("cell.stl")
    report = check_robot_file(lab_file(('<link name="battery">', drawn)))
    assert any("'battery' is 100 m large" in str(doubt) for doubt in report.doubts)
    scaled = drawn.replace("cell.stl", 'cell.stl" scale="0.001 0.001 0.001')
    report = check_robot_file(lab_file(('<link name="battery">', scaled)))
    assert not any("large" in str(doubt) for doubt in report.doubts)
