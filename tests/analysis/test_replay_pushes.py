"""How hard the tip could push: against statics, against the planner's own search, and in a page's data."""

import json

import mujoco
import numpy as np
import pytest

import skylimb
from skylimb.analysis import scene
from skylimb.analysis.replay.packing import unpacked
from skylimb.analysis.replay.pushes import (
    LEAN,
    MOMENTS,
    greatest_pushes,
    packed_pushes,
    sphere,
    well_spread,
)
from skylimb.analysis.replay.stance import Stance, stance_at
from skylimb.planning.feasible_wrench import feasible_wrench
from skylimb.recording import Run
from skylimb.spatial import rot_z, rotation_from_rpy, rpy_from_rotation

AXES = np.vstack([np.eye(3), -np.eye(3)])


def quadrotor(most: float = 10.0, lever: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Stance:
    """Four upright rotors at 0.2 m, 20 N of weight."""
    places = 0.2 * np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0.0]])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    drag = 0.01 * np.array([1, -1, 1, -1.0])[:, None] * up
    columns = np.hstack([up, np.cross(places, up) + drag]).T
    return Stance(columns, np.zeros(4), np.full(4, most), 20.0, np.array(lever))


def test_directions_go_all_around_in_triangles_that_face_outward() -> None:
    points, faces = sphere()
    assert (len(points), len(faces)) == (162, 320)
    a, b, c = (points[faces[:, k]] for k in range(3))
    assert (np.sum(np.cross(b - a, c - a) * a, axis=1) > 0.0).all()
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=1e-12)


def test_a_quadrotor_that_pushes_at_its_centre() -> None:
    pushes = greatest_pushes(quadrotor(), AXES)
    # Up with what thrust is left; down with the whole weight; sideways it leans by 20 degrees.
    np.testing.assert_allclose(pushes.size[[2, 5]], 20.0, rtol=1e-3)
    np.testing.assert_allclose(pushes.size[[0, 1, 3, 4]], 20.0 * np.tan(LEAN), rtol=2e-3)
    np.testing.assert_allclose(np.abs(pushes.lean[0]), [0.0, LEAN], atol=1e-3)


def test_the_torque_of_the_lever_is_what_limits_a_long_arm() -> None:
    # p at 1 m before it: 0.2 (f1 - f3) = p, and all rotors together carry 20 + p.
    pushes = greatest_pushes(quadrotor(lever=(1.0, 0.0, 0.0)), np.array([[0.0, 0.0, 1.0]]))
    # With f1 = 10 and no torque about z, f1 + f3 = f2 + f4 = (20 + p) / 2.
    assert pushes.size[0] == pytest.approx(20.0 / 11.0, rel=5e-3)


def test_who_cannot_hover_can_only_rest_on_something() -> None:
    np.testing.assert_allclose(
        greatest_pushes(quadrotor(most=4.0), AXES).size, [0, 0, 0, 0, 0, 20], atol=1e-6
    )


def test_a_direction_without_a_push_leaves_the_others_alone() -> None:
    """Two rotors push along x and y alone, so that it rests only while something carries it."""
    stance = quadrotor()._replace(columns=np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 0.0])[:, :2])
    stance = stance._replace(low=np.full(2, -5.0), high=np.full(2, 5.0))
    slant = 0.1
    slanted = np.array([[-np.sin(slant), 0.0, -np.cos(slant)]])
    found = greatest_pushes(stance, np.vstack([AXES, slanted]))
    np.testing.assert_allclose(found.size[:5], 0.0, atol=1e-6)
    assert found.size[5] == pytest.approx(20.0, rel=1e-6)
    # Weight and push together lie in the rotors' plane, steepest towards x.
    assert found.size[6] == pytest.approx(20.0 / (np.cos(slant) - np.sin(slant) * np.tan(LEAN)), rel=1e-3)


def test_a_start_from_nearby_ends_at_the_same() -> None:
    stance = quadrotor(lever=(0.5, 0.1, -0.1))
    cold = greatest_pushes(stance, AXES)
    warm = greatest_pushes(stance, AXES, greatest_pushes(quadrotor(lever=(0.45, 0.1, -0.1)), AXES))
    np.testing.assert_allclose(warm.size, cold.size, rtol=5e-3)


