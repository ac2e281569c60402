import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skylimb
from skylimb.base.errors import SkylimbError
from skylimb.base.rotations import rot_z
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.mission import PHASES, Mission
from skylimb.control.missions.posture import posture_plan
from skylimb.control.missions.ramp import ramp, ramp_duration
from skylimb.control.planning.posture_path import PostureConfig
from skylimb.control.planning.trajectories import trajectory
from skylimb.flight.plan import mission_of


def test_the_papers_frame_is_the_worlds() -> None:
    frame = contact_frame((1.0, 0.0, 0.0))
    np.testing.assert_allclose([frame.contact, frame.sliding_u, frame.sliding_v], np.eye(3), atol=1e-15)


@given(st.floats(-np.pi, np.pi), st.floats(-1.5, 1.5))
def test_a_contact_frame_is_right_handed(yaw: float, pitch: float) -> None:
    axis = (np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch))
    frame = contact_frame(axis)
    R = np.column_stack([frame.contact, frame.sliding_u, frame.sliding_v])
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-9)
    assert np.linalg.det(R) == pytest.approx(1.0)
    np.testing.assert_allclose(frame.contact, axis, atol=1e-9)


def test_an_axis_without_direction_is_refused() -> None:
    with pytest.raises(SkylimbError, match="unit vector"):
        contact_frame((0.0, 0.0, 0.0))


@given(st.floats(0.0, 2.0), st.floats(0.1, 1.0))
def test_a_ramp_arrives_and_its_speed_is_its_slope(distance: float, speed: float) -> None:
    total = ramp_duration(distance, speed)
    t = np.linspace(-0.5, total + 0.5, 8001)
    way, rate, bend = ramp(distance, speed, t)
    assert way[0] == 0.0
    assert way[-1] == pytest.approx(distance)
    assert rate.max() <= speed * (1 + 1e-9)
    np.testing.assert_allclose(np.gradient(way, t)[2:-2], rate[2:-2], atol=2e-2 * speed + 1e-9)
    assert np.abs(bend).max() <= speed / 0.5 * (1 + 1e-9)


def test_the_papers_mission() -> None:
    experiment = skylimb.load_experiment("paper")
    mission = mission_of(experiment, skylimb.load_robot(experiment.robot))
    reference, phase = mission.reference, mission.phase
    assert [PHASES[i] for i in np.unique(phase)] == [name for name in PHASES if name != "lift"]
    sliding = phase == PHASES.index("slide")
    circle = (mission.tip_path[sliding] - [1.5, 0.0, 1.2])[:, 1:]
    np.testing.assert_allclose(np.linalg.norm(circle, axis=1), 0.30, atol=1e-9)
    np.testing.assert_allclose(circle[0], [0.0, -0.30], atol=1e-6)
    assert sliding.sum() * experiment.control_period == pytest.approx(14.0, abs=0.01)
    # Positions alone are sent, as in the paper's experiment.
    assert np.abs(reference.velocity).max() == 0.0
    robot = skylimb.load_robot(experiment.robot)
    state = robot.at(reference.joint_angles[0], reference.vectoring_angles[0])
    tip = reference.position[sliding] + rot_z(reference.heading[0] - state.tip_heading) @ state.tip_C
    np.testing.assert_allclose(tip[:, 1:], mission.tip_path[sliding][:, 1:], atol=1e-9)
    np.testing.assert_allclose(tip[:, 0] + 0.004 - 1.50, experiment.approach.depth, atol=1e-9)
    steps = np.linalg.norm(np.diff(reference.position, axis=0), axis=1)
    assert steps.max() < 0.15 * experiment.control_period


def test_feedforward_sends_the_derivatives_of_the_positions() -> None:
    experiment = skylimb.load_experiment(
        "paper", set={"trajectory.feedforward": "full", "trajectory.ramp": 1.0}
    )
    mission = mission_of(experiment, skylimb.load_robot(experiment.robot))
    reference, dt = mission.reference, experiment.control_period
    velocity = np.gradient(reference.position, dt, axis=0)
    acceleration = np.gradient(reference.velocity, dt, axis=0)
    np.testing.assert_allclose(reference.velocity, velocity, atol=2e-3)
    away_from_corners = np.abs(np.gradient(acceleration, dt, axis=0)).max(axis=1) < 2.0
    np.testing.assert_allclose(
        reference.acceleration[away_from_corners], acceleration[away_from_corners], atol=2e-2
    )


TWO_STROKES = {
    "trajectory.shape": "drawing",
    "trajectory.text": "11",
    "trajectory.width": 0.25,
    "trajectory.feedforward": "full",
}


def lifting(**changes: object) -> tuple[skylimb.Experiment, Mission]:
    experiment = skylimb.load_experiment("paper", set={**TWO_STROKES, **changes})
    return experiment, mission_of(experiment, skylimb.load_robot(experiment.robot))


