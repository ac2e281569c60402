"""Friction over a surface, stickiness, and friction that falls with slip."""

import mujoco
import numpy as np
import pytest

from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.simulation.surfaces import Board, FrictionMap, PairFriction, Patch, surface_from_mapping

PATCHES = FrictionMap(
    patches={
        "wet": Patch(center=(0.2, 0.0), size=(0.2, 0.4), friction=0.1),
        "tar": Patch(center=(-0.2, 0.1), radius=0.1, friction=0.7, adhesion=0.5),
    },
    blend=0.002,
)


def at(surface, u, v):
    return surface.to_world(np.array([0.0, u, v]))


def test_patches_lie_where_they_are_put():
    board = Board(friction=0.4, friction_map=PATCHES, slope=0.2, position=(1.0, 0.3, 1.0))
    points = np.stack(
        [at(board, *uv) for uv in ((0.2, 0.0), (-0.2, 0.1), (0.0, 0.0), (0.3, 0.0), (-0.2, 0.3))]
    )
    friction, adhesion = board.friction_at(points)
    np.testing.assert_allclose(
        friction, [0.1, 0.7, 0.4, 0.25, 0.4], atol=1e-9
    )  # 0.3 is on the border: half way
    np.testing.assert_allclose(adhesion, [0.0, 0.5, 0.0, 0.0, 0.0])


def test_a_table_is_laid_out_like_a_height_map():
    board = Board(size=(2.0, 2.0), friction_map=FrictionMap(table=((0.1, 0.2), (0.3, 0.4))))
    corners = np.stack([at(board, u, v) for u, v in ((1, 1), (-1, 1), (1, -1), (-1, -1), (0, 0))])
    np.testing.assert_allclose(board.friction_at(corners)[0], [0.1, 0.2, 0.3, 0.4, 0.25])


def test_a_table_of_more_rows_is_bilinear_in_each_of_its_cells():
    table = ((0.0, 0.1, 0.2), (0.3, 0.4, 0.5), (0.6, 0.7, 0.8))
    board = Board(size=(2.0, 2.0), friction_map=FrictionMap(table=table))
    places = np.stack(
        [at(board, u, v) for u, v in ((0.5, 0.5), (-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5), (0, 0))]
    )
    np.testing.assert_allclose(board.friction_at(places)[0], [0.2, 0.3, 0.5, 0.6, 0.4])


def test_an_image_is_friction_between_two_values(tmp_path):
    from PIL import Image

    Image.fromarray(np.array([[0, 255], [0, 255]], dtype=np.uint8)).save(tmp_path / "map.png")
    board = Board(friction_map=FrictionMap(file=str(tmp_path / "map.png"), low=0.1, high=0.7))
    friction, _ = board.friction_at(np.stack([at(board, 1.0, 0.0), at(board, -1.0, 0.0)]))
    np.testing.assert_allclose(friction, [0.1, 0.7])


def test_friction_at_rest_exceeds_friction_in_motion():
    board = Board(friction=0.3, static_ratio=1.5, static_speed=0.005)
    friction, _ = board.friction_at(np.zeros((3, 3)), slip=np.array([0.0, 0.005, 0.1]))
    np.testing.assert_allclose(friction, [0.45, 0.3 * (1 + 0.5 / np.e), 0.3], rtol=1e-9)


@pytest.mark.parametrize("advance", [0.0, 0.1])
def test_the_writer_writes_what_the_surface_says(scene_of, rng, advance):
    surface = Board(friction_map=PATCHES, static_ratio=1.3, slope=0.3, pitch=0.1, advance_distance=advance)
    scene = scene_of(surface)
    writer = PairFriction(scene.model, surface)
    x, wall = surface.motion(1.0)
    for uv in rng.uniform(-0.5, 0.5, (200, 2)):
        tip = surface.to_world(np.array([0.0, *uv]), 1.0)
        along = surface.R_WS @ np.array([0.0, *rng.uniform(-0.01, 0.01, 2)])
        velocity = along + float(wall) * surface.motion_axis
        written = writer.update(tip, velocity, float(x), float(wall))
        # The table of the writer is half a blending width coarse, so skip what lies on a border.
        if min(abs(patch.distance(*uv)) for patch in PATCHES.patches.values()) < 0.004:
            continue
        friction, adhesion = surface.friction_at(tip, float(np.linalg.norm(along)), 1.0)
        assert written == pytest.approx(float(friction), rel=1e-9)
        pair = scene.model.pair("tip_surface")
        assert pair.friction[:2] == pytest.approx([written, written])
        assert scene.model.pair_adhesion[0] == float(adhesion)


