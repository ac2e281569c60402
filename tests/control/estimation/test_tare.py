import numpy as np

from skylimb.base.rotations import rot_z
from skylimb.control.estimation.records import Wrench
from skylimb.control.estimation.tare import TareState, tare

BIAS = np.array([0.3, -0.1, 0.2])


def test_the_mean_of_the_tare_phase_is_taken_off_afterwards() -> None:
    rng = np.random.default_rng(0)
    state, samples = TareState(), BIAS + 0.01 * rng.standard_normal((100, 3))
    for sample in samples:
        state, _ = tare(state, Wrench(sample, 0.1 * sample), 0.0, 1.0)
    state, wrench = tare(state, Wrench(BIAS + 1.0, np.zeros(3)), 0.0, 0.0)
    np.testing.assert_allclose(wrench.force, BIAS + 1.0 - samples.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(wrench.torque, -0.1 * samples.mean(axis=0), atol=1e-12)


def test_the_force_bias_turns_with_the_robot() -> None:
    state, _ = tare(TareState(), Wrench(BIAS, np.zeros(3)), 0.0, 1.0)
    _, wrench = tare(state, Wrench(rot_z(1.2) @ BIAS, np.zeros(3)), 1.2, 0.0)
    np.testing.assert_allclose(wrench.force, 0.0, atol=1e-12)


def test_before_the_tare_nothing_is_taken_off() -> None:
    _, wrench = tare(TareState(), Wrench(BIAS, BIAS), 0.4, 0.0)
    np.testing.assert_array_equal(wrench.force, BIAS)


def test_one_tick_in_numbers() -> None:
    before = TareState(np.array([0.1, 0.2, 0.3]), np.array([0.01, 0.02, 0.03]), 3.0)
    raw = Wrench(np.array([1.0, -1.0, 0.5]), np.array([0.1, 0.0, -0.1]))
    yaw = 0.8
    state, wrench = tare(before, raw, yaw, 1.0)
    assert state.ticks == 4.0
    np.testing.assert_allclose(state.force, before.force + (rot_z(yaw).T @ raw.force - before.force) / 4.0)
    np.testing.assert_allclose(state.torque, before.torque + (raw.torque - before.torque) / 4.0)
    np.testing.assert_allclose(wrench.force, raw.force - rot_z(yaw) @ state.force)
    np.testing.assert_allclose(wrench.torque, raw.torque - state.torque)
    later, _ = tare(state, Wrench(10.0 * raw.force, 10.0 * raw.torque), 0.1, 0.0)
    np.testing.assert_array_equal(later.force, state.force)
    np.testing.assert_array_equal(later.torque, state.torque)
    assert later.ticks == 4.0
