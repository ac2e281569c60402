"""How near discs and bodies come to a surface, held against the engine's own distances."""

import json

import mujoco
import numpy as np
import pytest

import skylimb
from armed_robots import multirotor_with_arm
from skylimb.apps.robot_import.writing import import_robot
from skylimb.flight.takeoff import take_off
from skylimb.robots.extent import parts_of
from skylimb.simulation import clearance
from skylimb.simulation.clearance import least_clearance


def engine_distance(plant, qpos):
    """Of the nearest disc from the surface, by the engine: each disc a thin cylinder at its thrust's site."""
    spec = mujoco.MjSpec.from_string(plant.scene)
    bodies = spec.compile()
    for rotor in plant.robot.description.rotors:
        site = bodies.site(f"thrust_{rotor.name}")
        body = spec.body(bodies.body(int(site.bodyid[0])).name)
        body.add_geom(
            name=f"disc_{rotor.name}",
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[rotor.radius, 1e-6, 0],
            pos=site.pos,
            quat=site.quat,
            mass=0.0,
        )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos = qpos
    mujoco.mj_kinematics(model, data)
    wall = model.geom("surface").id
    discs = [model.geom(f"disc_{rotor.name}").id for rotor in plant.robot.description.rotors]
    return min(mujoco.mj_geomDistance(model, data, disc, wall, 10.0, None) for disc in discs)


@pytest.fixture
def fresh_parts():
    """No robot's parts are remembered, before or after: other flights keep theirs by robot."""
    clearance._parts.cache_clear()
    yield
    clearance._parts.cache_clear()


def only_discs(plant, monkeypatch):
    """Let the discs alone count: the engine's scene draws the links more finely than it needs to."""
    names = {rotor.name for rotor in plant.robot.description.rotors}
    links = {rotor.link for rotor in plant.robot.description.rotors}
    kept = [part for part in parts_of(plant.robot.description) if part.name in names and part.link in links]
    monkeypatch.setattr("skylimb.simulation.clearance.parts_of", lambda _: kept[: len(names)])


@pytest.mark.parametrize("experiment", ["board_tilted_hexarotor", "board_dragon"])
def test_discs_are_as_far_from_a_board_as_the_engine_says(experiment, monkeypatch, fresh_parts):
    plant = take_off(experiment, ("pid",))[0].plant
    only_discs(plant, monkeypatch)
    rng = np.random.default_rng(2)
    data = mujoco.MjData(plant.model)
    for _ in range(20):
        qpos = data.qpos.copy()
        qpos[:3] = rng.uniform([-0.5, -0.5, 0.5], [0.9, 0.5, 1.5])
        quaternion = rng.normal(size=4)
        qpos[3:7] = quaternion / np.linalg.norm(quaternion)
        qpos[7:] = rng.uniform(-0.5, 0.5, len(qpos) - 7)
        found = least_clearance(plant, qpos[None], np.zeros(1), plant.surface)
        # The rim has 24 points: a disc of 0.13 m that leans is seen to 1.2 mm.
        assert found.distance == pytest.approx(engine_distance(plant, qpos), abs=1.2e-3)
        assert found.distance >= engine_distance(plant, qpos) - 1e-6


KINDS = {"box": mujoco.mjtGeom.mjGEOM_BOX, "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER}
ARM = "elbow_link", "tool0"
"""Links that are the tool or carry it to the tip."""


def engine_distance_of_bodies(robot, wall, qpos, joint_angles):
    """Of the nearest drawn shape but the tool from a wall (place and normal), all shapes in one body."""
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(
        name="wall", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 1], pos=wall[0], zaxis=wall[1]
    )
    body = spec.worldbody.add_body(pos=qpos[:3], quat=qpos[3:7])
    poses, count = robot.link_poses(joint_angles, np.zeros(0)), 0
    for link in robot.description.links:
        for shape in () if link.name in ARM else link.visuals:
            place, R = poses[link.name]
            quat = np.zeros(4)
            mujoco.mju_mat2Quat(quat, np.ascontiguousarray(R @ shape.R).ravel())
            half = 0.5 * np.array(shape.size)
            size = half if shape.shape == "box" else [shape.size[0], half[1], 0.0]
            body.add_geom(
                name=f"shape{count}", type=KINDS[shape.shape], size=size, pos=place + R @ shape.xyz, quat=quat
            )
            count += 1
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    plane = model.geom("wall").id
    return min(
        mujoco.mj_geomDistance(model, data, model.geom(f"shape{k}").id, plane, 10.0, None)
        for k in range(count)
    )


