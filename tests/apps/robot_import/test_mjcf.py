"""MJCF files, read by MuJoCo: what comes out of them is held against MuJoCo's own bodies."""

from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from mjcf_quad import MAPPING, QUAD
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.base.errors import DescriptionError, SkylimbError
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.robots.model import Robot

LOOP = '<equality><weld body1="lower" body2="base"/></equality>'


@pytest.fixture
def quad(tmp_path: Path) -> Callable[..., Path]:
    (tmp_path / "mapping.toml").write_text(MAPPING)

    def write(*changes: tuple[str, str]) -> Path:
        text = QUAD
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "quad.xml").write_text(text)
        return tmp_path / "quad.xml"

    return write


def test_bodies_stand_where_mujoco_puts_them(quad: Callable[..., Path]) -> None:
    path = quad()
    report = check_robot_file(path, mapping=path.with_name("mapping.toml"))
    robot = Robot(report.description)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    base = model.body("base").id
    for _ in range(5):
        q = rng.uniform(-1.4, 1.4, 2)
        # The sliding finger is held as near to zero as its range lets it.
        data.qpos[7:] = [*q, 0.01]
        mujoco.mj_forward(model, data)
        R = rotation_from_quaternion(data.xquat[base])
        poses = robot.link_poses(q, np.zeros(0))
        for name in ("upper", "lower", "finger"):
            body = model.body(name).id
            np.testing.assert_allclose(poses[name][0], R.T @ (data.xpos[body] - data.xpos[base]), atol=1e-12)
            turned = R.T @ rotation_from_quaternion(data.xquat[body])
            np.testing.assert_allclose(poses[name][1], turned, atol=1e-12)
        cog = R.T @ (data.subtree_com[base] - data.xpos[base])
        np.testing.assert_allclose(np.ravel(robot.at(q, np.zeros(0)).cog_root), cog, atol=1e-12)
        for k, rotor in enumerate(report.description.rotors, 1):
            axis = R.T @ data.site(f"thrust{k}").xmat.reshape(3, 3)[:, 2]
            np.testing.assert_allclose((poses[rotor.link][1] @ rotor.R)[:, 2], axis, atol=1e-12)
    assert report.mass == pytest.approx(model.body_subtreemass[base], abs=1e-12)


def test_rotors_and_servos_are_those_of_the_actuators(quad: Callable[..., Path]) -> None:
    path = quad()
    report = check_robot_file(path, mapping=path.with_name("mapping.toml"))
    assert report.can_hover, report.reasons
    rotors = report.description.rotors
    assert [(rotor.thrust_min, rotor.thrust_max, rotor.lag) for rotor in rotors] == [(0.2, 13.0, 0.03)] * 4
    # The torque on the body is against the spin.
    assert [rotor.drag_torque_coefficient for rotor in rotors] == [-0.02, 0.02, -0.02, 0.02]
    assert [rotor.spin for rotor in rotors] == [1, -1, 1, -1]
    assert report.description.joint("shoulder").effort == 4.0
    assert report.description.joint("elbow").effort == 6.0
    assert "greatest thrust" not in {doubt.what for doubt in report.doubts}


FRICTION = (
    '<general name="rub" joint="elbow" dyntype="dcmotor" gaintype="dcmotor" biastype="dcmotor" dynprm="0" '
    'actearly="true" actlimited="false" input="none" gainprm="1 1" forcerange="-0.05 0.05"/>'
)


def test_an_actuator_without_a_control_moves_no_other_and_is_no_drive(quad: Callable[..., Path]) -> None:
    """The engine numbers controls and actuators apart: one that only rubs has none."""
    plain, rubbed = (
        check_robot_file(path, mapping=path.with_name("mapping.toml")).description
        for path in (quad(), quad(("<actuator>", f"<actuator>{FRICTION}")))
    )
    assert [(r.name, r.thrust_max) for r in rubbed.rotors] == [(r.name, r.thrust_max) for r in plain.rotors]
    assert rubbed.joint("elbow").effort == 6.0


def test_torques_of_two_drives_of_a_joint_add_up_to_the_joints_own_limit(quad: Callable[..., Path]) -> None:
    more = '<motor joint="elbow" forcerange="-1 1"/><motor joint="shoulder" forcerange="-9 9"/></actuator>'
    path = quad(("</actuator>", more))
    found = check_robot_file(path, mapping=path.with_name("mapping.toml")).description
    assert (found.joint("elbow").effort, found.joint("shoulder").effort) == (7.0, 4.0)


def test_a_gear_that_is_no_number_is_refused_with_its_actuator(quad: Callable[..., Path]) -> None:
    with pytest.raises(DescriptionError, match=r"gear of actuator 'motor1' of 'quad.xml' is no number"):
        check_robot_file(quad(("0 0 1 0 0 -0.02", "0 0 1 0 0 nan")))


def test_shapes_are_those_that_mujoco_compiles(quad: Callable[..., Path]) -> None:
    shapes = {link.name: link.collisions for link in check_robot_file(quad()).description.links}
    assert [(one.shape, one.size) for one in shapes["base"]] == [("box", (0.2, 0.16, 0.06))]
    (capsule,) = shapes["upper"]  # with its round ends
    assert (capsule.shape, np.round(capsule.size, 9).tolist()) == ("cylinder", [0.01, 0.22])
    np.testing.assert_allclose(capsule.xyz, [0.1, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(np.abs(capsule.R[:, 2]), [1.0, 0.0, 0.0], atol=1e-12)


def test_a_coupled_joint_is_held_where_its_coupling_puts_it(quad: Callable[..., Path]) -> None:
    coupled = '<equality><joint joint1="elbow" joint2="shoulder" polycoef="0.3 1 0 0 0"/></equality>'
    path = quad(("</worldbody>", f"</worldbody>{coupled}"))
    path.with_name("mapping.toml").write_text('joints = [{ name = "shoulder", role = "shape" }]')
    report = check_robot_file(path, mapping=path.with_name("mapping.toml"))
    assert "held at 0.3" in " ".join(map(str, report.doubts))
    turned = report.description.joint("elbow").R
    np.testing.assert_allclose(turned[:, 0], [np.cos(0.3), 0.0, -np.sin(0.3)], atol=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("<freejoint/>", "<freejoint"), "is no XML of a robot"),
        (('type="box"', 'type="cube"'), "MuJoCo cannot read 'quad.xml'"),
        (('type="slide" axis="1 0 0" range="0.01 0.05"', 'type="ball"'), "neither turns"),
        (("</worldbody>", f"</worldbody>{LOOP}"), "closes a loop"),
        (("</worldbody>", '<body name="two"><freejoint/><geom size=".1"/></body></worldbody>'), "base, two"),
        ((QUAD, "<mujoco/>"), "found: none"),
    ],
)  # fmt: skip
def test_what_is_no_such_robot_is_refused_in_a_line(
    quad: Callable[..., Path], change: tuple[str, str], words: str
) -> None:
    path = quad(change)
    with pytest.raises(DescriptionError, match=words) as caught:
        check_robot_file(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("end", range(0, len(QUAD), 97))
def test_a_file_that_ends_early_is_refused(quad: Callable[..., Path], end: int) -> None:
    path = quad((QUAD, QUAD[:end]))
    with pytest.raises(SkylimbError):
        check_robot_file(path)
