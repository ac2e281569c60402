"""How hard the tip could push: against statics, against what can be held, and in a page's data."""

import json

import mujoco
import numpy as np
import pytest

import skylimb
from skylimb.analysis.figures import scene
from skylimb.analysis.recording import Run
from skylimb.analysis.viewer import pushes
from skylimb.analysis.viewer.pushes import (
    LEAN,
    MOMENTS,
    greatest_pushes,
    packed_pushes,
    sphere,
    well_spread,
)
from skylimb.analysis.viewer.stance import Stance, stance_at
from skylimb.base.rotations import rot_z, rotation_from_rpy
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.robots.equilibrium import greatest_push
from skylimb.robots.equilibrium_results import Within
from skylimb.robots.loads import loads_function
from skylimb.robots.model import Robot
from unpacking import unpacked

AXES = np.vstack([np.eye(3), -np.eye(3)])


def quadrotor(most: float = 10.0, lever: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Stance:
    """Four upright rotors at 0.2 m, 20 N of weight."""
    places = 0.2 * np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0.0]])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    drag = 0.01 * np.array([1, -1, 1, -1.0])[:, None] * up
    columns = np.hstack([up, np.cross(places, up) + drag]).T
    nothing = np.zeros((0, 4)), np.zeros((3, 0)), np.zeros((3, 0)), np.zeros(0)
    return Stance(columns, np.zeros(4), np.full(4, most), 20.0, np.array(lever), 0.0, *nothing)


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
    np.testing.assert_allclose(np.abs(pushes.state[0, -3:-1]), [0.0, LEAN], atol=1e-3)


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
    stance = stance._replace(low=np.full(2, -5.0), high=np.full(2, 5.0), loads=np.zeros((0, 2)))
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


def stance_of(run: Run, configuration: np.ndarray) -> Stance:
    model = scene.load_model(run.log.attrs["scene"], (64, 64))
    limits = np.array(json.loads(run.log.attrs["thrust_limits"]))
    stance = stance_at(model, mujoco.MjData(model), configuration, limits)
    assert stance is not None
    return stance


AS_MEASURED = Within(LEAN, stiff=True)
"""A page sees joints where they are."""


def test_it_is_what_can_be_held(flown: Run) -> None:
    """From a scene, by linear programmes; from a description, by the planner's own."""
    last = flown.log.isel(time=-1)
    stance, robot = stance_of(flown, last.configuration.values), skylimb.load_robot("hydrus_xi_quad")
    assert stance.weight == pytest.approx(robot.weight, rel=1e-6)
    q, psi = last.joint_angles.values, last.vectoring_angles.values
    heading = stance.heading + robot.at(q, psi).tip_heading
    pushes = greatest_pushes(stance, AXES @ rot_z(heading).T)
    held = [greatest_push(robot, q, psi, axis, AS_MEASURED) for axis in AXES]
    np.testing.assert_allclose(pushes.size, [one.force for one in held if one], rtol=2e-3, atol=0.01)
    assert any(one.limit is not None and one.limit.kind == "servo" for one in held)


@pytest.mark.parametrize("name", ["hydrus_xi_hex", "hydrus_quad", "dragon", "tilted_hexarotor"])
def test_other_robots_push_as_can_be_held_in_any_direction(name: str) -> None:
    robot = skylimb.load_robot(name)
    psi = vectoring_table(robot).angles(robot.description.posture.theta_nominal)
    stance = stance_by_the_model(robot, robot.nominal_posture(), psi)
    directions = sphere(0)[0]
    found = greatest_pushes(stance, directions).size
    held = [greatest_push(robot, robot.nominal_posture(), psi, one, AS_MEASURED) for one in directions]
    np.testing.assert_allclose(found, [one.force if one else 0.0 for one in held], rtol=5e-3, atol=0.01)


def stance_by_the_model(robot: Robot, q: np.ndarray, psi: np.ndarray) -> Stance:
    """A stance whose heading is along W's x."""
    C, V, J_c, J_r, r, heading = (part.full() for part in loads_function(robot)(q, psi))
    description = robot.description
    low, high = np.array([[one.thrust_min, one.thrust_max] for one in description.rotors]).T
    given = C, low, high, robot.weight, r.ravel(), -float(heading.item()), V, J_c, J_r
    return Stance(*given, description.servos.torque_limit)


def test_leans_count_from_the_level_also_while_it_leans(flown: Run) -> None:
    moment = flown.log.isel(time=flown.log.sizes["time"] // 2)
    q, cog = moment.configuration.values.copy(), moment.cog_position.values
    straight = stance_of(flown, q)
    lean = rotation_from_rpy(0.1, -0.2, 0.3)
    q[:3] = cog + lean @ (q[:3] - cog)
    turned = np.zeros(4)
    mujoco.mju_mat2Quat(turned, lean.ravel())
    mujoco.mju_mulQuat(q[3:7], turned, q[3:7].copy())
    leaned = stance_of(flown, q)
    np.testing.assert_allclose(leaned.columns, straight.columns, atol=1e-9)
    np.testing.assert_allclose(leaned.loads, straight.loads, atol=1e-9)
    # What it can push, seen from its own heading, is the same.
    there, here = (AXES @ rot_z(one.heading).T for one in (leaned, straight))
    np.testing.assert_allclose(
        greatest_pushes(leaned, there).size, greatest_pushes(straight, here).size, 1e-6
    )


def test_a_page_is_given_them(flown: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pushes, "MOMENTS", MOMENTS)  # as a user has them
    model = scene.load_model(flown.log.attrs["scene"], (64, 64))
    given = packed_pushes(model, flown.log)
    assert given is not None
    sizes = unpacked(given["pushes"])
    assert sizes.shape == (MOMENTS, 162)
    assert (sizes > 0.5).all()
    assert len(json.dumps(given)) < 25_000
    without = flown.log.copy()
    del without.attrs["thrust_limits"]
    assert packed_pushes(model, without) is None
