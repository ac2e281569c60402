"""The collision function: what it needs, threads agree, and other ellipsoids stay the engine's."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import mujoco
import mujoco.batch
import numpy as np
import pytest

from skylimb.base.errors import CompileError
from skylimb.simulation import compiling
from skylimb.simulation.compiling import FLAGS
from skylimb.simulation.surface_bodies import SLOT, collision_table, install
from skylimb.simulation.surfaces import CurvedSurface, HeightMap, SineWall, Step, collision
from skylimb.simulation.surfaces.shape import NativeShape

RELIEF = tuple(tuple(0.5 * np.sin(0.9 * i) * np.cos(0.7 * j) for j in range(10)) for i in range(12))

WITHOUT_COMPILER = """
import sys
from skylimb.apps.cli import main
from skylimb.simulation import compiling
compiling.compilers = list
sys.exit(main(["run", "sine_gentle", "--no-video", "--out", sys.argv[1]]))
"""


def of(surface: CurvedSurface) -> NativeShape:
    shape = surface.shape
    assert isinstance(shape, NativeShape)
    return shape


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


def test_a_shape_that_cannot_be_built_leaves_the_table_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    before = collision_table()[SLOT]

    def refuse(*_: object) -> Path:
        raise CompileError("refused")

    monkeypatch.setattr(collision, "built_library", refuse)
    with pytest.raises(CompileError, match="need a C compiler: refused"):
        collision.kind_of("/* a shape that nobody has met */")
    assert collision_table()[SLOT] == before


@pytest.mark.parametrize(
    "surface",
    [
        HeightMap(heights=RELIEF),
        pytest.param(SineWall(), marks=pytest.mark.slow),
        pytest.param(Step(), marks=pytest.mark.slow),
    ],
)
def test_ziglang_builds_it_too(surface: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    zig = [command for command in compiling.compilers() if "ziglang" in command]
    if not zig:
        pytest.skip("the ziglang package is not installed")
    monkeypatch.setattr(compiling, "compilers", lambda: zig)
    monkeypatch.setattr(compiling, "FLAGS", FLAGS)  # as a user has them; without, it adds a sanitizer
    monkeypatch.setattr(compiling, "cache_folder", lambda: tmp_path)
    _, text = collision.whole_source(of(surface).source)
    library = compiling.load_library(compiling.built_library("collision", "collision", text))
    assert library.skylimb_closest


def ball_on(ellipsoid):
    """A ball 1 mm deep in the top of an ellipsoid 0.1 m high."""
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_ELLIPSOID, size=[0.3, 0.2, 0.1], **ellipsoid)
    ball = spec.worldbody.add_body(pos=[0.0, 0.0, 0.149])
    ball.add_freejoint()
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.05, 0, 0])
    return spec


def distances(spec):
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return [contact.dist for contact in data.contact]


def test_other_ellipsoids_still_collide_as_the_engine_says():
    for surface in (SineWall(), Step()):
        install(of(surface).native.library)
    assert distances(ball_on({})) == pytest.approx([-0.001], abs=1e-6)
    # A model from elsewhere, with a surface that this process does not know.
    assert distances(ball_on({"userdata": [12345.0]})) == pytest.approx([-0.001], abs=1e-6)


@pytest.mark.parametrize("numbers", [[], [1.0], [4.0, 1e9, 0.0, 0.0, 0.01, 0.0], [4.0, 4.0, 0.0, 0.0, 0.01]])
def test_numbers_that_are_no_surface_are_not_touched(numbers):
    for surface in (HeightMap(heights=RELIEF), SineWall()):
        mark, library = of(surface).native
        install(library)
        spec = ball_on({"userdata": [mark]})
        spec.add_numeric(name="shape", data=[mark, *numbers])
        assert distances(spec) == []


def test_a_place_that_is_no_number_is_nowhere():
    for surface in (HeightMap(heights=RELIEF), SineWall(), Step()):
        foot, _ = surface.local_closest(np.array([[np.nan, 0.0, 0.0], [-0.01, np.nan, np.nan]]))
        assert not np.isfinite(foot).all(axis=1).any()


def test_surfaces_of_every_kind_fly_in_one_process(scene_of):
    surfaces = [SineWall(), Step(), HeightMap(heights=RELIEF, relief=0.01), SineWall(wavelength=2.0)]
    scenes = [scene_of(surface) for surface in surfaces]
    for surface, scene in [*zip(surfaces, scenes, strict=True)] * 2:
        foot = surface.to_world(np.zeros(3))
        [(distance, outward, _)] = scene.touch(foot + 0.003 * surface.normal(foot))
        assert distance == pytest.approx(-0.001, abs=1e-12)
        np.testing.assert_allclose(outward, surface.normal(foot), atol=1e-12)


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
