"""What the mission tells the laws besides positions: phases, touch, heading, and what the arm may do."""

import numpy as np
import pytest

from skylimb.control.missions.configuration import ApproachConfig, MissionConfig, PhaseConfig
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.plan import plan_mission
from skylimb.control.missions.posture import PosturePlan
from skylimb.control.missions.ramp import ramp_duration
from skylimb.control.planning.trajectory_config import TrajectoryConfig

DT = 0.01
PHASES = PhaseConfig(hover=0.5, tare=0.4, settle=0.3, hover_end=0.2)
APPROACH = ApproachConfig(depth=0.1, standoff=0.05, speed=0.1, retreat_speed=0.2)
LINE = TrajectoryConfig(shape="line", length=0.2, speed=0.1, feedforward="full")
IN, OUT = ramp_duration(0.15, 0.1), ramp_duration(0.15, 0.2)


def posture(turn: float = 0.0, duration: float = 0.0) -> PosturePlan:
    return PosturePlan(
        reach=1.1,
        tip=np.array([1.0, 0.1, 0.02]),
        tip_radius=0.004,
        duration=duration,
        joint_angles=lambda t: np.tile([0.3, 0.6], (len(t), 1)),
        vectoring_angles=lambda t: np.tile([0.1], (len(t), 1)),
        tip_heading=lambda t: turn * np.clip(t, 0.0, 1.0),
    )


def planned(
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0),
    approach: ApproachConfig = APPROACH,
    body: PosturePlan | None = None,
) -> Mission:
    config = MissionConfig(PHASES, approach, LINE)
    return plan_mission(config, contact_frame(axis), np.array([1.5, 0.2, 1.2]), body or posture(), DT)


def test_the_mission_takes_the_time_of_its_phases() -> None:
    mission = planned()
    slide = mission.in_phase("slide").sum() * DT
    total = 0.5 + 0.4 + IN + 0.3 + slide + OUT + 0.2
    assert mission.times[0] == 0.0
    assert mission.times[-1] == pytest.approx(total, abs=2 * DT)
    for name, length in (("hover", 0.5), ("tare", 0.4), ("approach", IN), ("settle", 0.3), ("retreat", OUT)):
        assert mission.in_phase(name).sum() * DT == pytest.approx(length, abs=1.5 * DT), name
    assert mission.times[np.argmax(mission.in_phase("tare"))] == pytest.approx(0.5, abs=1e-9)


def test_a_posture_that_takes_longer_makes_the_slide_longer() -> None:
    assert planned(body=posture(duration=20.0)).in_phase("slide").sum() * DT == pytest.approx(
        20.0, abs=2 * DT
    )


def test_flags_belong_to_their_phases() -> None:
    mission = planned()
    reference = mission.reference
    np.testing.assert_array_equal(reference.tare, mission.in_phase("tare"))
    np.testing.assert_array_equal(reference.touch, mission.in_phase("approach", "settle", "slide"))
    np.testing.assert_array_equal(reference.adapt, reference.touch)
    np.testing.assert_array_equal(reference.wait, mission.in_phase("settle", "slide"))
    assert (reference.align == 1.0).all()


def test_an_arm_that_cannot_reach_along_the_axis_neither_adapts_nor_turns_the_robot() -> None:
    ceiling = planned(axis=(0.0, 0.0, 1.0)).reference
    assert ceiling.touch.max() == 1.0
    assert not ceiling.adapt.any()
    assert not ceiling.align.any()
    slanted = planned(axis=(0.8, 0.0, 0.6)).reference
    assert slanted.adapt.max() == slanted.align.max() == 1.0
    steep = planned(axis=(0.28, 0.0, 0.96)).reference
    assert not steep.adapt.any()


def test_a_free_flight_neither_touches_nor_waits() -> None:
    mission = planned(approach=ApproachConfig(contact=False, standoff=0.05))
    reference = mission.reference
    for flag in (reference.touch, reference.adapt, reference.wait, reference.align):
        assert not flag.any()
    assert not mission.contact
    np.testing.assert_allclose(reference.position @ [1.0, 0.0, 0.0], reference.position[0, 0])


def test_the_robot_heads_for_the_surface_and_the_tip_turns_with_the_posture() -> None:
    mission = planned(axis=(0.0, 1.0, 0.0), body=posture(turn=0.2))
    heading = mission.reference.heading
    start = int(np.argmax(mission.in_phase("slide")))
    assert heading[0] == pytest.approx(np.pi / 2)
    assert heading[start + 50] == pytest.approx(np.pi / 2 + 0.2 * 0.5, abs=0.2 * DT)
    assert heading[-1] == pytest.approx(np.pi / 2 + 0.2)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.8, 0.0)])
def test_in_contact_tip_and_centre_of_gravity_stand_where_depth_says(
    axis: tuple[float, float, float],
) -> None:
    mission = planned(axis=axis)
    frame, reference = mission.frame, mission.reference
    yaw = frame.heading
    tip = np.array([np.cos(yaw) - 0.1 * np.sin(yaw), np.sin(yaw) + 0.1 * np.cos(yaw), 0.02])
    sliding = mission.in_phase("slide")
    undisturbed = reference.position[sliding] + tip + 0.004 * frame.contact
    off = undisturbed - mission.tip_path[sliding]
    np.testing.assert_allclose(off, np.tile(0.1 * frame.contact, (sliding.sum(), 1)), atol=1e-9)
    nominal = reference.tip_position[sliding] + 0.004 * frame.contact
    np.testing.assert_allclose(nominal, mission.tip_path[sliding], atol=1e-9)
    waiting = reference.tip_position[0] + 0.004 * frame.contact - mission.tip_path[0]
    np.testing.assert_allclose(waiting, -0.05 * frame.contact, atol=1e-9)


def test_what_is_sent_is_the_derivative_of_what_is_sent() -> None:
    reference = planned().reference
    for position, velocity in (
        (reference.position, reference.velocity),
        (reference.velocity, reference.acceleration),
        (reference.tip_position, reference.tip_velocity),
    ):
        smooth = np.abs(np.gradient(np.gradient(velocity, DT, axis=0), DT, axis=0)).max(axis=1) < 5.0
        difference = np.gradient(position, DT, axis=0)
        np.testing.assert_allclose(difference[smooth], velocity[smooth], atol=5e-3)
        assert smooth.mean() > 0.8
    assert abs(reference.acceleration).max() > 0.05