def test_directions_are_spread_where_the_set_is_wide() -> None:
    stance = quadrotor(most=40.0)
    ends = greatest_pushes(stance, well_spread(stance))
    assert (ends.size > 0.0).all()
    # Upward it pushes far more than to the side: most directions look up or down.
    assert np.mean(np.abs(well_spread(stance)[:, 2]) > 0.8) > np.mean(np.abs(sphere()[0][:, 2]) > 0.8) + 0.2


@pytest.fixture(scope="module")
def flown() -> Run:
    return skylimb.run("free_flight", "pid", set={"stop_at": 1.0})


def test_it_is_what_robot_wrench_says(flown: Run) -> None:
    log = flown.log
    model = scene.load_model(log.attrs["scene"], (64, 64))
    limits = np.array(json.loads(log.attrs["thrust_limits"]))
    last = log.isel(time=-1)
    q = last.configuration.values
    stance = stance_at(model, mujoco.MjData(model), q, last.attitude.values, last.tip_position.values, limits)
    assert stance is not None
    robot = skylimb.load_robot("hydrus_xi_quad")
    assert stance.weight == pytest.approx(robot.mass * 9.80665, rel=1e-6)
    feasible = feasible_wrench(robot, last.joint_angles.values, last.vectoring_angles.values)
    heading = float(last.attitude[2]) + feasible.state.tip_heading
    found = greatest_pushes(stance, AXES @ rot_z(heading).T).size
    np.testing.assert_allclose(found, [feasible.push(axis) for axis in AXES], rtol=0.02, atol=0.1)


@pytest.mark.parametrize("name", ["hydrus_xi_hex", "hydrus_quad", "dragon", "tilted_hexarotor"])
def test_other_robots_push_as_robot_wrench_says_in_any_direction(name: str) -> None:
    feasible = feasible_wrench(skylimb.load_robot(name))
    state, heading = feasible.state, -feasible.state.tip_heading
    wrenches = np.kron(np.eye(2), rot_z(heading)) @ state.allocation_C
    weight = float(feasible.hover[2])
    stance = Stance(wrenches, *feasible.thrust_limits, weight, rot_z(heading) @ state.tip_C, heading)
    directions = sphere(0)[0]
    found = greatest_pushes(stance, directions).size
    np.testing.assert_allclose(found, [feasible.push(one) for one in directions], rtol=0.03, atol=0.1)


def test_leans_count_from_the_level_also_while_it_leans(flown: Run) -> None:
    log = flown.log
    model = scene.load_model(log.attrs["scene"], (64, 64))
    limits = np.array(json.loads(log.attrs["thrust_limits"]))
    moment = log.isel(time=log.sizes["time"] // 2)
    q, attitude = moment.configuration.values.copy(), moment.attitude.values
    straight = stance_at(model, mujoco.MjData(model), q, attitude, moment.tip_position.values, limits)
    lean, cog = rotation_from_rpy(0.1, -0.2, 0.3), moment.cog_position.values
    q[:3] = cog + lean @ (q[:3] - cog)
    turned = np.zeros(4)
    mujoco.mju_mat2Quat(turned, lean.ravel())
    mujoco.mju_mulQuat(q[3:7], turned, q[3:7].copy())
    tip = cog + lean @ (moment.tip_position.values - cog)
    leant = rpy_from_rotation(lean @ rotation_from_rpy(*attitude))
    leaned = stance_at(model, mujoco.MjData(model), q, leant, tip, limits)
    assert straight is not None
    assert leaned is not None
    to_heading = np.kron(np.eye(2), rot_z(straight.heading - leaned.heading))
    np.testing.assert_allclose(to_heading @ leaned.columns, straight.columns, atol=2e-3)


def test_a_page_is_given_them(flown: Run) -> None:
    model = scene.load_model(flown.log.attrs["scene"], (64, 64))
    given = packed_pushes(model, flown.log)
    assert given is not None
    sizes = unpacked(given["pushes"])
    assert sizes.shape == (MOMENTS, 162)
    assert (sizes > 0.5).all()
    assert len(json.dumps(given)) < 25_000
    assert packed_pushes(model, flown.log.drop_vars("tip_position")) is None
