"""A scene with one ball before a surface."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from skylimb.simulation.contact import add_contact_pair, set_contact_options, tune_contact_pair

TIP_RADIUS = 0.004


def make_scene(surface, radius=TIP_RADIUS):
    spec = mujoco.MjSpec()
    set_contact_options(spec, 1e-3)
    spec.option.gravity = (0, 0, 0)
    parts = surface.attach(spec)
    body = spec.worldbody.add_body(name="tip")
    body.add_freejoint()
    body.add_geom(
        name="tip", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], mass=1.0, contype=0, conaffinity=0
    )
    add_contact_pair(spec, "tip", parts.geom, surface.contact)
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
def rng():
    return np.random.default_rng(20240611)