def test_a_sticky_patch_holds_until_its_force_is_exceeded(scene_of):
    def escape(force):
        """Distance that a slowly growing pull takes the ball away from the surface."""
        scene = scene_of(Board(friction_map=PATCHES, position=(1.0, 0.2, 0.9), damping_ratio=1.0))
        writer = PairFriction(scene.model, scene.surface)
        scene.touch((0.9961, 0.0, 1.0))  # on the patch "tar"
        for step in range(2000):
            scene.data.xfrc_applied[-1, 0] = -force * min(1.0, step / 1500)
            writer.update(scene.data.qpos[:3])
            mujoco.mj_step(scene.model, scene.data)
        return 1.0 - scene.radius - scene.data.qpos[0]

    assert 0.0 < escape(0.49) < 0.5 / 5000
    assert escape(0.51) > 1e-3


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"patches": {"wet": {"friction": -0.1}}}, ["surface.friction_map.patches.wet.friction = -0.1 "]),
        ({"patches": {"wet": {"radius": 0.0}}}, ["surface.friction_map.patches.wet.radius = 0 m"]),
        ({"patches": {"wet": {"centre": [0.0, 0.0]}}}, ["centre", "center"]),
        ({"table": [[0.1, -0.2]]}, ["surface.friction_map.table = -0.2 (entry 1 of 1, 2 of 2)"]),
        ({"table": [[0.1], [0.1, 0.2]]}, ["different lengths"]),
        ({"file": "nowhere.npy"}, ["nowhere.npy", "no such file"]),
        ({"table": [[0.1]], "file": "a.png"}, ["not both"]),
        ({"blend": 0.0}, ["surface.friction_map.blend = 0 m"]),
    ],
)
def test_bad_maps_are_named(table, words):
    with pytest.raises((ConfigError, UnknownNameError)) as caught:
        surface_from_mapping({"friction_map": table})
    for word in words:
        assert word in str(caught.value)


def test_static_friction_below_kinetic_is_refused():
    with pytest.raises(ConfigError, match="static_ratio"):
        Board(static_ratio=0.9)


def test_a_tip_that_comes_straight_at_the_surface_does_not_slip(scene_of):
    surface = Board(friction=0.3, static_ratio=1.5, static_speed=0.005, slope=0.3, pitch=0.1)
    writer = PairFriction(scene_of(surface).model, surface)
    tip = np.array(surface.position)
    into, along = surface.R_WS[:, 0], surface.R_WS[:, 1]
    assert writer.update(tip, 0.2 * into) == pytest.approx(1.5 * 0.3)
    kinetic = 0.3 * (1.0 + 0.5 * np.exp(-1.0))
    assert writer.update(tip, 0.2 * into + 0.005 * along) == pytest.approx(kinetic)


def test_the_engine_is_given_what_the_analysis_says(scene_of, rng):
    surface = Board(friction_map=FrictionMap(table=((0.1, 0.6), (0.3, 0.4)), blend=0.02), static_ratio=1.3)
    writer = PairFriction(scene_of(surface).model, surface)
    for cell in rng.integers(0, 200, (50, 2)):
        # In the middle of a cell of the writer's table the two agree to rounding.
        tip = surface.to_world(np.array([0.0, *((cell + 0.5) / 200 * 2.0 - 1.0)]))
        along = surface.R_WS @ np.array([0.0, *rng.uniform(-0.01, 0.01, 2)])
        said, _ = surface.friction_at(tip, float(np.linalg.norm(along)))
        assert writer.update(tip, along) == pytest.approx(float(said), rel=1e-13)
