"""SDF files: what comes out of them is held against libsdformat, as Drake reads them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from sdf_quad import write_sdf
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.apps.robot_import.sdf import read_sdf
from skylimb.apps.robot_import.writing import import_robot
from skylimb.base.errors import DescriptionError
from skylimb.robots import load_robot
from skylimb.robots.model import Robot

JOINTS = ("shoulder_pitch", "elbow_pitch", "spin_fr", "spin_fl")


@pytest.fixture
def armed(tmp_path: Path) -> Callable[..., Path]:
    path = write_sdf(tmp_path)

    def change(*changes: tuple[str, str], file: str = "armed") -> Path:
        text = (tmp_path / file / "model.sdf").read_text(encoding="utf-8")
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new, 1)
        (tmp_path / file / "model.sdf").write_text(text, encoding="utf-8")
        return path

    return change


def _bodies(plant: Any, q: np.ndarray) -> dict[str, tuple[float, np.ndarray, np.ndarray]]:
    """Mass, centre of gravity and inertia about it, as seen from the base, of each body in Drake."""
    context = plant.CreateDefaultContext()
    for name, angle in zip(JOINTS, q, strict=True):
        plant.GetJointByName(name).set_angle(context, angle)
    base = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName("base")).inverse()
    found = {}
    for name in ("base", "upper", "lower", "fr", "fl", "br", "bl"):
        body = plant.GetBodyByName(name)
        X, inertia = (
            base @ plant.EvalBodyPoseInWorld(context, body),
            body.CalcSpatialInertiaInBodyFrame(context),
        )
        R, own = X.rotation().matrix(), inertia.Shift(inertia.get_com()).CalcRotationalInertia()
        found[name] = (inertia.get_mass(), X @ inertia.get_com(), R @ own.CopyToFullMatrix3() @ R.T)
    return found


@pytest.mark.parametrize("scope", ["", "body::"], ids=["merged", "a model of its own"])
def test_bodies_stand_where_libsdformat_puts_them(armed: Callable[..., Path], scope: str) -> None:
    drake = pytest.importorskip("pydrake.all", reason="Drake has no wheel for this machine")
    path = armed(("<uri>model://body</uri>", "<uri>model://body/model.sdf</uri>"))
    if scope:
        armed((' merge="true"', ""), ('attached_to="base"', 'attached_to="body::base"'))
    urdf, folders = read_sdf(path)
    assert set(folders) == {"armed", "body"}
    plants = []
    for kind, text in (("sdf", path.read_text(encoding="utf-8")), ("urdf", urdf.decode())):
        plants.append(drake.MultibodyPlant(1e-3))
        parser = drake.Parser(plants[-1])
        for folder in folders.values():
            parser.package_map().Add(folder.name, str(folder))
        parser.AddModelsFromString(text, kind)
        plants[-1].Finalize()
    for q in np.random.default_rng(4).uniform(-1.4, 1.4, (5, len(JOINTS))):
        said, ours = (_bodies(plant, q) for plant in plants)
        for name, (mass, middle, inertia) in said.items():
            assert ours[name][0] == mass
            np.testing.assert_allclose(ours[name][1], middle, atol=1e-12)
            np.testing.assert_allclose(ours[name][2], inertia, atol=1e-12)
    tips = []
    for plant in plants:
        ends = plant.CreateDefaultContext(), plant.GetFrameByName("base")
        tips.append(plant.GetFrameByName("tool0").CalcPose(*ends).GetAsMatrix4())
    np.testing.assert_allclose(*tips, atol=1e-12)


@pytest.mark.usefixtures("no_picture")
def test_a_robot_comes_out_that_hovers_and_touches(armed: Callable[..., Path], tmp_path: Path) -> None:
    report = check_robot_file(armed().parent)
    assert report.can_hover, report.reasons
    assert report.can_touch
    rotors = report.description.rotors
    assert [(rotor.thrust_max, rotor.lag, rotor.spin) for rotor in rotors] == [
        (8.5, 0.025, s) for s in (1, 1, -1, -1)
    ]
    said = {doubt.what for doubt in report.doubts}
    assert not said & {"drag torque per thrust", "greatest thrust", "lag of the rotors", "spin of the rotors"}
    assert report.description.tip.link == "tool0"
    import_robot(armed(), tmp_path / "robot")
    robot = Robot(load_robot(str(tmp_path / "robot")).description)
    assert robot.mass == pytest.approx(1.48, abs=1e-12)
    assert b"plugin" not in (tmp_path / "robot" / "robot.urdf").read_bytes()


def test_shapes_come_as_a_urdf_has_them(armed: Callable[..., Path]) -> None:
    shapes = {
        link.get("name"): link.find("visual/geometry")
        for link in ElementTree.fromstring(read_sdf(armed())[0]).iter("link")
    }
    for name, kind, said in (
        ("upper", "cylinder", {"radius": "0.0625", "length": "0.375"}),
        ("lower", "box", {"size": "0.04 0.04 0.2"}),
        ("fr", "cylinder", {"radius": "0.12", "length": "0.01"}),
    ):
        shape = shapes[name]
        assert shape is not None
        assert shape[0].tag == kind
        assert shape[0].attrib == said


def test_a_model_in_a_model_is_called_by_both_where_names_clash(armed: Callable[..., Path]) -> None:
    """An axis of SDF 1.6 in the frame of its model turns along with that, and a plugin finds its link."""
    spin = "<xyz>0 0 1</xyz><use_parent_model_frame>1</use_parent_model_frame>"
    armed(("<xyz>0 0 1</xyz>", spin), ("0.1 0 0.24 0 0 0.3", "0.1 0 0.24 0.4 0 0.3"), file="body")
    inner = '<frame name="fl"/>'
    path = armed((' merge="true"', ""), ("<uri>", "<name>quad</name><uri>"), ('"base"', '"quad::base"'))
    armed(("<include>", f"{inner}<include>"))
    root = ElementTree.fromstring(read_sdf(path)[0])
    assert [link.text for link in root.iter("linkName")] == ["fr", "bl", "quad::fl", "br"]
    axis = root.find("joint[@name='spin_fr']/axis")
    assert axis is not None
    # z of the model, seen from a rotor on a base that is rolled by 0.4 rad and turned by 0.3 rad.
    seen = [float(word) for word in axis.get("xyz", "").split()]
    np.testing.assert_allclose(seen, [0.0, np.sin(0.4), np.cos(0.4)], atol=1e-12)


def test_a_stand_is_left_out_and_prefixes_mean_nothing(armed: Callable[..., Path]) -> None:
    stand = '<joint name="stand" type="fixed"><parent>world</parent><child>base</child></joint>'
    odd = '<gz:system gz:type="x" type="y"/>'
    assert read_sdf(armed(("<include", f"{stand}{odd}<include")))[0] == read_sdf(armed((stand + odd, "")))[0]


def test_a_joint_that_follows_another_does_so(armed: Callable[..., Path]) -> None:
    said = "<multiplier>2</multiplier><offset>0.1</offset><reference>0.3</reference>"
    mimic = f'<mimic joint="shoulder_pitch">{said}</mimic>'
    path = armed(('<xyz expressed_in="__model__">', f'{mimic}<xyz expressed_in="__model__">'))
    found = ElementTree.fromstring(read_sdf(path)[0]).find("joint[@name='elbow_pitch']/mimic")
    assert found is not None
    assert {key: value for key, value in found.items() if key != "offset"} == {
        "joint": "shoulder_pitch",
        "multiplier": "2.0",
    }
    assert float(found.get("offset", "")) == pytest.approx(-0.5)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("model://body", "model://legs", "includes 'model://legs', which is not found.*--packages DIR"),
        ("model://body", "model://" + 400 * "9", "which is not found"),
        ("model://body", "model://armed", "includes itself"),
        ('type="revolute"', 'type="ball"', "joint 'shoulder_pitch' is ball; read are revolute, continuous"),
        ('attached_to="base"', 'attached_to="mount"', "'mount', which is not there or placed from itself"),
        ('relative_to="mount"', 'relative_to="nothing"', "'nothing', which is not there"),
        ("<child>lower</child>", "<child>upper</child>", "found: base, lower"),
        ("<mass>0.1</mass>", "<mass>much</mass>", "<mass> is no number: 'much'"),
        (
            '<pose degrees="true">0 0 1 0 0 20',
            '<pose degrees="true">0 0 1',
            "6 numbers are needed, not '0 0 1'",
        ),
        ('<pose degrees="true">', '<pose rotation_format="quat_xyzw">', "is a quaternion"),
        ("<inertial>", '<inertial auto="true">', "link 'upper' leaves its mass to the simulator"),
        ('name="lower"', 'name="upper"', "'upper' stands twice"),
        (
            '<model name="armed">',
            '<model name="armed"/><model name="two">',
            "needs one model, and has 2 models",
        ),
        (
            '<model name="armed">',
            '<model name="armed"><model name="a"><link name="b"/></model>',
            "found: b, base",
        ),
    ],
)
def test_what_is_no_robot_is_refused_by_name(
    armed: Callable[..., Path], old: str, new: str, said: str
) -> None:
    with pytest.raises(DescriptionError, match=said) as caught:
        read_sdf(armed((old, new)))
    assert "\n" not in str(caught.value)


def test_a_world_is_no_robot(tmp_path: Path) -> None:
    (tmp_path / "world.sdf").write_text('<sdf version="1.9"><world name="w"/></sdf>')
    with pytest.raises(DescriptionError, match="needs one model, and has a world"):
        check_robot_file(tmp_path / "world.sdf")