def test_between_two_strokes_the_pen_leaves_and_comes_back() -> None:
    experiment, mission = lifting()
    path, reference, dt = trajectory(experiment.trajectory), mission.reference, experiment.control_period
    lift, slide = (mission.phase == PHASES.index(name) for name in ("lift", "slide"))
    [(leave, back)] = path.lifts
    start = mission.times[np.flatnonzero(slide)[0]]
    lifted = mission.times[lift] - start
    assert lifted[0] == pytest.approx(leave, abs=2 * dt)
    assert lifted[-1] == pytest.approx(back + path.lift_time, abs=2 * dt)
    # Touch is wanted again from the way back on, and the mission waits for it only when that is over.
    assert np.count_nonzero((reference.touch[lift] > 0.5) != (lifted >= back)) <= 1
    np.testing.assert_array_equal(reference.adapt, reference.touch)
    assert not reference.wait[lift][:-2].any()
    assert reference.wait[lift][-2:].all()
    assert reference.wait[slide].all()
    # On the way to the next stroke the tip is clear of the board, which stands out by its slope.
    away = lift & (mission.times > start + leave + 2.0) & (mission.times < start + back)
    stands_out = np.tan(experiment.surface.slope) * -mission.tip_path[lift, 1].min()
    out = 1.5 - 0.004 - reference.tip_position[away, 0]
    np.testing.assert_allclose(out, experiment.approach.lift + stands_out, atol=1e-9)
    pressed = reference.position[slide, 0].max() - reference.position[away, 0]
    np.testing.assert_allclose(pressed, experiment.approach.depth + out, atol=1e-9)
    gaps = experiment.surface.signed_distance(reference.tip_position[away]) - 0.004
    assert gaps.min() > 0.9 * experiment.approach.lift


RIDGE = {"surface.kind": "ridge", "surface.slope": 0.0, "surface.rise": 0.03, "surface.width": 0.12}
SWAY = {"surface.sway_amplitude": 0.015, "surface.sway_frequency": 0.3}


def test_a_lift_says_how_far_the_surface_stands_out_beyond_where_it_began() -> None:
    """A board that leans does not, however far it stands out of its nominal place."""
    experiment, mission = lifting()
    lift = mission.in_phase("lift")
    np.testing.assert_array_equal(mission.reference.clearance[~lift], 0.0)
    np.testing.assert_allclose(mission.reference.clearance[lift], experiment.approach.lift, atol=1e-4)
    _, flat = lifting(**{"surface.slope": 0.0})
    np.testing.assert_allclose(flat.reference.clearance[lift], experiment.approach.lift, atol=1e-9)


def test_a_ridge_between_two_strokes_and_sway_add_to_the_clearance() -> None:
    experiment, mission = lifting(**RIDGE)
    clear = mission.reference.clearance[mission.in_phase("lift")]
    np.testing.assert_allclose(clear, experiment.approach.lift + 0.03, atol=1e-3)
    _, swaying = lifting(**SWAY)
    assert swaying.reference.clearance.max() - experiment.approach.lift == pytest.approx(0.03, abs=2e-3)


def test_a_lifts_derivatives_are_sent() -> None:
    experiment, mission = lifting()
    reference, dt = mission.reference, experiment.control_period
    lift = mission.phase == PHASES.index("lift")
    for position, velocity in (
        (reference.position, reference.velocity),
        (reference.tip_position, reference.tip_velocity),
        (reference.velocity, reference.acceleration),
    ):
        np.testing.assert_allclose(
            np.gradient(position, dt, axis=0)[lift][3:-3], velocity[lift][3:-3], atol=1e-2
        )


def test_a_free_flight_does_not_lift() -> None:
    _, mission = lifting(**{"approach.contact": False})
    assert not (mission.phase == PHASES.index("lift")).any()
    assert not mission.reference.touch.any()
    assert np.ptp(mission.reference.position[:, 0]) == 0.0


def test_a_flat_board_needs_no_more_than_the_lift() -> None:
    _, mission = lifting(**{"surface.slope": 0.0, "approach.lift": 0.08})
    away = mission.phase == PHASES.index("lift")
    assert 1.496 - mission.reference.tip_position[away, 0].min() == pytest.approx(0.08, abs=1e-9)


def test_a_surface_that_comes_nearer_is_kept_clear_of() -> None:
    _, mission = lifting(**{"surface.slope": 0.0, "surface.advance_distance": 0.06})
    away = mission.phase == PHASES.index("lift")
    assert 1.496 - mission.reference.tip_position[away, 0].min() == pytest.approx(0.11, abs=1e-9)


def test_a_heading_that_passes_half_a_turn_does_not_jump() -> None:
    """The tip's link turns from 2.2 to 3.5 rad; a jump by a turn between two knots would turn the body."""
    robot = skylimb.load_robot("dragon")
    waypoints = ((0.0, 1.55, 0.0, 1.55, 0.0, 0.4),)
    plan = posture_plan(PostureConfig(waypoints=waypoints, hold=0.0), robot, "online")
    heading = plan.tip_heading(np.linspace(0.0, plan.duration, 501))
    assert heading[-1] - heading[0] == pytest.approx(1.3, abs=0.1)
    assert np.abs(np.diff(heading)).max() < 0.02


def test_a_way_without_vectoring_angles_says_from_which_angles_there_is_one() -> None:
    """That of `calibration`, which `following` begins with the angles for contact."""
    robot = skylimb.load_robot("hydrus_xi_quad")
    way = PostureConfig(waypoints=((1.57, 0.3, 0.3),), speed=0.4)
    with pytest.raises(SkylimbError, match=r'allocation\.vectoring\.purpose = "torque"'):
        posture_plan(way, robot, "contact")
    assert posture_plan(way, robot, "torque").duration > 1.0
