"""The collision function: both forms agree, threads agree, and other ellipsoids stay the engine's."""

import json
import os
import subprocess
import sys

import mujoco
import mujoco.batch
import numpy as np
import pytest

from skylimb.simulation.surfaces import SineWall
from skylimb.simulation.surfaces.collision import install_collision

SLIDE = """
import json, sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from conftest import make_scene
from skylimb.simulation.surfaces import HeightMap, Ramp, SineWall
from skylimb.simulation.surfaces.collision import install_collision
import mujoco
rows = []
relief = tuple(tuple(0.3 * np.sin(0.9 * i) * np.cos(0.7 * j) for j in range(8)) for i in range(8))
for surface in (SineWall(), Ramp(offset=0.05), HeightMap(heights=relief, size=(1.0, 1.0))):
    scene = make_scene(surface)
    foot = surface.to_world(np.array([surface.height(-0.05, 0.02), -0.05, 0.02]))
    scene.touch(foot + 0.0039 * surface.normal(foot))
    scene.data.qvel[:3] = (0.02, 0.15, 0.05)
    scene.data.xfrc_applied[-1, :3] = (1.5, 0.3, 0.1)
    mujoco.mj_step(scene.model, scene.data, nstep=150)
    rows.append(scene.data.qpos.tolist())
print(json.dumps([install_collision(), rows]))
"""


def slide(form):
    folder = os.path.dirname(__file__)
    done = subprocess.run(
        [sys.executable, "-c", SLIDE, folder],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "SKYLIMB_COLLISION": form},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_python_form_gives_the_same_motion():
    used, plain = slide("python")
    assert used == "python"
    _, compiled = slide("compiled")
    np.testing.assert_allclose(plain, compiled, rtol=0, atol=1e-9)


def test_without_a_compiler_the_python_form_serves_and_says_so(tmp_path):
    code = "from skylimb.simulation.surfaces.collision import install_collision; print(install_collision())"
    env = {
        **os.environ,
        "SKYLIMB_COLLISION": "compiled",
        "XDG_CACHE_HOME": str(tmp_path),
        "HOME": str(tmp_path),
        "PATH": "",
        "CC": "no-such-compiler",
    }
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=env)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() in ("python", "compiled")  # compiled where the ziglang package is installed
    if done.stdout.strip() == "python":
        assert "no-such-compiler" in done.stderr
        assert "slower" in done.stderr


def test_other_ellipsoids_still_collide_as_the_engine_says():
    install_collision()
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_ELLIPSOID, size=[0.3, 0.2, 0.1])
    ball = spec.worldbody.add_body(pos=[0.0, 0.0, 0.149])
    ball.add_freejoint()
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.05, 0, 0])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 1
    assert data.contact[0].dist == pytest.approx(-0.001, abs=1e-6)


def test_many_threads_give_the_same_bits(scene_of):
    surface = SineWall()
    scene = scene_of(surface)
    foot = surface.to_world(np.zeros(3))
    starts = [foot + (0.0039 - 1e-5 * k) * surface.normal(foot) for k in range(6)]

    def run(threads):
        batch = mujoco.batch.Batch(scene.model, len(starts), threads)
        batch.qpos[:, :3] = starts
        batch.qvel[:, :3] = (0.05, 0.15, 0.02)
        batch.step(nstep=100)
        return batch.qpos.copy()

    assert np.array_equal(run(1), run(2))
