"""Where the robot will be at the next tick."""

import numpy as np

import skylimb
from skylimb.control.estimation.prediction import initial_prediction, moved
from skylimb.control.estimation.records import BodyState

ROBOT, DT = skylimb.load_robot("hydrus_xi_quad"), 0.005


def test_what_pushes_and_turns_from_outside_acts_on_the_motion() -> None:
    model = ROBOT.at(ROBOT.nominal_posture(), np.zeros(ROBOT.n_vectoring))
    still, none = np.zeros(3), np.zeros(ROBOT.n_rotors)
    rates, force, torque = np.array([0.1, -0.2, 0.3]), np.array([1.0, 2.0, 3.0]), np.array([0.3, -0.2, 0.1])

    def next_motion(force: np.ndarray, torque: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        state = initial_prediction(ROBOT, none)
        state = state._replace(observer=state.observer._replace(force=force, torque=torque))
        body = BodyState(still, still, np.eye(3), rates, model)
        motion = moved(state, body, np.array([1.0, 0, 0, 0]), none, np.ones(4), 0.0, 0.05, DT).motion
        return np.asarray(motion.velocity), np.asarray(motion.angular_velocity)

    (fallen, turning), (pushed, turned) = next_motion(still, still), next_motion(force, torque)
    np.testing.assert_allclose(pushed - fallen, DT * force / ROBOT.mass, atol=1e-12)
    spin = np.linalg.solve(model.inertia_C, DT * torque)
    np.testing.assert_allclose(turned - turning, model.R_root_C @ spin, atol=1e-12)


def test_rotors_act_as_they_are_in_the_middle_of_their_lag_and_with_what_is_left_of_them() -> None:
    model = ROBOT.at(ROBOT.nominal_posture(), np.zeros(ROBOT.n_vectoring))
    before, command = np.array([8.0, 9.0, 10.0, 11.0]), np.array([12.0, 7.0, 9.0, 10.0])
    left, lag = np.array([1.0, 0.5, 0.9, 1.0]), 0.05
    body = BodyState(np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3), model)
    new = moved(
        initial_prediction(ROBOT, before), body, np.array([1.0, 0, 0, 0]), command, left, 0.0, lag, DT
    )
    after = command + (before - command) * np.exp(-DT / lag)
    np.testing.assert_allclose(new.thrusts, after, atol=1e-12)
    wrench = model.allocation_C @ (left * 0.5 * (before + after))
    np.testing.assert_allclose(new.observer.known_force, wrench[:3] - model.mass * model.gravity, atol=1e-9)
    np.testing.assert_allclose(new.observer.known_torque, wrench[3:], atol=1e-9)
