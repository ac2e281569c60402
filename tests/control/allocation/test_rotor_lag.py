"""The rotors' lag and its lead against what a first-order lag really does."""

import numpy as np
import pytest

from skylimb.control.allocation.rotor_lag import RotorLag, Rotors, at_rest, lead_thrusts

DT = 0.005


def test_the_lead_makes_a_first_order_lag_faster() -> None:
    gains = RotorLag(compensate=True, time_constant=0.05, lead=2.0)
    wanted, limits = np.array([10.0]), (np.array([0.0]), np.array([30.0]))
    modelled, thrust, fine = np.array([5.0]), 5.0, 200
    decay = np.exp(-DT / fine / 0.05)
    found = []
    for _ in range(40):
        command, mean, end = lead_thrusts(gains, at_rest(modelled), wanted, limits, gains.time_constant, DT)
        # The rotors as they are, in small steps.
        total = 0.0
        for _ in range(fine):
            after = command[0] + (thrust - command[0]) * decay
            total += 0.5 * (thrust + after)
            thrust = after
        assert end[0] == pytest.approx(thrust, abs=1e-9)
        assert mean[0] == pytest.approx(total / fine, abs=1e-5)
        modelled = end
        found.append(thrust)
    # Twice as fast: what is missing decays as exp(-2 t / lag) does, up to the tick's own length.
    missing = (10.0 - np.array(found)) / 5.0
    np.testing.assert_allclose(missing, np.exp(-2.0 * DT / 0.05 * np.arange(1, 41)), atol=0.02)


def test_the_command_stays_within_the_limits_and_the_model_knows_it() -> None:
    gains, limits = RotorLag(compensate=True, lead=10.0), (np.array([1.0]), np.array([12.0]))
    command, _, end = lead_thrusts(
        gains, at_rest(np.array([5.0])), np.array([20.0]), limits, gains.time_constant, DT
    )
    assert command[0] == 12.0
    assert 5.0 < end[0] < 12.0


@pytest.mark.parametrize("lag", [1e-4, 0.001, 0.005])
def test_rotors_without_a_lag_are_not_led_into_ringing(lag: float) -> None:
    gains, limits = RotorLag(compensate=True, time_constant=lag, lead=3.0), (np.zeros(1), np.full(1, 30.0))
    end = np.array([5.0])
    for _ in range(10):
        _, _, end = lead_thrusts(gains, at_rest(end), np.array([10.0]), limits, gains.time_constant, DT)
        assert end[0] <= 10.0 + 1e-9
    assert end[0] == pytest.approx(10.0, abs=1e-6)


def test_a_bandwidth_takes_the_jumps_off_the_led_command() -> None:
    limits, rng = (np.zeros(1), np.full(1, 30.0)), np.random.default_rng(3)
    wanted = 10.0 + rng.normal(size=(400, 1))
    jumps = []
    for bandwidth in (1e6, 75.0):
        gains, rotors, commands = (
            RotorLag(compensate=True, bandwidth=bandwidth),
            at_rest(np.full(1, 10.0)),
            [],
        )
        for one in wanted:
            led = lead_thrusts(gains, rotors, one, limits, gains.time_constant, DT)
            rotors = Rotors(led.end, led.command)
            commands.append(led.command[0])
        jumps.append(np.std(np.diff(commands)))
    assert 0.1 * jumps[0] < jumps[1] < 0.4 * jumps[0]
