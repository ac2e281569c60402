"""A path around a post: the flat mission bent around an upright axis."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.control.missions.clock import entries
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.missions.wrap import Along, wrapped, wrapped_points
from skylimb.flight import plan

RADIUS, TIP = 0.3, 0.004
DT = 0.005
FRONT = np.array([1.5, 0.0, 1.2])
AXIS = np.array([1.8, 0.0])


def mission_of(**given: Any) -> Mission:
    experiment = skylimb.load_experiment("pipe_around", given)
    return plan.mission_of(experiment, skylimb.load_robot(experiment.robot))


@pytest.fixture(scope="module")
def around() -> Mission:
    return mission_of()


def test_the_tip_goes_once_around_and_the_contact_axis_points_at_the_axis(around: Mission) -> None:
    sliding = around.in_phase("slide")
    tip = around.reference.tip_position[sliding]
    from_axis = tip[:, :2] - AXIS
    np.testing.assert_allclose(np.linalg.norm(from_axis, axis=1), RADIUS + TIP, atol=1e-9)
    np.testing.assert_allclose(tip[:, 2], 1.2, atol=1e-9)
    angle = np.unwrap(np.arctan2(from_axis[:, 1], from_axis[:, 0]))
    assert abs(angle[-1] - angle[0]) == pytest.approx(2.0 * np.pi, abs=1e-3)
    # It begins behind the post and passes the front in the middle.
    np.testing.assert_allclose(tip[0, :2], AXIS + np.array([RADIUS + TIP, 0.0]), atol=1e-3)
    np.testing.assert_allclose(around.tip_path[sliding][len(tip) // 2], FRONT, atol=1e-3)
    inward = -from_axis / np.linalg.norm(from_axis, axis=1, keepdims=True)
    np.testing.assert_allclose(around.reference.contact_axis[sliding][:, :2], inward, atol=1e-9)


def test_heading_and_axes_turn_together_and_stay_right_handed(around: Mission) -> None:
    reference = around.reference
    a, u = reference.contact_axis, reference.sliding_axis
    np.testing.assert_allclose(np.cross(a, u), np.tile([0.0, 0.0, 1.0], (len(a), 1)), atol=1e-12)
    heading = np.column_stack([np.cos(reference.heading), np.sin(reference.heading)])
    np.testing.assert_allclose(heading, a[:, :2], atol=1e-9)
    # The arm stays behind the tip: the centre of gravity is as far off all the way, seen along the axes.
    arm = reference.tip_position - reference.position
    for axis in (a, u):
        along = np.sum(arm * axis, axis=1)[around.in_phase("slide")]
        np.testing.assert_allclose(along, along[0], atol=1e-9)


def test_rates_and_accelerations_are_those_of_the_places(around: Mission) -> None:
    sliding = np.flatnonzero(around.in_phase("slide"))[20:-20]
    reference = around.reference
    for place, rate, bend in (
        ("position", "velocity", "acceleration"),
        ("tip_position", "tip_velocity", "tip_acceleration"),
    ):
        p, v, a = (getattr(reference, name) for name in (place, rate, bend))
        np.testing.assert_allclose(np.gradient(p, DT, axis=0)[sliding], v[sliding], atol=2e-4)
        slope = np.gradient(v, DT, axis=0)
        # The path's acceleration jumps where it stops gathering speed.
        assert np.quantile(np.abs(slope - a)[sliding], 0.99) < 1e-3
    speed = np.linalg.norm(reference.tip_velocity[sliding], axis=1).max()
    assert speed == pytest.approx(0.08 * (RADIUS + TIP) / RADIUS, rel=1e-6)


def test_it_is_the_flat_mission_turned() -> None:
    around = mission_of(**{"trajectory.length": 0.4})
    flat = mission_of(**{"trajectory.length": 0.4, "wrap.radius": None})
    at = int(np.flatnonzero(flat.in_phase("slide"))[300])
    s = flat.tip_path[at, 1]
    turn = Rotation.from_rotvec([0.0, 0.0, -s / RADIUS]).as_matrix()
    center = np.array([*AXIS, 0.0])
    expected = center + turn @ (flat.reference.position[at] - [0.0, s, 0.0] - center)
    np.testing.assert_allclose(around.reference.position[at], expected, atol=1e-12)


def test_what_is_not_sent_stays_unsent() -> None:
    silent = mission_of(**{"trajectory.feedforward": "none"})
    assert not np.any(silent.reference.velocity)
    assert not np.any(silent.reference.acceleration)
    assert np.any(silent.reference.tip_velocity)


def test_an_axis_that_is_not_upright_is_refused() -> None:
    with pytest.raises(ConfigError, match="upright"):
        mission_of(contact_axis=[0.8, 0.0, 0.6])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_flat_point_keeps_its_distance_from_the_post_and_its_height(side: float) -> None:
    frame, center, radius = contact_frame((1.0, 0.0, 0.0)), np.array([1.0, 0.2, 1.0]), 0.5
    place = side * np.linspace(0.0, 1.5, 7)
    flat = center + place[:, None] * frame.sliding_u + 0.1 * frame.sliding_v - 0.05 * frame.contact
    bent = wrapped_points(flat, frame, center, radius, place)
    axis = center + radius * frame.contact
    np.testing.assert_allclose(np.hypot(*(bent - axis)[:, :2].T), radius + 0.05)
    np.testing.assert_allclose(bent[:, 2], 1.1)
    # A length along the flat path is one along the post's side.
    angle = np.unwrap(np.arctan2(bent[:, 1] - axis[1], -(bent[:, 0] - axis[0])))
    np.testing.assert_allclose(angle, place / radius, atol=1e-9)


def test_a_path_that_goes_around_and_in_at_once_has_the_acceleration_of_its_place() -> None:
    """Coriolis' part too, which a path at one distance from the post has not."""
    frame, center, radius, dt = contact_frame((1.0, 0.0, 0.0)), np.array([1.0, 0.2, 1.0]), 0.5, 1e-3
    t = np.arange(400) * dt
    around = Along(0.3 * np.sin(2.0 * t), 0.6 * np.cos(2.0 * t), -1.2 * np.sin(2.0 * t))
    deep = 0.2 * np.cos(3.0 * t), -0.6 * np.sin(3.0 * t), -1.8 * np.cos(3.0 * t)
    place, rate, bend = (
        np.outer(one, frame.sliding_u) - np.outer(in_, frame.contact)
        for one, in_ in zip(around, deep, strict=True)
    )
    tiled: list[Any] = [np.tile(one, (len(t), 1)) for one in entries(zero_reference(3, 4))]
    rows = Reference(*tiled)
    tip = {"tip_position": center + place, "tip_velocity": rate, "tip_acceleration": bend}
    flat = rows._replace(
        position=center + place, velocity=rate, acceleration=bend, **tip, heading=np.zeros(len(t))
    )
    bent = wrapped(flat, frame, center, radius, around)
    inner = slice(2, -2)
    for where, speed, change in (
        (bent.position, bent.velocity, bent.acceleration),
        (bent.tip_position, bent.tip_velocity, bent.tip_acceleration),
    ):
        np.testing.assert_allclose(np.gradient(where, dt, axis=0)[inner], speed[inner], atol=1e-5)
        np.testing.assert_allclose(np.gradient(speed, dt, axis=0)[inner], change[inner], atol=1e-5)