@pytest.mark.usefixtures("no_picture")
def test_bodies_and_discs_of_an_imported_robot_are_as_far_as_the_engine_says(tmp_path, fresh_parts):
    """Boxes of hull and arm, propellers as they are drawn, before a wall that leans."""
    path = multirotor_with_arm(tmp_path / "made.urdf")
    (tmp_path / "mapping.toml").write_text(
        "posture = { offset = [0.3, -0.6], slope = [0.5, -1.0], theta_min = -0.3, theta_max = 0.3, "
        "theta_nominal = 0.0 }"
    )
    import_robot(path, tmp_path / "robot", mapping=tmp_path / "mapping.toml")
    robot = {"robot": str(tmp_path / "robot")}
    plant = take_off("board_tilted_hexarotor", ("pid",), set=robot)[0].plant
    board = mujoco.MjData(plant.model)
    mujoco.mj_kinematics(plant.model, board)
    wall = board.geom("surface").xpos, board.geom("surface").xmat.reshape(3, 3)[:, 2]
    rng = np.random.default_rng(4)
    for _ in range(20):
        qpos = board.qpos.copy()
        qpos[:3] = rng.uniform([-0.5, -0.5, 0.9], [0.4, 0.5, 1.5])
        quaternion = rng.normal(size=4)
        qpos[3:7] = quaternion / np.linalg.norm(quaternion)
        q = rng.uniform(-1.5, 1.5, 2)
        qpos[list(plant.joint_qpos)] = q
        found = least_clearance(plant, qpos[None], np.zeros(1), plant.surface)
        # Rims have 24 points; the drawn propeller of 10 mm reaches 5 mm beyond its disc.
        exact = engine_distance_of_bodies(plant.robot, wall, qpos, q)
        assert found.distance == pytest.approx(exact, abs=1.2e-3)
        assert found.distance >= exact - 1e-6


def test_a_flight_whose_disc_goes_through_the_surface_says_so():
    steep = skylimb.run("board_tilted_hexarotor", "following", set={"surface.slope": 0.7})
    part, distance, _ = json.loads(steep.log.attrs["clearance"])
    assert part.startswith("rotor")
    assert steep.metrics["clearance"] == distance < 0.0
    assert not steep.metrics["done"]
    assert any(
        f"'{part}' is {1e3 * distance:.1f} mm from the surface" in line for line in steep.metrics["missed"]
    )


def test_a_flight_that_touches_nothing_has_no_clearance():
    free = skylimb.run("free_flight", "pid", set={"stop_at": 0.5})
    assert json.loads(free.log.attrs["clearance"]) is None
    assert "clearance" not in free.metrics["checks"]


def test_what_comes_near_between_two_looks_is_seen():
    """A robot that flies to the board and back at 1 m/s, and turns in the middle between two looks."""
    plant = take_off("paper", ("pid",))[0].plant
    data, times = mujoco.MjData(plant.model), 0.005 * np.arange(200)
    qpos = np.tile(data.qpos, (len(times), 1))
    nearest = 85  # 0.425 s: looks are at 0.40 and 0.45 s
    qpos[:, 0] -= np.abs(times - times[nearest])
    found = least_clearance(plant, qpos, times, plant.surface)
    assert found.time == pytest.approx(times[nearest])
    alone = least_clearance(plant, qpos[nearest : nearest + 1], times[nearest : nearest + 1], plant.surface)
    assert found.distance == pytest.approx(alone.distance)
