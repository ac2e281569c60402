"""Robots that users bring: without vectoring, without bending joints, with frames that weigh nothing."""

import pytest

import skylimb
from made_robots import chain, joint, link, multirotor


def flown(path, experiment, controller, **changes):
    run = skylimb.run(experiment, controller=controller, set={"robot": str(path.parent), **changes})
    assert run.status == "OK", run.metrics
    return run.metrics


def test_a_chain_without_vectoring_flies_through_its_postures(tmp_path):
    """With a camera frame and a sensor without mass, which the engine's inertia check used to stop on."""
    camera = '<link name="camera"/>\n' + joint("mount", "link1", "camera", xyz="0.1 0 0.02")
    lidar = link("lidar", 0.0) + joint("lidar_mount", "link2", "lidar")
    path = chain(tmp_path, turns=(), tilt=0.3, theta=(1.2, 1.6, 1.5), more_urdf=camera + lidar)
    metrics = flown(
        path, "free_flight", "pid", **{"posture.waypoints": [[1.4, 1.4, 1.4]], "posture.hold": 0.5}
    )
    assert metrics["tilt_max"] < 0.5


def test_a_rigid_hexarotor_hovers_and_touches(tmp_path):
    path = multirotor(tmp_path, mass=2.5, thrust_max=15.0)
    assert flown(path, "free_flight", "pid", **{"posture.waypoints": []})["displacement_median"] < 0.01
    metrics = flown(path, "paper", "hybrid")
    assert metrics["contact_fraction"] > 0.3


@pytest.mark.parametrize("waypoints", [[[0.1]]])
def test_a_rigid_robot_has_no_postures_to_go_through(tmp_path, waypoints):
    with pytest.raises(skylimb.SkylimbError, match=r"posture\.waypoints"):
        skylimb.run(
            "free_flight", set={"robot": str(multirotor(tmp_path).parent), "posture.waypoints": waypoints}
        )
