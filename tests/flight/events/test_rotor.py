"""A rotor's effectiveness is what the engine makes of its activation; a battery's share multiplies."""

from typing import Any

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.flight.takeoff import take_off


def test_a_battery_and_a_rotor_multiply_and_a_change_takes_its_time() -> None:
    events: list[dict[str, Any]] = [
        {"kind": "rotor", "time": 0.5, "duration": 1.0, "effectiveness": 0.8},
        {"kind": "rotor", "time": 1.0, "rotor": "rotor3", "effectiveness": 0.5},
        {"kind": "rotor", "time": 1.2, "rotor": "rotor3", "effectiveness": 1.0},
    ]
    settings = {**HOLD, "events": events, "plant.rotor_scale": [1.0, 1.1, 1.0, 1.0]}
    (takeoff,) = take_off("paper", ("hybrid",), set=settings)
    rows, times = takeoff.timeline(takeoff.times).model, takeoff.times
    assert rows is not None
    left = np.interp(times, [0.5, 1.5], [1.0, 0.8])
    np.testing.assert_allclose(rows.values[:, 1], 1.1 * left, atol=1e-12)
    hurt = (times > 1.0 - 1e-9) & (times < 1.2 - 1e-9)
    np.testing.assert_allclose(rows.values[:, 2], np.where(hurt, 0.5, 1.0) * left, atol=1e-12)


@pytest.mark.parametrize("rotors", ["thrust", "speed"])
def test_a_robot_without_any_thrust_falls(rotors: str) -> None:
    event = {"kind": "rotor", "time": 0.1, "effectiveness": 0.0}
    flight = skylimb.begin("free_flight", set={"events": [event], "plant.rotors": rotors})
    while flight.time < 0.2:
        flight.tick()
    lift = flight.signal("configuration_velocity")[:, 2]
    fallen = np.diff(lift[22:30]) / flight.takeoff.period
    # The root is not the centre of gravity, but at first nothing turns it.
    np.testing.assert_allclose(fallen, -9.80665, rtol=0.02)
    thrusts = flight.signal("thrusts")
    assert np.all(thrusts[:20] > 1.0)
    assert not thrusts[20:].any()


def test_a_weak_rotor_turns_as_fast_as_it_is_told_and_its_motor_has_less_to_do() -> None:
    flight = skylimb.begin("free_flight", set={"plant.thrust_scale": 0.8})
    for _ in range(101):
        flight.tick()
    thrusts, speeds = flight.signal("thrusts"), flight.signal("rotor_speeds")
    rotor = flight.takeoff.robot.description.rotors[0]
    assert rotor.thrust_factor is not None
    assert rotor.inertia is not None
    np.testing.assert_allclose(thrusts, 0.8 * rotor.thrust_factor * speeds**2, rtol=1e-12)
    gained = rotor.inertia * np.diff(speeds, axis=0) / flight.takeoff.period
    drag = abs(rotor.drag_torque_coefficient) * 0.5 * (thrusts[1:] + thrusts[:-1])
    np.testing.assert_allclose(flight.signal("motor_torques")[:-1], gained + drag, atol=2e-3)
