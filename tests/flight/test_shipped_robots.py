"""Every robot that ships hovers, and keeps contact in an experiment of its own."""

import pytest

import skylimb

ROBOTS = ["hydrus_quad", "hydrus_xi_hex", "dragon", "tilted_hexarotor", "tiltable_hexarotor"]


@pytest.mark.parametrize("robot", ROBOTS)
def test_it_hovers(robot):
    run = skylimb.run("free_flight", controller="pid", set={"robot": robot, "posture.waypoints": []})
    assert run.status == "OK", run.metrics
    assert run.metrics["displacement_median"] < 0.005
    assert run.metrics["tilt_max"] < 0.02


@pytest.mark.parametrize("robot", ROBOTS)
def test_it_keeps_contact_in_its_own_experiment(robot):
    run = skylimb.run(f"board_{robot}", controller="hybrid")
    assert run.status == "OK", run.metrics
    assert run.metrics["contact_fraction"] > 0.8
    assert run.metrics["pen_line_rms"] < 0.1


def test_a_robot_that_tilts_for_every_force_presses_calmly_though_it_is_seen_late():
    """With the gains of before it lifted off again and again, 2.1 N, and fell at a friction of 0.7."""
    late = {"robot": "hydrus_quad", "sensors.latency": 0.03, "trajectory.direction": 1}
    run = skylimb.run("paper", "following", set={**late, "surface.slope": -0.244, "surface.friction": 0.45})
    assert run.status == "OK", run.cause
    assert run.metrics["contact_force_normal_std"] < 0.3
    assert run.metrics["pen_line_rms"] < 0.02


def test_there_are_no_others():
    """A robot that is added is added here."""
    assert set(skylimb.list_robots()) == {*ROBOTS, "hydrus_xi_quad", "hydrus_xi_quad_mast"}
