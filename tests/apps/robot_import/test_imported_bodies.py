"""Bodies of imported robots against engines that read the same files: Pinocchio for URDF, MuJoCo for MJCF."""

from importlib import import_module
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from armed_robots import SIX, TWO, multirotor_with_arm
from mjcf_quad import MAPPING, QUAD
from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.robots.model import Robot
from skylimb.robots.posed import RobotState

# Pinocchio fills its module at run time, where a type checker cannot look.
pin: Any = import_module("pinocchio")

MADE: dict[str, dict[str, Any]] = {
    "two joints": {"joints": TWO},
    "six joints": {"joints": SIX, "rotors": 6, "cant": 0.3},
    "arms that turn": {"joints": (), "stick": 0.45, "turning": 1.5},
    "two joints, turned down": {"joints": TWO, "mount": "0 0 -0.04", "turned": "0.2 1.2 0.1"},
}


def imported(path: Path, mapping: Path | None = None) -> Robot:
    return Robot(check_robot_file(path, mapping=mapping).description)


def unsought(joints: int) -> str:
    """A mapping with a posture, so that none is sought."""
    zeros, ones = [0.0] * joints, [1.0] * joints
    return (
        f"posture = {{ offset = {zeros}, slope = {ones}, theta_min = -0.1, theta_max = 0.1, "
        "theta_nominal = 0.0 }\n"
        if joints
        else ""
    )


def about(middle: np.ndarray, inertia: np.ndarray, mass: float) -> np.ndarray:
    """Inertia about the centre of gravity of one that is about a point `middle` away from it."""
    return inertia - mass * (middle @ middle * np.eye(3) - np.outer(middle, middle))


def gravity_torques(robot: Robot, state: RobotState) -> np.ndarray:
    """What gravity pulls the joints by in a level robot, N m."""
    return state.mass * robot.description.gravity * np.array(state.cog_jacobian)[2]


@pytest.mark.parametrize("given", MADE.values(), ids=MADE)
def test_bodies_jacobians_and_gravity_of_a_urdf_are_pinocchios(tmp_path: Path, given: dict[str, Any]) -> None:
    path = multirotor_with_arm(tmp_path / "made.urdf", **given)
    (tmp_path / "mapping.toml").write_text(unsought(len(given["joints"])))
    robot = imported(path, tmp_path / "mapping.toml")
    description = robot.description
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    model.gravity.linear = np.array([0.0, 0.0, -description.gravity])
    data = model.createData()
    joints = [model.getJointId(name) for name in (*description.shape_joints, *description.vectoring_joints)]
    columns = [model.idx_vs[joint] for joint in joints]
    rng = np.random.default_rng(8)
    for _ in range(5):
        angles = rng.uniform(-1.5, 1.5, len(joints))
        x = pin.neutral(model)
        for joint, angle in zip(joints, angles, strict=True):
            x[model.idx_qs[joint]] = angle
        q, psi = np.split(angles, [len(description.shape_joints)])
        state = robot.at(q, psi)
        pin.ccrba(model, data, x, np.zeros(model.nv))
        assert state.mass == pytest.approx(pin.computeTotalMass(model), abs=1e-12)
        np.testing.assert_allclose(state.cog_root, data.com[0], atol=1e-12)
        inertia = state.R_root_C @ state.inertia_C @ state.R_root_C.T
        np.testing.assert_allclose(inertia, data.Ig.inertia, atol=1e-12)
        cog = pin.jacobianCenterOfMass(model, data, x)[:, columns]
        np.testing.assert_allclose(state.cog_jacobian, cog, atol=1e-12)
        pulled = pin.computeGeneralizedGravity(model, data, x)[columns]
        np.testing.assert_allclose(gravity_torques(robot, state), pulled, atol=1e-11)
        # The tool stands in the frame tool0.
        frame = model.getFrameId("tool0")
        pin.computeJointJacobians(model, data, x)
        pin.updateFramePlacements(model, data)
        np.testing.assert_allclose(state.tip_root, data.oMf[frame].translation, atol=1e-4)
        tip = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)[:3, columns[: len(q)]]
        np.testing.assert_allclose(state.tip_jacobian, tip, atol=1e-4)


def test_bodies_jacobians_and_gravity_of_an_mjcf_are_mujocos(tmp_path: Path) -> None:
    path, mapping = tmp_path / "quad.xml", tmp_path / "mapping.toml"
    path.write_text(QUAD)
    mapping.write_text(MAPPING)
    robot = imported(path, mapping)
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.gravity[2] = -robot.description.gravity
    data = mujoco.MjData(model)
    base, tip = model.body("base").id, robot.description.tip
    dofs = [int(model.joint(name).dofadr[0]) for name in robot.description.shape_joints]
    mass = float(model.body_subtreemass[base])
    rng = np.random.default_rng(9)
    for _ in range(5):
        q = rng.uniform(-1.4, 1.4, 2)
        # The root stands level in the origin; the sliding finger is held as near to zero as it may be.
        data.qpos[:] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *q, 0.01]
        mujoco.mj_forward(model, data)
        state = robot.at(q, np.zeros(0))
        whole = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, whole)
        cog = data.subtree_com[base]
        inertia = state.R_root_C @ state.inertia_C @ state.R_root_C.T
        np.testing.assert_allclose(inertia, about(cog, whole[3:6, 3:6], mass), atol=1e-12)
        jacobian = np.zeros((3, model.nv))
        mujoco.mj_jacSubtreeCom(model, data, jacobian, base)
        np.testing.assert_allclose(state.cog_jacobian, jacobian[:, dofs], atol=1e-12)
        np.testing.assert_allclose(gravity_torques(robot, state), data.qfrc_bias[dofs], atol=1e-12)
        body = model.body(tip.link).id
        place = data.xpos[body] + data.xmat[body].reshape(3, 3) @ tip.position
        np.testing.assert_allclose(state.tip_root, place, atol=1e-12)
        mujoco.mj_jac(model, data, jacobian, None, place, body)
        np.testing.assert_allclose(state.tip_jacobian, jacobian[:, dofs], atol=1e-12)
