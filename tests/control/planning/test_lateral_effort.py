"""Vectoring per newton sideways, against differences of the net wrench."""

import casadi as ca
import numpy as np
import pytest

from skylimb.base.rotations import rot_z
from skylimb.control.planning.lateral_effort import lateral_effort
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.robots import load_robot

ROBOT = load_robot("hydrus_xi_quad")


@pytest.mark.parametrize("purpose", ["torque", "contact"])
@pytest.mark.parametrize("theta", [0.25, 0.6])
def test_a_newton_sideways_takes_this_much(purpose, theta):
    q = np.array([np.pi / 2 - theta, 2 * theta, -theta])
    psi = vectoring_table(ROBOT, purpose).angles(theta)
    hover = ROBOT.at(q, psi)
    to_heading = np.kron(np.eye(2), (hover.R_root_C @ rot_z(hover.tip_heading)).T)

    def wrench(change):
        state = ROBOT.at(q, psi + change[4:])
        in_C = state.allocation_C @ (hover.hover_thrusts + change[:4])
        return to_heading @ np.kron(np.eye(2), state.R_root_C) @ in_C

    step = 1e-5
    J = np.array([(wrench(step * e) - wrench(-step * e)) / (2 * step) for e in np.eye(8)]).T
    expected = np.linalg.norm(np.linalg.pinv(J)[4:, :2], axis=0)
    np.testing.assert_allclose(lateral_effort(ROBOT, q, psi), expected, rtol=1e-5)
    symbols = ca.SX.sym("psi", 4)
    f = ca.Function("f", [symbols], [lateral_effort(ROBOT, ca.SX(q), symbols)])
    np.testing.assert_allclose(f(psi).full().ravel(), expected, rtol=1e-5)
