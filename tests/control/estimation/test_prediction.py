"""Where the robot will be at the next tick."""

import numpy as np

import skylimb
from skylimb.control.estimation.prediction import initial_prediction, moved, seen
from skylimb.control.estimation.records import BodyState, zero_measurement

ROBOT, DT = skylimb.load_robot("hydrus_xi_quad"), 0.005


def test_what_pushes_and_turns_from_outside_acts_on_the_motion() -> None:
    model = ROBOT.at(ROBOT.nominal_posture(), np.zeros(ROBOT.n_vectoring))
    still, none = np.zeros(3), np.zeros(ROBOT.n_rotors)
    rates, force, torque = np.array([0.1, -0.2, 0.3]), np.array([1.0, 2.0, 3.0]), np.array([0.3, -0.2, 0.1])

    def next_motion(force: np.ndarray, torque: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        state = initial_prediction(ROBOT, none)
        state = state._replace(observer=state.observer._replace(force=force, torque=torque))
        body = BodyState(still, still, np.eye(3), rates, model)
        state = state._replace(motion=state.motion._replace(angular_velocity=model.R_root_C @ rates))
        motion = moved(state, body, none, np.ones(4), 0.0, 0.05, DT).motion
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
    new = moved(initial_prediction(ROBOT, before), body, command, left, 0.0, lag, DT)
    after = command + (before - command) * np.exp(-DT / lag)
    np.testing.assert_allclose(new.thrusts, after, atol=1e-12)
    wrench = model.allocation_C @ (left * 0.5 * (before + after))
    np.testing.assert_allclose(new.observer.known_force, wrench[:3] - model.mass * model.gravity, atol=1e-9)
    np.testing.assert_allclose(new.observer.known_torque, wrench[3:], atol=1e-9)


def test_a_pose_that_is_shown_again_is_no_motion_and_friction_is_not_held_as_it_was() -> None:
    model = ROBOT.at(ROBOT.nominal_posture(), np.zeros(ROBOT.n_vectoring))
    measured = zero_measurement(ROBOT.n_joints, ROBOT.n_vectoring)._replace(
        joint_angles=ROBOT.nominal_posture(), quaternion=np.array([1.0, 0.0, 0.0, 0.0])
    )
    axis, speeds = np.array([1.0, 0.0, 0.0]), np.zeros(ROBOT.n_joints + ROBOT.n_vectoring)
    state = initial_prediction(ROBOT, np.zeros(ROBOT.n_rotors))
    state = state._replace(mean=np.array([-1.0, 0.0, 0.0, 0.0, 0.0, 0.0]))

    def after(velocity: np.ndarray, *pose: float):
        body = BodyState(np.ones(3), velocity, np.eye(3), np.zeros(3), model)
        return seen(state, measured, body, speeds, axis, np.array(pose), DT)

    slides = np.array([0.0, 0.1, 0.0])
    np.testing.assert_array_equal(after(slides, 1.0, 1.0).motion.position, np.ones(3))
    for unseen in (after(slides, 1.0, 0.0), after(slides, 0.0, 0.0)):
        np.testing.assert_array_equal(unseen.motion.position, np.zeros(3))
    # Blind, the wrench is the mean one, and friction as the tip goes now.
    there, back = (np.asarray(after(way, 0.0, 0.0).observer.force) for way in (slides, -slides))
    assert there[1] < -0.2
    assert back[1] > 0.2
    np.testing.assert_allclose(there + back, [-2.0, 0.0, 0.0], atol=1e-9)
