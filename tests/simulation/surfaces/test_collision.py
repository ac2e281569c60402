"""The collision function: what it needs, threads agree, and other ellipsoids stay the engine's."""

import os
import subprocess
import sys
from pathlib import Path

import mujoco
import mujoco.batch
import numpy as np
import pytest

from skylimb.errors import CompileError
from skylimb.simulation import compiling
from skylimb.simulation.surfaces import SineWall, collision
from skylimb.simulation.surfaces.collision import install_collision

WITHOUT_COMPILER = """
import sys
from skylimb.cli import main
from skylimb.simulation import compiling
compiling.compilers = list
sys.exit(main(["run", "sine_gentle", "--no-video", "--out", sys.argv[1]]))
"""


def test_without_a_compiler_a_surface_with_a_shape_of_its_own_says_what_to_install(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_COMPILER, str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "XDG_CACHE_HOME": str(tmp_path), "HOME": str(tmp_path)},
    )
    assert done.returncode == 2, done.stderr
    [line] = done.stderr.strip().splitlines()
    assert "need a C compiler" in line
    assert "pip install 'skylimb[compiler]'" in line


def test_a_collision_function_that_cannot_be_built_leaves_the_engines_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    install_collision()
    slot = collision._SPHERE * collision._KINDS + collision._ELLIPSOID
    before = collision._collision_table()[slot]

    def refuse(*_: object) -> Path:
        raise CompileError("refused")

    monkeypatch.setattr(collision, "built_library", refuse)
    with pytest.raises(CompileError, match="need a C compiler: refused"):
        install_collision.__wrapped__()
    assert collision._collision_table()[slot] == before


def test_ziglang_builds_it_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    zig = [command for command in compiling.compilers() if "ziglang" in command]
    if not zig:
        pytest.skip("the ziglang package is not installed")
    monkeypatch.setattr(compiling, "compilers", lambda: zig)
    source = tmp_path / "collision.c"
    source.write_text("#define MARK 1.0\n" + collision._SOURCE.read_text("utf-8"))
    compiling.compile_c([source], tmp_path / "collision.so", compiling.FLAGS)
    assert compiling.load_library(tmp_path / "collision.so").skylimb_collide


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
