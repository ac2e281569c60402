"""A ball before a surface in the engine, and the flight of a module's take-off."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from skylimb.analysis.scores.user_scores import scored
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.simulated_run import simulated_run
from skylimb.simulation.contact import add_contact_pair, set_contact_options, tune_contact_pair
from skylimb.simulation.surface_bodies import add_surface

TIP_RADIUS = 0.004


def make_scene(surface, radius=TIP_RADIUS):
    spec = mujoco.MjSpec()
    set_contact_options(spec, 1e-3)
    spec.option.gravity = (0, 0, 0)
    parts = add_surface(spec, surface)
    body = spec.worldbody.add_body(name="tip")
    body.add_freejoint()
    body.add_geom(
        name="tip", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], mass=1.0, contype=0, conaffinity=0
    )
    add_contact_pair(spec, "tip", parts.geoms[0], surface.contact)
    model = spec.compile()
    tune_contact_pair(model, surface.contact)
    data = mujoco.MjData(model)

    def touch(center):
        """Contact distances and outward normals of a ball at `center`."""
        data.qpos[-7:-4] = center
        mujoco.mj_forward(model, data)
        tip = model.geom("tip").id
        found = []
        for i in range(data.ncon):
            contact = data.contact[i]
            found.append(
                (contact.dist, contact.frame[:3] * (1.0 if contact.geom[1] == tip else -1.0), contact.pos)
            )
        return found

    return SimpleNamespace(
        surface=surface, model=model, data=data, parts=parts, touch=touch, radius=radius, spec=spec
    )


@pytest.fixture
def scene_of():
    return make_scene


@pytest.fixture
def gap_of():
    """Distance of a point from a surface in the engine, m, at an angle of its hinge where it has one."""

    def build(surface):
        spec = mujoco.MjSpec()
        parts = add_surface(spec, surface)
        ball = spec.worldbody.add_body(mocap=True, name="ball")
        ball.add_geom(name="ball", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[TIP_RADIUS, 0.0, 0.0])
        model = spec.compile()
        data = mujoco.MjData(model)
        touched = [model.geom(name).id for name in parts.geoms]

        def gap(point, angle=0.0):
            data.qpos[:], data.mocap_pos[0] = angle, point
            mujoco.mj_kinematics(model, data)
            ball, between = model.geom("ball").id, np.zeros(6)
            gaps = [mujoco.mj_geomDistance(model, data, one, ball, 10.0, between) for one in touched]
            return min(gaps) + TIP_RADIUS

        return gap

    return build


@pytest.fixture(scope="module")
def flight(takeoff):
    """The flight of a module's `takeoff`."""
    return fly_native([takeoff])[0]


@pytest.fixture(scope="module")
def log(takeoff, flight):
    """Its log."""
    return scored(simulated_run(takeoff, flight)).log


@pytest.fixture
def rng():
    return np.random.default_rng(20240611)
