"""What holds for every surface: physics and analysis see one geometry with one touch and a smooth normal."""

import copy
import json
import pickle
from pathlib import Path

import mujoco
import numpy as np
import pytest

from skylimb.simulation.surfaces import (
    SURFACES,
    Board,
    Corrugated,
    Cylinder,
    HeightMap,
    MeshSurface,
    Pipe,
    Post,
    Ramp,
    Ridge,
    SineWall,
    Sphere,
    Step,
    surface_from_mapping,
)

RELIEF = tuple(tuple(0.5 * np.sin(0.9 * i) * np.cos(0.7 * j) for j in range(10)) for i in range(12))


@pytest.fixture(scope="module")
def egg(tmp_path_factory):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.creation.icosphere(subdivisions=5, radius=0.8)
    mesh.apply_scale([1.0, 1.2, 0.9])
    path = tmp_path_factory.mktemp("mesh") / "egg.stl"
    mesh.export(path)
    return str(path)


SHAPES = {
    "board": lambda egg: Board(slope=0.35, pitch=-0.1),
    "cylinder": lambda egg: Cylinder(),
    "cylinder_moving": lambda egg: Cylinder(advance_distance=0.1, slope=0.2),
    "cylinder_hollow": lambda egg: Cylinder(concave=True, size=(1.6, 2.0), roll=0.3),
    "pipe": lambda egg: Pipe(),
    "post": lambda egg: Post(roll=0.2),
    "sphere": lambda egg: Sphere(),
    "sine_gentle": lambda egg: SineWall(),
    "sine_steep": lambda egg: SineWall(wavelength=0.8, phase=-0.5 * np.pi, roll=0.4, slope=-0.2),
    "corrugated": lambda egg: Corrugated(),
    "step": lambda egg: Step(),
    "step_down": lambda egg: Step(rise=-0.01, edge_radius=0.0, offset=0.1),
    "ridge": lambda egg: Ridge(edge_radius=0.0),
    "ramp": lambda egg: Ramp(),
    "ramp_moving_ceiling": lambda egg: Ramp(contact_axis=(0.0, 0.0, 1.0), sway_amplitude=0.01),
    "heightmap": lambda egg: HeightMap(heights=RELIEF, size=(1.2, 1.0), relief=0.1, slope=0.1),
    "mesh": lambda egg: MeshSurface(file=egg, size=(0.7, 0.7)),
    "own_height": lambda egg: own("saddle.py", bend=0.8, roll=0.5, slope=0.1),
    "own_closest": lambda egg: own("torus.py", ring=0.5, size=(0.6, 0.6)),
}
OWN = Path(__file__).parents[3] / "examples" / "surfaces"


def own(file, **keys):
    return surface_from_mapping({"kind": str(OWN / file), **keys})


@pytest.fixture(params=SHAPES, scope="module")
def surface(request, egg):
    return SHAPES[request.param](egg)


def random_feet(surface, rng, count):
    """Random surface points, W, away from the border."""
    half = 0.45 * np.minimum(surface.size, 1.5 * getattr(surface, "radius", np.inf))
    u, v = rng.uniform(-half, half, (count, 2)).T
    return surface.to_world(np.stack([surface.height(u, v), u, v], axis=-1))


def test_every_kind_is_tried(egg):
    # A valve's lever and a hole are met from the side: test_valve.py, test_hole.py.
    shipped = {SHAPES[name](egg).kind for name in SHAPES if not name.startswith("own")}
    assert shipped == set(SURFACES) - {"hole", "valve"}


def test_physics_and_analysis_agree_with_one_touch(surface, scene_of, rng):
    scene = scene_of(surface)
    feet = random_feet(surface, rng, 60)
    centers = feet + surface.normal(feet) * rng.uniform(0.001, 0.0039, (60, 1))
    gaps, normals = surface.signed_distance(centers), surface.normal(centers)
    for center, gap, normal in zip(centers, gaps, normals, strict=True):
        found = scene.touch(center)
        assert len(found) == 1
        distance, outward, point = found[0]
        assert distance == pytest.approx(gap - scene.radius, abs=1e-12)
        np.testing.assert_allclose(outward, normal, atol=1e-12)
        np.testing.assert_allclose(point, center - normal * 0.5 * (gap + scene.radius), atol=1e-12)


def test_contact_goes_on_beyond_what_is_drawn(surface, scene_of, rng):
    scene = scene_of(surface)
    side, far = rng.choice([-1.0, 1.0], (2, 20)), rng.uniform(1.02, 1.5, (2, 20))
    u, v = 0.5 * np.array(surface.size)[:, None] * side * far
    w = surface.height(u, v)
    for foot in surface.to_world(np.stack([w, u, v], axis=-1)[np.isfinite(w)]):
        [(distance, outward, _)] = scene.touch(foot + 0.003 * surface.normal(foot))
        assert distance == pytest.approx(0.003 - scene.radius, abs=1e-7)
        np.testing.assert_allclose(outward, surface.normal(foot), atol=1e-6)


