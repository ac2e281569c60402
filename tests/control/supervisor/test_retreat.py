"""Back along the contact axis, then down to the floor: place and speed of the reference."""

import numpy as np
import pytest

import skylimb
from skylimb.control.missions.reference import zero_reference
from skylimb.control.supervisor.records import initial_watch
from skylimb.control.supervisor.retreat import BACK, BACK_SPEED, DESCENT, aimed, retreat
from skylimb.control.supervisor.table import TABLE

LAST = zero_reference(3, 4)._replace(
    position=np.array([1.0, 2.0, 1.0]), contact_axis=np.array([1.0, 0.0, 0.0])
)


@pytest.mark.parametrize(
    ("time", "back", "down", "velocity"),
    [
        (0.0, 0.0, 0.0, [-BACK_SPEED, 0.0, 0.0]),
        (1.0, BACK_SPEED, 0.0, [-BACK_SPEED, 0.0, 0.0]),
        (BACK / BACK_SPEED + 1.0, BACK, DESCENT, [0.0, 0.0, -DESCENT]),
        (60.0, BACK, 0.8, [0.0, 0.0, 0.0]),
    ],
)
def test_it_goes_back_then_down_to_the_floor(
    time: float, back: float, down: float, velocity: list[float]
) -> None:
    found = retreat(LAST, time, floor=0.2)
    np.testing.assert_allclose(found.position, [1.0 - back, 2.0, 1.0 - down], atol=1e-12)
    np.testing.assert_allclose(found.velocity, velocity, atol=1e-12)
    np.testing.assert_array_equal(found.acceleration, np.zeros(3))


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
