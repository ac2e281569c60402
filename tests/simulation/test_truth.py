import numpy as np
import pytest

import skylimb
from skylimb.base.rotations import rotation_from_quaternion, rotation_from_rpy
from skylimb.flight.drivers.native import native_available
from skylimb.flight.plan import mission_of
from skylimb.flight.takeoff import take_off
from skylimb.simulation import truth

SHORT = {
    "phases.hover": 0.4,
    "phases.tare": 0.3,
    "phases.settle": 0.3,
    "phases.hover_end": 0.1,
    "approach.speed": 0.2,
    "approach.retreat_speed": 0.3,
    "trajectory.radius": 0.05,
    "trajectory.period": 2.0,
}


def test_machine_code_gives_the_same_kinematics_at_any_number_of_ticks() -> None:
    if not native_available():
        pytest.skip("no C compiler here")
    (takeoff,) = take_off("paper", ("hybrid",))
    plant = takeoff.plant
    size = (int(plant.model.nq), int(plant.model.nv))
    functions = [
        truth._kinematics_function(plant.robot, plant.joint_qpos, plant.vectoring_qpos, *size, built)[1]
        for built in (False, True)
    ]
    rng = np.random.default_rng(0)
    for count in (0, 1, 256, 300):
        qpos, qvel, axis = (rng.normal(size=(count, n)) for n in (*size, 3))
        qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
        slow, built = (truth._over_ticks(function, qpos, qvel, axis) for function in functions)
        assert slow.shape == (count, functions[0].size1_out(0))
        np.testing.assert_allclose(built, slow, rtol=0.0, atol=1e-12)


def test_the_truth_of_a_flight_that_holds_the_mission_back() -> None:
    experiment, robot = skylimb.load_experiment("paper", SHORT), skylimb.load_robot("hydrus_xi_quad")
    mission = mission_of(experiment, robot)
    run = skylimb.run(experiment, controller="following")
    assert run.status == "OK", run.cause
    log = run.log
    assert log.sizes["time"] > len(mission.times)
    for k in np.linspace(0, log.sizes["time"] - 1, 7).astype(int):
        state = robot.at(log.joint_angles.values[k], log.vectoring_angles.values[k])
        R, p = rotation_from_quaternion(log.root_quaternion.values[k]), log.root_position.values[k]
        cog, tip = p + R @ state.cog_root, p + R @ state.tip_root
        np.testing.assert_allclose(log.cog_position.values[k], cog, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(log.tip_position.values[k], tip, rtol=0.0, atol=1e-12)
        R_WC = R @ state.R_root_C
        assert log.tilt.values[k] == pytest.approx(np.arccos(R_WC[2, 2]), abs=1e-7)
        np.testing.assert_allclose(rotation_from_rpy(*log.attitude.values[k]), R_WC, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(
            log.reach.values[k], (tip - cog) @ mission.frame.contact, rtol=0.0, atol=1e-12
        )


def test_a_contact_has_its_point_on_the_surface_and_its_torque_about_the_centre_of_gravity() -> None:
    (takeoff,) = take_off("paper", ("hybrid",), 0)
    plant = takeoff.plant
    run = skylimb.run("paper", controller="hybrid", seed=0)
    assert run.status == "OK", run.cause
    log = run.log
    # Nothing has passed at the first tick.
    for name in ("contact_force_normal", "contact_force_tangential", "friction_work", "slip_speed"):
        assert np.all(log[name].values[0] == 0.0)
    assert np.all(np.isnan(log.contact_trace.values[0]))
    assert np.max(log.tilt.values) > 0.03
    force, point = log.contact_force.values, log.contact_point.values
    acting = np.any(force != 0.0, axis=1)
    assert np.any(acting & (log.contact_duty.values < 1.0))
    distance = plant.surface.signed_distance(point[acting], log.time.values[acting])
    assert np.max(np.abs(distance)) < 1e-3
    near = np.linalg.norm(point[acting] - log.tip_position.values[acting], axis=1)
    assert np.max(near) < plant.robot.description.tip.radius + 1e-3
    assert np.all(np.isnan(point[~acting]))
    lever = point[acting] - log.cog_position.values[acting]
    np.testing.assert_allclose(
        log.contact_torque.values[acting], np.cross(lever, force[acting]), rtol=0.0, atol=1e-12
    )
    assert np.all(log.contact_torque.values[~acting] == 0.0)
