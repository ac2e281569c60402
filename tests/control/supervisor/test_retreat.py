"""Back along the contact axis, then down to the floor: place and speed of the reference."""

import numpy as np
import pytest

import skylimb
from skylimb.base.rotations import rot_z
from skylimb.control.estimation.records import BodyState
from skylimb.control.missions.reference import zero_reference
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.posture import heading_of
from skylimb.control.supervisor.records import initial_watch
from skylimb.control.supervisor.retreat import (
    BACK,
    BACK_SPEED,
    CHANGE,
    DESCENT,
    TURN,
    aimed,
    retreat,
    retreat_time,
    turned_to,
)
from skylimb.control.supervisor.table import TABLE

LAST = zero_reference(3, 4)._replace(
    position=np.array([1.0, 2.0, 1.0]), contact_axis=np.array([1.0, 0.0, 0.0])
)


TURNS = BACK / BACK_SPEED


@pytest.mark.parametrize(
    ("time", "back", "down", "velocity"),
    [
        (0.0, 0.0, 0.0, [0.0, 0.0, 0.0]),
        (1.0, BACK_SPEED * (1.0 - 0.5 * BACK_SPEED / CHANGE), 0.0, [-BACK_SPEED, 0.0, 0.0]),
        (TURNS + 1.0, BACK, DESCENT * (1.0 - 0.5 * DESCENT / CHANGE), [0.0, 0.0, -DESCENT]),
        (60.0, BACK, 0.8, [0.0, 0.0, 0.0]),
    ],
)
def test_it_goes_back_then_down_to_the_floor(
    time: float, back: float, down: float, velocity: list[float]
) -> None:
    found = retreat(LAST, time, floor=0.2)
    np.testing.assert_allclose(found.position, [1.0 - back, 2.0, 1.0 - down], atol=1e-12)
    np.testing.assert_allclose(found.velocity, velocity, atol=1e-12)
    np.testing.assert_allclose(found.acceleration, np.zeros(3), atol=1e-12)


@pytest.mark.parametrize("back", [BACK, 0.0])
def test_its_speed_never_jumps_and_is_that_of_its_place(back: float) -> None:
    """A step of the speed is a step of force: the robot would lose the thrusts that it has left."""
    dt = 1e-3
    path = [retreat(LAST, k * dt, floor=-10.0, back=back) for k in range(4000)]
    place, speed, change = (
        np.array([getattr(one, name) for one in path]) for name in ("position", "velocity", "acceleration")
    )
    assert np.abs(np.diff(speed, axis=0)).max() <= CHANGE * dt * (1.0 + 1e-9)
    np.testing.assert_allclose(np.diff(place, axis=0) / dt, (speed[1:] + speed[:-1]) / 2, atol=CHANGE * dt)
    assert np.abs(change).max() <= CHANGE
    # Where a ramp begins or ends within a tick, the change of that tick is a part of it.
    wrong = np.abs(np.diff(speed, axis=0) / dt - change[:-1]).max(axis=1) > 1e-6
    assert wrong.sum() <= 8
    assert place[-1][0] == pytest.approx(1.0 - back, abs=1e-12)


@pytest.mark.parametrize("height", [0.02, 0.5, 1.2])
def test_it_is_on_the_floor_when_it_says(height: float) -> None:
    last = LAST._replace(position=np.array([1.0, 2.0, height]))
    assert retreat(last, retreat_time(height)).position[2] == pytest.approx(0.0, abs=1e-9)


def test_a_reference_of_no_numbers_is_not_gone_back_to() -> None:
    watch = initial_watch(skylimb.load_robot("hydrus_xi_quad"), imu=False)
    normal, broken_off = TABLE.mode("NORMAL"), TABLE.mode("RETREAT")
    watch, _, aims = aimed(watch, normal, LAST, 0.2, 0.005)
    assert aims == 1.0
    spoilt = LAST._replace(position=np.array([np.nan, 2.0, 1.0]))
    watch, _, aims = aimed(watch, normal, spoilt, 0.2, 0.005)
    assert aims == 0.0
    watch, flown, aims = aimed(watch, broken_off, spoilt, 0.2, 0.005)
    assert aims == 1.0
    np.testing.assert_array_equal(flown.position, LAST.position)


@pytest.mark.parametrize(
    ("away", "turned"), [(0.1, 0.1), (-0.1, -0.1), (2.0, TURN), (-2.0, -TURN), (5.0, -TURN)]
)
@pytest.mark.parametrize("align", [0.0, 1.0])
def test_a_heading_that_is_far_away_is_turned_to_slowly(away: float, turned: float, align: float) -> None:
    robot = skylimb.load_robot("hydrus_xi_quad")
    q, psi = nominal_posture(robot, "contact")
    model = robot.at(q + 0.2, psi)
    body = BodyState(np.zeros(3), np.zeros(3), rot_z(0.4), np.zeros(3), model)
    flown = LAST._replace(joint_angles=q, vectoring_angles=psi, align=align)
    flown = flown._replace(heading=0.4 + away - float(heading_of(robot, model.tip_heading, flown)))
    near = heading_of(robot, model.tip_heading, turned_to(robot, body, flown))
    way = (float(near) - 0.4 + np.pi) % (2.0 * np.pi) - np.pi
    assert way == pytest.approx(turned, abs=1e-9)
