"""Ways to postures outside the family: planned whole before anything moves, or refused with the reason."""

from __future__ import annotations

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange.messages import Joints
from skylimb.apps.ros.bending import Bending
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.references import References
from skylimb.apps.ros.targets import RefusedError, Shape
from skylimb.control.planning import vectoring_step
from skylimb.control.planning.posture import posture_family
from skylimb.control.planning.vectoring_step import RATE, STEP, TILTED, plan_vectoring
from steered import Steered, in_hover

FAR_OFF = np.array([1.37, 0.99, -1.56])
"""A posture outside the family, and a way to it that leaves torque."""

LINE = np.zeros(3)
"""All links in a line: its rotors have little lever about it."""

LIMITS = FlightLimits()


@pytest.fixture(scope="module")
def references() -> References:
    takeoff = Steered().takeoff
    return References(takeoff.robot, "flight_controller", takeoff.mission.first, "torque")


def planned(bending: Bending) -> Bending:
    for _ in range(3000):
        bending.plan()
        if bending.done or bending.refused:
            return bending
    raise AssertionError("it never comes to an end")


def test_a_way_there_and_back_leaves_torque_and_asks_of_servos_what_they_can(references: References) -> None:
    start = references.shape(0.5)
    there = planned(references.bending(start, FAR_OFF, None, LIMITS))
    assert there.refused == ""
    back = planned(references.bending(there.rows[-1], references.shape(0.5).joints, 0.5, LIMITS))
    assert back.refused == ""
    assert (there.ends, back.ends) == (there.rows[-1], 0.5)
    np.testing.assert_allclose(there.rows[-1].joints, FAR_OFF)
    np.testing.assert_allclose(np.hstack(back.rows[-1]), np.hstack(start), atol=1e-9)
    for way in (there, back):
        joints, gimbals = (np.array([getattr(row, name) for row in way.rows]) for name in Shape._fields)
        assert np.abs(np.diff(joints, axis=0)).max() * RATE <= 1.9 * LIMITS.joint_speed
        assert np.abs(np.diff(gimbals, axis=0)).max() <= STEP + 1e-9
        assert way.duration == pytest.approx((len(way.rows) - 1) / RATE)
        for row in way.rows[:: len(way.rows) // 20]:
            plan = plan_vectoring(references.robot, *row, 0.0)
            assert plan.margin >= references.least
            assert plan.tilt <= TILTED


def test_a_way_that_leaves_no_torque_is_refused_with_where_it_ends(references: References) -> None:
    bending = planned(references.bending(references.shape(0.5), LINE, None, LIMITS))
    assert "% of the way there, " in bending.refused
    assert f"it takes {references.least:.2f} N m" in bending.refused


def test_what_plans_is_made_before_a_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    """Making it takes longer than a tick."""
    made: list[str] = []
    whole = vectoring_step.planning_function
    monkeypatch.setattr(
        vectoring_step, "planning_function", lambda robot: made.append(robot.name) or whole(robot)
    )
    Steered()
    assert made == ["hydrus_xi_quad"]


def test_on_the_ground_the_best_gimbals_are_taken_and_what_cannot_fly_is_refused(
    references: References,
) -> None:
    shape = references.on_ground(FAR_OFF)
    assert plan_vectoring(references.robot, *shape, 0.0).margin > references.least
    with pytest.raises(RefusedError, match="N m are left about its axes"):
        references.on_ground(LINE)


def test_a_hovering_robot_bends_out_of_its_family_and_back(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = in_hover()
    near = np.array([1.2, 1.0, -0.75])
    assert robot.pilot._requests.in_family(near) is None
    robot.tick(requests=(Joints(0.0, (), tuple(near.tolist())),))
    robot.fly(3.2)
    np.testing.assert_allclose(robot.plant.measure().joint_angles, near, atol=0.07)
    robot.tick(mission="paper")
    assert "it begins in the family of postures; joints_ctrl to (" in robot.said[-1]
    family = posture_family(skylimb.load_robot("hydrus_xi_quad"))
    home = tuple(np.asarray(family.joint_angles(0.5), dtype=float).tolist())
    robot.tick(requests=(Joints(0.0, (), home),))
    robot.fly(3.5)
    assert robot.pilot.flight is not None
    assert robot.pilot.flight.form == 0.5
    monkeypatch.setattr("skylimb.apps.ros.bending._SLOWER", (1.0,))
    robot.tick(requests=(Joints(0.0, (), tuple(LINE.tolist())),))
    robot.fly(0.8)
    assert robot.said[-1].startswith("joints refused: ")
    assert robot.pilot.flight.form == 0.5
    assert robot.pilot.faults["request refused"] == 2
