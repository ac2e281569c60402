"""Tables of vectoring angles where the angles of most torque cannot be had, or cannot be held."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from skylimb.control.planning import vectoring, vectoring_files
from skylimb.control.planning.joint_torque import joint_torque_function
from skylimb.control.planning.vectoring import vectoring_table
from skylimb.control.planning.vectoring_criteria import CONTACT, TORQUE
from skylimb.control.planning.vectoring_search import bounded_by, no_path
from skylimb.robots import Robot, load_robot

ROBOT = load_robot("hydrus_xi_quad")
Q = ROBOT.nominal_posture()
PSI = vectoring_table(ROBOT).angles(ROBOT.description.posture.theta_nominal)
HELD = joint_torque_function(ROBOT)(Q, PSI).full().ravel()


def with_servos(share: float) -> Robot:
    """The robot with servos of which the table's hover takes a share, at most."""
    servos = replace(ROBOT.description.shape_servos, torque_limit=np.full(3, np.abs(HELD).max() / share))
    return Robot(replace(ROBOT.description, shape_servos=servos))


def test_the_search_sees_the_servos_where_they_count() -> None:
    robot = with_servos(0.5)
    psi = ca.SX.sym("psi", 4)
    usual = _bounded(robot, TORQUE, psi)
    spared = _bounded(robot, replace(TORQUE, servos=0.8), psi)
    assert spared[0].shape[0] == usual[0].shape[0] + 3
    values = ca.Function("values", [psi], [spared[0]])(PSI).full().ravel()
    np.testing.assert_allclose(np.abs(values[-3:]).max(), 0.5, rtol=1e-6)
    assert spared[2][-3:] == [0.8] * 3
    assert spared[1][-3:] == [-0.8] * 3


def _bounded(robot: Robot, criteria, psi):
    _, bounded, low, high = bounded_by(robot, criteria, ca.SX(Q), psi)
    return bounded, low, high


@pytest.mark.parametrize(("share", "searched"), [(0.9, [np.inf]), (1.2, [np.inf, 0.8])])
def test_servos_that_cannot_hold_are_spared_by_another_search(
    monkeypatch: pytest.MonkeyPatch, share: float, searched: list[float]
) -> None:
    seen, usual = [], vectoring_table(ROBOT).coefficients

    def found(robot, criteria, *, cache=True):
        seen.append(criteria.servos)
        return usual, "a digest"

    monkeypatch.setattr(vectoring_files, "find_coefficients", found)
    vectoring_table(with_servos(share))
    assert seen == searched


def test_without_angles_for_contact_it_flies_with_those_of_most_torque(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    usual = vectoring_table(ROBOT).coefficients

    def found(robot, criteria, *, cache=True):
        if criteria == CONTACT:
            raise no_path(robot, criteria)
        return usual, "a digest"

    monkeypatch.setattr(vectoring_files, "find_coefficients", found)
    vectoring._say.cache_clear()  # it is said once a process
    np.testing.assert_array_equal(vectoring_table(ROBOT, "contact").coefficients, usual)
    assert "flies with those of most torque" in caplog.text
