"""What is commanded where no controller does."""

import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.supervisor.reserve import reserve_thrusts

ROBOT = skylimb.load_robot("hydrus_xi_quad")
MODEL = ROBOT.at(*nominal_posture(ROBOT, "contact"))


@pytest.mark.parametrize("torque", [(0.3, 0.0, 0.0), (0.0, -0.2, 0.0), (0.2, 0.3, 0.0)])
def test_what_turns_it_from_outside_is_turned_back(torque: tuple[float, ...]) -> None:
    still, made = np.zeros(3), np.asarray(MODEL.hover_thrusts)
    body = BodyState(still, still, np.eye(3), still, MODEL)

    def wrench(torque: np.ndarray) -> np.ndarray:
        outside = Wrench(still, torque)
        thrusts = reserve_thrusts(body, outside, still, np.ones(4), made, ROBOT.thrust_limits())
        return MODEL.allocation_C @ thrusts

    change = wrench(np.array(torque)) - wrench(still)
    np.testing.assert_allclose(change[3:5], -np.array(torque[:2]), atol=0.01)
    assert abs(change[2]) < 0.01  # its lift stays
