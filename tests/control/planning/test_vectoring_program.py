"""The derivatives of the path program against finite differences."""

import casadi as ca
import numpy as np
import pytest

from skylimb.control.planning.vectoring_criteria import CONTACT, TORQUE
from skylimb.control.planning.vectoring_program import PathProgram
from skylimb.control.planning.vectoring_search import posture_function
from skylimb.robots import load_robot

STEP = 1e-6


@pytest.mark.parametrize("criteria", [TORQUE, CONTACT])
def test_derivatives_agree_with_finite_differences(criteria):
    robot = load_robot("hydrus_xi_quad")
    program = PathProgram(posture_function(robot, criteria), criteria, degree=2, nodes=3, iterations=1)
    solver = program.ipopt
    first, second = solver.get_function("nlp_jac_g"), solver.get_function("nlp_hess_l")
    rng = np.random.default_rng(3)
    x = np.concatenate([np.tile([2.5, -1.6, -2.6, 1.8], 1), 0.1 * rng.standard_normal(8), np.ones(5)])
    weights = rng.standard_normal(first.size1_out(0))

    def jacobian(at):
        return first(at, [])[1].full()

    def gradient(at):
        """Of 0.7 f + weights . g; f is quadratic, its gradient is exact."""
        point = ca.MX.sym("x", len(x))
        f = solver.get_function("nlp_grad_f")(point, [])[1]
        return 0.7 * ca.Function("f", [point], [f])(at).full().ravel() + jacobian(at).T @ weights

    steps = STEP * np.eye(len(x))
    g = lambda at: first(at, [])[0].full().ravel()  # noqa: E731
    by_steps = np.stack([(g(x + d) - g(x - d)) / (2.0 * STEP) for d in steps], axis=1)
    np.testing.assert_allclose(jacobian(x), by_steps, atol=1e-6)
    by_steps = np.stack([(gradient(x + d) - gradient(x - d)) / (2.0 * STEP) for d in steps], axis=1)
    upper = second(x, [], 0.7, weights).full()
    np.testing.assert_allclose(upper, np.triu(by_steps), atol=1e-5 * np.abs(by_steps).max())