def test_closest_point_is_the_closest_and_the_normal_its_gradient(surface, rng):
    feet = random_feet(surface, rng, 40)
    # Beyond a hollow's centre of curvature several points may be locally closest, so stay on this side of it.
    most = min(0.05, 0.5 * surface.tightest_hollow)
    points = feet + surface.normal(feet) * rng.uniform(-0.004, most, (40, 1))
    local = surface.to_local(points)
    foot, normal = surface.local_closest(local)
    np.testing.assert_allclose(foot[:, 0], surface.height(foot[:, 1], foot[:, 2]), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=-1), 1.0)
    gap = surface.signed_distance(points)
    np.testing.assert_allclose(np.abs(gap), np.linalg.norm(local - foot, axis=-1), atol=1e-9)
    around = foot[:, None, 1:] + rng.uniform(-0.06, 0.06, (40, 500, 2))
    others = np.concatenate([surface.height(around[..., 0], around[..., 1])[..., None], around], axis=-1)
    nearest = np.nanmin(np.linalg.norm(others - local[:, None], axis=-1), axis=1)
    assert np.all(nearest >= np.abs(gap) - 1e-9)
    step = 1e-6
    slope = [
        (surface.signed_distance(points + step * e) - surface.signed_distance(points - step * e)) / (2 * step)
        for e in np.eye(3)
    ]
    np.testing.assert_allclose(np.stack(slope, axis=-1), surface.normal(points), atol=1e-4)


def test_distance_along_the_contact_axis_meets_the_surface(surface, rng):
    feet = random_feet(surface, rng, 20)
    axis = np.array(surface.contact_axis)
    ahead = surface.distance_along(feet - 0.05 * axis)
    np.testing.assert_allclose(ahead, 0.05, atol=1e-7)


def test_origin_is_on_the_surface(surface):
    assert surface.signed_distance(np.array(surface.position)) == pytest.approx(0.0, abs=1e-9)
    assert surface.height(0.0, 0.0).shape == ()
    assert surface.height(0.0, 0.0) == pytest.approx(0.0, abs=1e-9)


def test_what_is_looked_at_is_what_is_touched(surface, scene_of, rng):
    scene = scene_of(surface)
    mujoco.mj_forward(scene.model, scene.data)
    feet = random_feet(surface, rng, 40)
    axis = np.array(surface.contact_axis)
    group = np.array([0, 1, 0, 0, 0, 0], dtype=np.uint8)
    hit = np.full(1, -1, dtype=np.int32)
    for foot in feet:
        ahead = mujoco.mj_ray(scene.model, scene.data, foot - 0.1 * axis, axis, group, 1, -1, hit, None)
        assert ahead == pytest.approx(0.1, abs=1e-3)


def test_unrolled_lengths_are_lengths_along_the_surface(surface):
    reach = 0.4 * min(surface.size[0], 1.5 * getattr(surface, "radius", np.inf))
    u = np.linspace(-reach, reach, 4001)
    s, _ = surface.unroll(u, np.zeros_like(u))
    w = surface.height(u, np.zeros_like(u))
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(u), np.diff(w)))])
    np.testing.assert_allclose(s - s[0], length, atol=2e-4)
    assert s[2000] == pytest.approx(0.0, abs=1e-9)


def test_it_can_be_copied_and_sent_to_another_process(surface):
    foot = surface.project(np.array([[0.9, 0.1, 1.05]]))
    for twin in (pickle.loads(pickle.dumps(surface)), copy.deepcopy(surface)):
        assert twin == surface
        np.testing.assert_array_equal(twin.project(np.array([[0.9, 0.1, 1.05]])), foot)


def test_description_is_json_and_builds_the_surface_again(surface):
    description = json.loads(json.dumps(surface.describe()))
    assert surface_from_mapping(description["parameters"]) == surface
    np.testing.assert_allclose(
        np.cross(description["axis_u"], description["axis_v"]), -np.array(description["normal"]), atol=1e-12
    )
    if "height" in description:
        height = np.array(description["height"], dtype=float)
        assert height.shape == (len(description["u"]), len(description["v"]))
        grid = np.meshgrid(description["u"], description["v"], indexing="ij")
        np.testing.assert_allclose(height, surface.height(*grid), atol=2e-4)


def test_a_post_is_touched_all_around():
    post = Post(radius=0.4, position=(1.0, 0.0, 1.0))
    angles = np.linspace(-3.0, 3.0, 25)
    outward = np.column_stack([-np.cos(angles), np.sin(angles), np.zeros(25)])
    feet = np.array([1.4, 0.0, 1.3]) + 0.4 * outward
    np.testing.assert_allclose(post.signed_distance(feet + 0.01 * outward), 0.01, atol=1e-12)
    np.testing.assert_allclose(post.normal(feet), outward, atol=1e-12)
    length, height = post.trace(feet + 0.01 * outward)
    np.testing.assert_allclose(length, 0.4 * angles, atol=1e-12)
    np.testing.assert_allclose(height, 0.3)
    assert post.covers(feet + 0.1 * outward).all()
    assert not post.covers(feet + np.array([0.0, 0.0, 1.0])).any()
    assert np.isnan(post.height(0.41, 0.0))
