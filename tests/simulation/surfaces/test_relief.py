"""Height maps and meshes: what is read, how it lies on the wall, and what is refused."""

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.simulation.surfaces import HeightMap, MeshSurface, surface_from_mapping

trimesh = pytest.importorskip("trimesh")


def test_an_image_lies_as_a_viewer_sees_it(tmp_path):
    from PIL import Image

    pixels = np.zeros((40, 60), dtype=np.uint8)
    pixels[:10, :20] = 200  # bright: top left
    Image.fromarray(pixels).save(tmp_path / "corner.png")
    wall = HeightMap(file=str(tmp_path / "corner.png"), size=(1.2, 0.8), relief=0.1)
    # Seen from the robot, which looks along +x, left is +y; bright stands out toward it.
    top_left = wall.distance_along(np.array([0.0, 0.5, 1.3]))
    elsewhere = wall.distance_along(np.array([[0.0, -0.5, 1.3], [0.0, 0.5, 0.7]]))
    np.testing.assert_allclose(elsewhere - top_left, 0.1 * 200 / 255, atol=1e-4)


def test_the_surface_goes_through_given_heights():
    rng = np.random.default_rng(3)
    heights = rng.uniform(0, 0.02, (9, 11))
    wall = HeightMap(heights=tuple(map(tuple, heights)), size=(1.0, 0.8), relief=1.0)
    u, v = np.meshgrid(np.linspace(0.5, -0.5, 11), np.linspace(0.4, -0.4, 9))
    relief = -(wall.height(u, v))
    np.testing.assert_allclose(relief - relief[4, 5], heights - heights[4, 5], atol=1e-6)


@pytest.mark.parametrize("suffix", [".npy", ".csv", ".txt"])
def test_numbers_are_read_from_files(tmp_path, suffix):
    values = np.random.default_rng(0).uniform(size=(6, 7))
    path = tmp_path / f"relief{suffix}"
    np.save(path, values) if suffix == ".npy" else np.savetxt(
        path, values, delimiter="," if suffix == ".csv" else " "
    )
    assert np.allclose(HeightMap(file=str(path)).values, values)


def test_smoothing_takes_the_edge_off():
    rows = tuple(tuple(float((i + j) % 2) for j in range(40)) for i in range(40))
    rough = HeightMap(heights=rows, size=(1.0, 1.0), relief=0.01)
    smooth = HeightMap(heights=rows, size=(1.0, 1.0), relief=0.01, smoothing=0.05)
    assert smooth.tightest_hollow > 10 * rough.tightest_hollow


def rows_with(value):
    rows = np.zeros((6, 6))
    rows[2, 3] = value
    return tuple(map(tuple, rows))


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"heights": rows_with(np.nan)}, ["surface.heights = nan (entry 3 of 6, 4 of 6)"]),
        ({"heights": ((0.0,) * 5,) * 3}, ["3 x 5", "4 or more"]),
        ({"heights": ((0.0, 1.0), (0.0,))}, ["different lengths"]),
        ({}, ["surface.file", "surface.heights"]),
        ({"file": "nowhere.png"}, ["nowhere.png", "no such file"]),
        ({"file": "nowhere.gif"}, [".gif", ".png"]),
        ({"heights": rows_with(1.0), "resolution": 0.0005}, ["surface.resolution", "grid points"]),
    ],
)
def test_bad_height_maps_are_named(table, words):
    with pytest.raises(ConfigError) as caught:
        surface_from_mapping({"kind": "heightmap", **table})
    for word in words:
        assert word in str(caught.value)


def test_a_file_with_nan_or_rubbish_is_named(tmp_path):
    values = np.zeros((5, 5))
    values[1, 1] = np.nan
    np.save(tmp_path / "holes.npy", values)
    with pytest.raises(ConfigError, match="row 2, column 2"):
        HeightMap(file=str(tmp_path / "holes.npy"))
    (tmp_path / "broken.png").write_bytes(b"not an image")
    with pytest.raises(ConfigError, match="cannot be read"):
        HeightMap(file=str(tmp_path / "broken.png"))


def test_mesh_front_is_the_mesh(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=6, radius=0.5)
    ball.export(tmp_path / "ball.obj")
    wall = MeshSurface(file=str(tmp_path / "ball.obj"), size=(0.5, 0.5))
    u, v = np.random.default_rng(1).uniform(-0.24, 0.24, (2, 400))
    np.testing.assert_allclose(wall.height(u, v), 0.5 - np.sqrt(0.25 - u**2 - v**2), atol=2e-4)


def test_mesh_turns_and_scales(tmp_path):
    box = trimesh.creation.box((1000.0, 400.0, 600.0))
    box.export(tmp_path / "box.stl")
    wall = MeshSurface(
        file=str(tmp_path / "box.stl"), scale=0.001, mesh_rpy=(0.0, 0.0, 0.5 * np.pi), size=(0.9, 0.5)
    )
    assert np.ptp(wall.triangles, axis=(0, 1)) == pytest.approx([0.4, 1.0, 0.6])


@pytest.fixture
def files(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.6)
    ball.export(tmp_path / "ball.stl")
    millimetres = ball.copy()
    millimetres.apply_scale(1000.0)
    millimetres.export(tmp_path / "millimetres.stl")
    half = ball.copy()
    half.update_faces(half.triangles_center[:, 0] < 0.0)
    half.export(tmp_path / "half.stl")
    (tmp_path / "spoilt.obj").write_text(
        "v 0 -1 -1\nv 0 1 -1\nv 0 1 1\nv 0 -1 1\nv 0 nan 0\nf 1 2 3\nf 1 3 4\nf 1 2 5\n"
    )
    (tmp_path / "empty.obj").write_text("# nothing\n")
    (tmp_path / "broken.stl").write_bytes(b"solid rubbish\nfacet")
    stairs = trimesh.util.concatenate(
        [trimesh.creation.box((0.2, 0.5, 1.0)), trimesh.creation.box((0.3, 0.2, 1.0))]
    )
    stairs.export(tmp_path / "stairs.stl")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "more", "words"),
    [
        ("nowhere.stl", {}, ["nowhere.stl", "no such file"]),
        ("empty.obj", {}, ["empty.obj", "empty|cannot be read"]),
        ("broken.stl", {}, ["broken.stl", "empty|cannot be read"]),
        ("spoilt.obj", {"allow_open": True}, ["not finite numbers, the first is corner 5: [0.0, nan, 0.0]"]),
        ("half.stl", {}, ["half.stl", "open", "surface.allow_open"]),
        ("millimetres.stl", {}, ["millimetres", "surface.scale = 0.001"]),
        ("ball.stl", {"size": [1.1, 1.1]}, ["does not cover", "1.2 m"]),
        ("stairs.stl", {"size": [0.45, 0.45]}, ["off by", "surface.tolerance", "surface.resolution"]),
    ],
)
def test_bad_meshes_are_named(files, name, more, words):
    table = {"kind": "mesh", "file": str(files / name), "size": [0.5, 0.5], **more}
    with pytest.raises(ConfigError) as caught:
        surface_from_mapping(table).describe()
    for word in words:
        assert any(option in str(caught.value) for option in word.split("|")), str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(caught.value).count("mesh '") == 1


def test_an_open_sheet_is_welcome_when_asked_for(files):
    wall = MeshSurface(file=str(files / "half.stl"), allow_open=True, size=(0.4, 0.4))
    assert wall.height(0.0, 0.0) == pytest.approx(0.0, abs=1e-9)
