"""A push is a wrench on a body: at its centre of gravity, or at a point of a link."""

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.flight.drivers.hooks import pushing
from skylimb.flight.events import Push, Timeline, Wrench

SCENE = """
<mujoco>
  <worldbody>
    <body name="root" pos="0 0 1">
      <freejoint/>
      <geom type="capsule" fromto="0 0 0 .5 0 0" size=".02"/>
      <body name="arm" pos=".5 0 0">
        <joint name="elbow" axis="0 0 1"/>
        <geom type="capsule" fromto="0 0 0 .4 0 0" size=".02"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
TIMES = 0.005 * np.arange(200)
FORCE, POINT = (0.3, -0.2, 0.5), (0.35, 0.01, -0.02)


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(SCENE)


@pytest.fixture
def data(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:] = [0.1, 0.2, 1.3, 0.8, 0.4, -0.2, 0.4, 0.7]
    mujoco.mj_normalizeQuat(model, data.qpos)
    return data


def wrenches(model: mujoco.MjModel, *pushes: Push) -> tuple[Wrench, ...]:
    context: Any = SimpleNamespace(
        robot=SimpleNamespace(description=SimpleNamespace(root="root")), plant=SimpleNamespace(model=model)
    )
    return Push.effect(pushes, context, TIMES)


def applied(model: mujoco.MjModel, data: mujoco.MjData, k: int, *pushes: Push) -> np.ndarray:
    plant: Any = SimpleNamespace(model=model)
    data.qfrc_applied[:] = 0.0  # as the tick before it does
    (push,) = pushing(plant, data, Timeline(wrenches=wrenches(model, *pushes)))
    push(k)
    return data.qfrc_applied.copy()


def test_a_push_on_a_link_acts_through_its_point(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    push = Push(0.0, duration=1.0, force=FORCE, link="arm", point=POINT)
    found = applied(model, data, 0, push)
    arm = model.body("arm").id
    point = data.xpos[arm] + data.xmat[arm].reshape(3, 3) @ POINT
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, jacobian, None, point, arm)
    np.testing.assert_allclose(found, jacobian.T @ FORCE, atol=1e-12)
    assert abs(found[-1]) > 0.01  # the elbow feels it


def test_a_push_without_a_link_turns_and_bends_nothing(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """A force through the centre of gravity accelerates all of the robot alike."""
    found = applied(model, data, 0, Push(0.0, duration=1.0, force=FORCE))
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    alike = np.zeros(model.nv)
    alike[:3] = np.array(FORCE) / model.body("root").subtreemass[0]
    np.testing.assert_allclose(np.linalg.solve(M, found), alike, atol=1e-9)


def test_a_torque_without_a_link_turns_the_root(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    found = applied(model, data, 0, Push(0.0, duration=1.0, torque=(0.1, 0.0, 0.2)))
    np.testing.assert_allclose(found[3:6], data.xmat[1].reshape(3, 3).T @ (0.1, 0.0, 0.2), atol=1e-12)


def test_pushes_add_up_and_end(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    first = Push(0.0, duration=0.1, force=FORCE, link="arm", point=POINT)
    second = Push(0.05, duration=0.1, torque=(0.0, 0.1, 0.2))
    alone = [applied(model, data, k, push) for k, push in ((0, first), (15, second))]
    np.testing.assert_allclose(applied(model, data, 15, first, second), sum(alone), atol=1e-14)
    np.testing.assert_array_equal(applied(model, data, 25, first, second), alone[1])
    assert not applied(model, data, 30, first, second).any()


def test_a_push_begins_and_ends_with_a_tick(model: mujoco.MjModel) -> None:
    (push,) = wrenches(model, Push(0.1, duration=0.2, force=FORCE, link="arm"))
    assert (push.begin, push.end) == (20, 60)
    assert wrenches(model, Push(0.1012, duration=0.001, force=FORCE)) == ()  # it is over before a tick begins
    assert wrenches(model, Push(0.0, duration=1.0)) == ()


def test_a_push_on_the_pen_is_seen_by_the_observer() -> None:
    push = {
        "kind": "push",
        "time": 9.0,
        "duration": 5.0,
        "force": [0.0, 0.8, 0.0],
        "link": "link4",
        "point": [0.3, 0, 0],
    }
    run = skylimb.run("free_flight", controller="impedance", set={"events": [push]})
    seen = run.log.external_force_estimate.sel(axis="y", time=slice(11.0, 14.0)).mean()
    assert float(seen) == pytest.approx(0.8, abs=0.08)


def test_nonsense_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"point = \[0\.1, 0, 0\] m needs a link"):
        Push(0.0, duration=1.0, point=(0.1, 0, 0))
    push = {"kind": "push", "time": 1.0, "duration": 1.0, "force": [1.0, 0.0, 0.0], "link": "link9"}
    with pytest.raises(UnknownNameError, match="unknown link of a push 'link9'; did you mean 'link"):
        skylimb.run("free_flight", set={"events": [push]})
