"""A surface of the user's own: one file, from its keys to a flight, and every mistake in one line."""

import json
import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import skylimb
from skylimb.apps.cli import main
from skylimb.base.errors import ConfigError
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import take_off
from skylimb.simulation.surfaces import surface_from_mapping

EXAMPLES = Path(__file__).parents[3] / "examples" / "surfaces"


def own(file, **keys) -> Any:
    return surface_from_mapping({"kind": str(file), **keys})


def surface(folder, text, **keys):
    (folder / "wall.py").write_text(text)
    return own(folder / "wall.py", **keys)


WAVES = """
from skylimb.symbolic import cos, sin

def height(u, v, keys):
    return 0.02 * sin(5.0 * u) * cos(4.0 * v) + 0.3
"""


def test_derivatives_are_exact_and_the_origin_is_on_it(tmp_path, rng):
    wall = surface(tmp_path, WAVES)
    u, v = rng.uniform(-1.0, 1.0, (2, 100))
    h, hu, hv, huu, huv, hvv = wall.shape.derivatives(u, v)
    np.testing.assert_allclose(h, 0.02 * np.sin(5 * u) * np.cos(4 * v), atol=1e-15)
    np.testing.assert_allclose(hu, 0.1 * np.cos(5 * u) * np.cos(4 * v), atol=1e-15)
    np.testing.assert_allclose(hv, -0.08 * np.sin(5 * u) * np.sin(4 * v), atol=1e-15)
    np.testing.assert_allclose(huu, -0.5 * np.sin(5 * u) * np.cos(4 * v), atol=1e-14)
    np.testing.assert_allclose(huv, -0.4 * np.cos(5 * u) * np.sin(4 * v), atol=1e-14)
    np.testing.assert_allclose(hvv, -0.32 * np.sin(5 * u) * np.cos(4 * v), atol=1e-14)
    assert wall.tightest_hollow == pytest.approx(1.0 / 0.5, rel=0.05)


def test_a_torus_is_round_both_ways(rng):
    wall = own(EXAMPLES / "torus.py", ring=0.3, tube=0.2)
    around, across = rng.uniform(-1.0, 1.0, (2, 50))
    outward = np.stack(
        [-np.cos(around) * np.cos(across), np.sin(around) * np.cos(across), np.sin(across)], -1
    )
    middle = np.stack([0.5 - 0.3 * np.cos(around), 0.3 * np.sin(around), np.zeros(50)], axis=-1)
    foot, normal = wall.local_closest(middle + 0.25 * outward)
    np.testing.assert_allclose(foot, middle + 0.2 * outward, atol=1e-14)
    np.testing.assert_allclose(normal, outward, atol=1e-14)
    u, v = middle[:, 1] + 0.2 * outward[:, 1], 0.2 * outward[:, 2]
    np.testing.assert_allclose(wall.height(u, v), middle[:, 0] + 0.2 * outward[:, 0], atol=1e-9)
    assert wall.tightest_hollow > 1e3


def test_keys_stand_beside_every_surfaces_own():
    wall = own(EXAMPLES / "saddle.py", bend=0.7, friction=0.2)
    assert (wall.bend, wall.friction) == (0.7, 0.2)
    assert wall.height(0.1, 0.2) == pytest.approx(0.35 * (0.01 - 0.04))
    assert pickle.loads(pickle.dumps(wall)) == wall
    with pytest.raises(ConfigError, match=r"surface.bend = 3 1/m is outside of -2 .. 2 1/m"):
        own(EXAMPLES / "saddle.py", bend=3.0)
    with pytest.raises(ConfigError, match=r"did you mean 'surface.bend'"):
        own(EXAMPLES / "saddle.py", bent=0.3)


def test_keys_are_no_part_of_the_machine_code():
    walls = [own(EXAMPLES / "saddle.py", bend=bend) for bend in (0.1, 0.2)]
    assert walls[0].shape.source == walls[1].shape.source
    assert walls[0].shape.native is walls[1].shape.native


