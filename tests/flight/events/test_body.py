"""A load is welded on: the engine's inertia becomes that of a model that was built with it."""

import math
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np

from skylimb.base.rotations import rotation_from_rpy
from skylimb.flight.drivers.hooks import writing
from skylimb.flight.events import BodyChange, Timeline
from skylimb.robots.bodies import Placement
from skylimb.robots.description import Tip

SCENE = """
<mujoco>
  <worldbody>
    <body name="root" pos="0 0 1">
      <freejoint/>
      <geom type="capsule" fromto="0 0 0 .5 .1 0" size=".02"/>
      <body name="arm" pos=".5 0 0">
        <joint name="elbow" axis="0 0 1"/>
        <geom type="capsule" fromto="0 0 0 .4 0 0.1" size=".02"/>
        <site name="tip" pos=".4 0 0"/>
        <geom name="tip" type="sphere" pos=".4 0 0" size=".01" mass="0"/>
        {load}
      </body>
    </body>
  </worldbody>
</mujoco>
"""
LOAD = '<body pos="{}"><inertial pos="0 0 0" mass="{}" diaginertia="1e-12 1e-12 1e-12"/></body>'
TIMES = 0.005 * np.arange(20)
POINT = (0.1, -0.2, 0.05)
END = np.array([0.4, 0.0, 0.0])
TIP = Tip("arm", END, 0.01)
FRAME = rotation_from_rpy(0.3, -math.pi / 2, 0.2)
"""Axes of a frame at the end of the arm, as the arm sees them."""


def changed(*events: BodyChange, tick: int = 10, tip: Tip = TIP) -> mujoco.MjModel:
    """The model as some events leave it."""
    model = mujoco.MjModel.from_xml_string(SCENE.format(load=""))
    plant: Any = SimpleNamespace(model=model)
    places = {
        "arm": Placement(1, np.zeros(3), np.eye(3)),
        "frame": Placement(1, END, FRAME),
    }
    bodies = [SimpleNamespace(name="root"), SimpleNamespace(name="arm")]
    robot = SimpleNamespace(description=SimpleNamespace(tip=tip), placements=places, bodies=bodies)
    context: Any = SimpleNamespace(robot=robot, plant=plant)
    (write,) = writing(plant, Timeline(model=BodyChange.effect(events, context, TIMES)))
    write(tick)
    return model


def inertia(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    """Inertia matrix and centre of gravity in an odd posture."""
    data, M = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    data.qpos[:] = [0.1, 0.2, 1.3, 0.8, 0.4, -0.2, 0.4, 0.7]
    mujoco.mj_normalizeQuat(model, data.qpos)
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, M)
    return M, data.subtree_com[1].copy()


def test_a_load_is_part_of_its_link() -> None:
    built = mujoco.MjModel.from_xml_string(SCENE.format(load=LOAD.format("0.1 -0.2 0.05", 0.3)))
    first, second = BodyChange(0.01, "arm", 0.1, POINT), BodyChange(0.02, "", 0.2, POINT)
    for found, wanted in zip(inertia(changed(second, first)), inertia(built), strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_what_falls_off_again_leaves_what_was() -> None:
    on, off = BodyChange(0.01, "root", 0.3, POINT), BodyChange(0.03, "root", -0.3, POINT)
    bare = mujoco.MjModel.from_xml_string(SCENE.format(load=""))
    for found, wanted in zip(inertia(changed(on, off)), inertia(bare), strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-9)
    assert inertia(changed(on, off, tick=4))[0][0, 0] > inertia(bare)[0][0, 0] + 0.29


def test_a_pen_that_breaks_leaves_the_tip_nearer() -> None:
    model = changed(BodyChange(0.01, pen=0.05))
    np.testing.assert_allclose(model.geom("tip").pos, [0.35, 0.0, 0.0])
    np.testing.assert_allclose(model.site("tip").pos, [0.35, 0.0, 0.0])
    np.testing.assert_array_equal(model.body_mass, changed(BodyChange(0.5, mass=1.0)).body_mass)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.site("tip").xpos, [0.85, 0.0, 1.0])


def test_a_tip_on_a_frame_without_mass_is_a_place_of_the_body_that_carries_it() -> None:
    """The engine has no body for such a frame; a pen breaks along the tool, a load hangs where it is said."""
    tip = Tip("frame", np.zeros(3), 0.01, R=FRAME.T)  # along x of the arm
    broken = changed(BodyChange(0.01, pen=0.05), tip=tip)
    np.testing.assert_allclose(broken.geom("tip").pos, [0.35, 0.0, 0.0], atol=1e-12)
    x, y, z = END + FRAME @ POINT
    hung, same = (BodyChange(0.01, link, 0.2, point) for link, point in (("", POINT), ("arm", (x, y, z))))
    for found, wanted in zip(inertia(changed(hung, tip=tip)), inertia(changed(same)), strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_a_pen_on_a_mast_breaks_along_the_mast() -> None:
    broken = changed(BodyChange(0.01, pen=0.05), tip=Tip("arm", np.array([0.4, 0.0, 0.2]), 0.01, stem=END))
    np.testing.assert_allclose(broken.geom("tip").pos - END, [0.0, 0.0, -0.05], atol=1e-12)