def test_it_flies_and_flies_again_from_its_run(tmp_path):
    folder = tmp_path / "mine"
    shutil.copytree(EXAMPLES, folder)
    out = tmp_path / "run"
    words = ["run", str(folder / "saddle.toml"), "--set", "stop_at=12.0", "--no-video", "--out", str(out)]
    assert main(words) == 0  # stopped when it was asked to
    shutil.rmtree(folder)
    [copy] = out.glob("sources/saddle-*/saddle.py")
    assert copy.read_bytes() == (EXAMPLES / "saddle.py").read_bytes()
    again = skylimb.run(str(out / "config.toml"))
    with xr.open_dataset(out / "log.nc") as log:
        np.testing.assert_array_equal(again.log.configuration, log.configuration)
        np.testing.assert_array_equal(again.log.surface_gap, log.surface_gap)
    touching = again.log.contact.values > 0.0
    assert touching.sum() > 200
    assert np.abs(again.log.surface_gap.values[touching]).max() < 2e-3
    described = json.loads(again.log.attrs["surface"])
    assert described["kind"] == "saddle.py"
    assert np.shape(described["height"]) == (len(described["u"]), len(described["v"]))


MISTAKES = {
    "neither": ("x = 1", ["neither", "height(u, v, keys)"]),
    "both": (f"{WAVES}\ndef closest(point, keys): ...", ["both"]),
    "arity": ("def height(u, v): return 0.0 * u", ["wall.py", "positional arguments"]),
    "numbers": (
        "import math\ndef height(u, v, keys): return math.sin(u)",
        ["line 2", "the functions of math", "skylimb.symbolic"],
    ),
    "decides": ("def height(u, v, keys): return u if u > 0 else 0", ["line 1", "skylimb.symbolic.where"]),
    "two": ("def height(u, v, keys): return u, v", ["height should return one number", "1 and 1"]),
    "nothing": ("def height(u, v, keys): pass", ["wall.py"]),
    "random": (
        "import random\ndef height(u, v, keys): return 0.01 * random.random() * u",
        ["wall.py", "another one when its function is called again", "with a seed"],
    ),
    "nan": (
        "from skylimb.symbolic import sqrt\ndef height(u, v, keys): return sqrt(0.5 - u * u)",
        ["its height is no finite number at u = ", "v = "],
    ),
    "cone": (
        "from skylimb.symbolic import sqrt\ndef height(u, v, keys): return 0.1 * sqrt(u * u + v * v)",
        ["its slope is no finite number at u = 0 m, v = 0 m"],
    ),
    "steep": ("def height(u, v, keys): return 20.0 * u", ["slope is 20", "10 is the most"]),
    "jump": (
        "from skylimb.symbolic import where\ndef height(u, v, keys): return where(u > 0.31, 0.1, 0.0)",
        ["its height jumps by 0.1 at u = 0.3"],
    ),
    "kink": (
        "from skylimb.symbolic import where\ndef height(u, v, keys): return where(v > 0.31, v - 0.31, 0.0)",
        ["its slope along v jumps by 1 at", "v = 0.3"],
    ),
    "imports": ("import nowhere_at_all", ["line 1", "nowhere_at_all"]),
    "syntax": ("def height(u, v, keys) return u", ["line 1"]),
    "key": (
        "from dataclasses import dataclass\n@dataclass(frozen=True)\nclass Keys:\n    size: float = 1.0\n"
        "def height(u, v, keys): return 0.1 * u",
        ["every surface has 'size'"],
    ),
    "keys": (
        "class Keys:\n    rise = 1.0\ndef height(u, v, keys): return 0.1 * u",
        ["surface 'wall.py': Keys should be a class with @configuration", "a class Keys without it"],
    ),
    "half": (
        "def closest(point, keys): return point",
        ["closest should return foot and normal", "returned 3"],
    ),
    "turns": (
        "from skylimb.symbolic import vector\ndef closest(point, keys):\n"
        "    foot = vector(0.0, point[1], point[2])\n    ray = point - foot\n"
        "    return foot, ray / (ray[0] * ray[0]) ** 0.5",
        ["closest is not the point"],
    ),
    "inward": (
        "from skylimb.symbolic import vector, where\ndef closest(point, keys):\n"
        "    foot = vector(0.0, point[1], point[2])\n    s = where(point[0] > 0.0, 1.0, -1.0)\n"
        "    return foot, vector(s, 0.0, 0.0)",
        ["must stay outward"],
    ),
    "elsewhere": (
        "from skylimb.symbolic import vector\ndef closest(point, keys):\n"
        "    return vector(0.2, point[1], point[2]), vector(-1.0, 0.0, 0.0)",
        ["the origin", "0.2 m away"],
    ),
    "long": (
        "from skylimb.symbolic import vector\ndef closest(point, keys):\n"
        "    return vector(0.0, point[1], point[2]), vector(-2.0, 0.0, 0.0)",
        ["a normal whose length is not 1"],
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_in_one_line_and_nothing_is_written(tmp_path, capsys, name):
    text, words = MISTAKES[name]
    (tmp_path / "wall.py").write_text(text)
    (tmp_path / "wall.toml").write_text('[surface]\nkind = "wall.py"\n')
    out = tmp_path / "out"
    assert main(["run", str(tmp_path / "wall.toml"), "--no-video", "--out", str(out)]) == 2
    [line] = capsys.readouterr().err.strip().splitlines()
    for word in words:
        assert word in line, line
    assert not out.exists()


def test_a_file_that_is_not_there_is_named_with_the_nearest():
    with pytest.raises(ConfigError, match=r"no such file.*sadle.py.*did you mean.*saddle.py"):
        own(EXAMPLES / "sadle.py")


def test_many_kinds_fly_in_one_batch_as_alone_and_with_every_driver(tmp_path):
    (tmp_path / "torus.toml").write_text(
        f'[surface]\nkind = "{(EXAMPLES / "torus.py").as_posix()}"\nposition = [1.5, 0.0, 1.2]\nring = 1.0\n'
        'tube = 1.5\n[controller]\npreset = "following"\n'
    )
    flights = [
        take_off(name, (None,), 0, {"stop_at": 14.0, **more})[0]
        for name, more in (
            ("sine_gentle", {}),
            (str(EXAMPLES / "saddle.toml"), {}),
            (str(EXAMPLES / "saddle.toml"), {"surface.bend": -0.3}),
            (str(tmp_path / "torus.toml"), {}),
        )
    ]
    together = fly_native(flights)
    for takeoff, flight in zip(flights, together, strict=True):
        np.testing.assert_array_equal(flight.signals, fly_native([takeoff])[0].signals)
        np.testing.assert_array_equal(flight.signals, fly_here(takeoff).signals)
        assert (flight.signal("contact_duty") > 0.0).sum() > 100


@pytest.mark.parametrize("file", ["saddle.py", "torus.py"])
def test_without_a_compiler_it_is_read_and_checked_but_does_not_fly(tmp_path, file):
    (tmp_path / "wall.toml").write_text(f'[surface]\nkind = "{(EXAMPLES / file).as_posix()}"\n')
    script = (
        "import sys\nfrom skylimb.apps.cli import main\nfrom skylimb.simulation import compiling\n"
        "from skylimb.flight.experiments.experiment import load_experiment\ncompiling.compilers = list\n"
        "load_experiment(sys.argv[1])\n"
        "sys.exit(main(['run', sys.argv[1], '--no-video', '--out', sys.argv[2]]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "wall.toml"), str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "XDG_CACHE_HOME": str(tmp_path), "HOME": str(tmp_path)},
    )
    assert done.returncode == 2, done.stderr
    [line] = done.stderr.strip().splitlines()
    assert "need a C compiler" in line
    assert not (tmp_path / "out").exists()


def test_an_edited_file_is_another_surface(tmp_path):
    before = surface(tmp_path, WAVES)
    after = surface(tmp_path, WAVES.replace("0.02", "0.03"))
    assert before != after
    assert after.height(0.3, 0.0) == pytest.approx(1.5 * before.height(0.3, 0.0))
