"""What sensors say while they fail, at every tick, against the same flight without the fault."""

from typing import Any

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.errors import SkylimbError
from skylimb.base.rotations import rotation_from_quaternion, rotation_from_vector
from skylimb.flight.events import SensorFault
from skylimb.flight.takeoff import take_off

ONSET = 200
"""Tick at which a fault begins, at 1 s: of motion capture a new frame comes then, and every second tick."""


NAMES = ("position", "quaternion", "velocity", "angular_velocity")
QUIET = {f"sensors.{name}_noise": 0.0 for name in ("position", "attitude", "velocity", "angular_velocity")}


def measured(*faults: dict[str, Any], **settings: Any) -> dict[str, np.ndarray]:
    """What is shown of a robot that turns on the spot, at every tick of a second and a half."""
    events = [{"kind": "sensor", "time": 1.0, **fault} for fault in faults]
    push = {"kind": "push", "time": 0.5, "duration": 1.0, "torque": [0.0, 0.0, 0.3], "force": [0.3, 0.5, 0.7]}
    flight = skylimb.begin("free_flight", set={"events": [*events, push], **settings})
    while flight.time < 1.5:
        flight.tick()
    found = {name: flight.signal(f"root_{name}_measured") for name in NAMES}
    return {**found, "true": flight.signal("configuration"), "age": flight.signal("capture_age")}


def ages(seen: dict[str, np.ndarray], ticks: np.ndarray) -> np.ndarray:
    """How old what is shown without noise is, ticks: the true position nearest to it, of those before."""
    way = np.linalg.norm(seen["position"][ticks, None] - seen["true"][None, :300, :3], axis=2)
    assert way.min(axis=1).max() < 1e-9
    return ticks - way.argmin(axis=1)


def test_without_a_frame_the_last_one_stays() -> None:
    seen = measured({"capture": "lost", "duration": 0.1})
    for name in NAMES:
        assert not np.diff(seen[name][ONSET - 1 : ONSET + 20], axis=0).any()
        assert np.diff(seen[name][ONSET + 19 : ONSET + 21], axis=0).any()
    after = np.arange(ONSET + 20, ONSET + 24)
    assert ages(measured({"capture": "lost", "duration": 0.1}, **QUIET), after).tolist() == [2, 3, 2, 3]


def test_without_a_frame_the_stamp_grows_old() -> None:
    said = measured({"capture": "lost", "duration": 0.1})["age"]
    np.testing.assert_allclose(said[ONSET - 1 : ONSET + 20], 0.015 + 0.005 * np.arange(21), atol=1e-9)
    np.testing.assert_allclose(said[ONSET + 20 : ONSET + 24], [0.01, 0.015, 0.01, 0.015], atol=1e-9)


def test_frozen_capture_sends_new_stamps() -> None:
    seen = measured({"capture": "frozen", "duration": 0.1})
    assert not np.diff(seen["position"][ONSET - 1 : ONSET + 20], axis=0).any()
    np.testing.assert_allclose(seen["age"][ONSET - 1 : ONSET + 20], [0.015, *[0.01, 0.015] * 10], atol=1e-9)


def test_stamps_step() -> None:
    said = measured({"stamp": -0.3, "duration": 0.1})["age"]
    np.testing.assert_allclose(said[ONSET : ONSET + 2], [-0.29, -0.285], atol=1e-9)
    np.testing.assert_allclose(said[ONSET + 20], 0.01, atol=1e-9)


def test_an_imu_is_lost_where_there_is_one() -> None:
    event = {"kind": "sensor", "time": 1.0, "imu": "lost", "duration": 0.1}
    flight = skylimb.begin("free_flight", set={"events": [event], "sensors.imu.on": True})
    while flight.time < 1.2:
        flight.tick()
    rates = flight.signal("imu_angular_velocity_measured")
    assert np.isnan(rates[ONSET : ONSET + 20]).all()
    assert np.isfinite(rates[:ONSET]).all()
    assert np.isfinite(rates[ONSET + 20 :]).all()


def test_a_supervisor_misses_a_frame_that_does_not_come_and_flies_on() -> None:
    event = {"kind": "sensor", "time": 1.0, "capture": "lost", "duration": 0.1}
    flight = skylimb.begin("paper", "hybrid", set={**HOLD, "supervisor.on": True, "events": [event]})
    while flight.time < 1.5:
        flight.tick()
    mode = flight.signal("supervisor_mode")
    assert not mode[: ONSET + 3].any()
    assert mode[ONSET + 3 : ONSET + 20].all()
    assert not mode[ONSET + 22 :].any()


def test_late_frames_are_those_of_before() -> None:
    seen = measured({"late": 0.05}, **QUIET)
    assert not np.diff(seen["position"][ONSET - 1 : ONSET + 10], axis=0).any()
    assert ages(seen, np.arange(ONSET - 4, ONSET)).tolist() == [2, 3, 2, 3]
    assert ages(seen, np.arange(ONSET + 10, ONSET + 14)).tolist() == [12, 13, 12, 13]


def test_no_numbers_are_no_numbers_and_only_for_so_long() -> None:
    seen = measured({"capture": "nan", "duration": 0.01})
    for name in NAMES:
        assert np.isnan(seen[name][ONSET : ONSET + 2]).all()
        assert np.isfinite(seen[name][:ONSET]).all()
        assert np.isfinite(seen[name][ONSET + 2 :]).all()


def test_a_flight_is_not_lost_by_what_a_sensor_says() -> None:
    """The controller that believes it, loses it."""
    event = {"kind": "sensor", "time": 1.0, "capture": "nan", "duration": 0.01}
    run = skylimb.run("paper", "hybrid", set={**HOLD, "events": [event]})
    assert float(run.log.time[-1]) > 1.0


@pytest.mark.parametrize("late", [0, 6])
def test_frames_out_of_order_go_back_and_forth(late: int) -> None:
    seen = measured({"capture": "disordered", "late": 0.005 * late, "duration": 0.2}, **QUIET)
    found = ages(seen, np.arange(ONSET + 8, ONSET + 40, 2))
    assert set(found.tolist()) == {2 + late, 6 + late}
    assert (np.abs(np.diff(found)) == 4).all()
    assert set(ages(seen, np.arange(ONSET + 40, ONSET + 60, 2)).tolist()) == {2}


def test_a_jump_and_a_turn_are_what_they_say() -> None:
    turn, jump = np.array([0.3, -1.0, 2.0]), np.array([0.1, 0.0, -0.2])
    seen, right = measured({"jump": jump, "turn": turn}), measured()
    np.testing.assert_allclose(seen["position"][ONSET] - right["position"][ONSET], jump, atol=1e-12)
    R, R_right = (rotation_from_quaternion(one["quaternion"][ONSET]) for one in (seen, right))
    # To first order in the attitude's own noise, 1 mrad.
    np.testing.assert_allclose(R_right.T @ R, rotation_from_vector(turn), atol=0.01)


@pytest.mark.parametrize(
    ("joint", "signal", "index"), [("joint2", "joint", 1), ("gimbal_joint4", "vectoring", 3)]
)
def test_an_encoder_is_off(joint: str, signal: str, index: int) -> None:
    event = {"kind": "sensor", "time": 1.0, "joint": joint, "offset": 0.05}
    flights = [skylimb.begin("free_flight", set={"events": events}) for events in ([event], [])]
    for flight in flights:
        while flight.time < 1.0 + 1e-6:
            flight.tick()
    off, right = (flight.signal(f"{signal}_angles_measured")[-1] for flight in flights)
    np.testing.assert_allclose(off - right, 0.05 * (np.arange(len(off)) == index), atol=1e-12)


@pytest.mark.parametrize("stuck", ["velocity", "rates", "twist"])
def test_what_is_stuck_of_the_twist_stays_to_the_bit_beside_true_poses(stuck: str) -> None:
    own = {"velocity": "velocity", "rates": "angular_velocity", "way": "position", "turn": "quaternion"}
    # Frames come every second tick; their numbers differ by rounding between the two.
    seen, frames = measured({"stuck": stuck, "duration": 0.1}), slice(ONSET // 2 - 1, ONSET // 2 + 9)
    for key, name in own.items():
        moved = np.any(np.diff(seen[name][1::2], axis=0), axis=1)
        still = key in (stuck, *(("velocity", "rates") if stuck == "twist" else ()))
        assert (moved[frames] != still).all(), name
        assert moved[20 : frames.start].all()
        assert moved[frames.stop :].all()


@pytest.mark.parametrize(("key", "name"), [("velocity", "velocity"), ("rates", "angular_velocity")])
@pytest.mark.parametrize("share", [0.5, -1.0])
def test_a_twist_is_scaled_and_its_noise_is_not(key: str, name: str, share: float) -> None:
    first = slice(ONSET, ONSET + 2)  # what its controller makes of it comes later
    seen, none, right = (measured(*faults)[name] for faults in ([{key: share}], [{key: 0.0}], []))
    true = right[first] - none[first]
    np.testing.assert_allclose(seen[first], share * true + none[first], atol=1e-12)
    assert none[first].all()
    assert not measured({key: 0.0}, **QUIET)[name][first].any()
    np.testing.assert_array_equal(seen[:ONSET], right[:ONSET])


def test_an_encoder_is_stuck_and_comes_back() -> None:
    events = [
        {"kind": "sensor", "time": 1.0, "joint": joint, "stuck": "encoder", "duration": 0.1}
        for joint in ("joint2", "gimbal_joint3")
    ]
    flight = skylimb.begin("free_flight", set={"events": events})
    while flight.time < 1.2:
        flight.tick()
    for signal, index in (("joint", 1), ("vectoring", 2)):
        moved = np.diff(flight.signal(f"{signal}_angles_measured"), axis=0) != 0.0
        still = np.arange(moved.shape[1]) == index
        assert (moved[ONSET - 1 : ONSET + 19] == ~still).all()
        assert moved[: ONSET - 1].all()
        assert moved[ONSET + 19 :].all()


def test_an_encoder_that_is_stuck_from_take_off_on_shows_what_was_before() -> None:
    event = {"kind": "sensor", "time": 0.0, "joint": "joint2", "stuck": "encoder"}
    flights = [skylimb.begin("free_flight", set={"events": events}) for events in ([event], [])]
    for flight in flights:
        while flight.time < 0.1:
            flight.tick()
    seen, right = (flight.signal("joint_angles_measured")[:, 1] for flight in flights)
    assert (seen == seen[0]).all()
    assert 0.0 < abs(seen[0] - right[0]) < 5e-3  # without the noise


def test_two_encoders_may_be_off_at_one_time_and_one_by_one_way_only() -> None:
    def both(second: str) -> Any:
        pairs = (("joint1", 0.05), (second, 0.1))
        return [{"kind": "sensor", "time": 1.0, "joint": joint, "offset": off} for joint, off in pairs]

    skylimb.begin("free_flight", set={"events": both("joint2")})
    with pytest.raises(SkylimbError, match=r"contradict each other: joint1 offset to 0\.1 and to 0\.05"):
        skylimb.begin("free_flight", set={"events": both("joint1")})


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"joint": "joint1"}, "joint .*needs an offset or stuck = 'encoder'"),
        ({"stuck": "encoder"}, "joint .*needs an offset or stuck = 'encoder'"),
        ({"joint": "joint1", "stuck": "rates"}, "joint .*needs an offset"),
        ({"joint": "joint1", "stuck": "encoder", "offset": 0.1}, "offset .*stuck means nothing"),
        ({"stuck": "twist", "rates": 0.5}, "rates .*beside stuck = 'twist'"),
        ({"stuck": "velocity", "velocity": 0.5}, "velocity .*beside stuck = 'velocity'"),
        ({"stuck": "rate"}, "did you mean 'rates'"),
        ({"rates": float("nan")}, "rates"),
        ({"velocity": 11.0}, "velocity"),
        ({}, "changes nothing: give capture, late, .*velocity, rates, .*stuck, imu"),
        ({"velocity": 1.0, "rates": 1.0}, "changes nothing"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(values: dict[str, Any], words: str) -> None:
    with pytest.raises(SkylimbError, match=words):
        skylimb.begin("free_flight", set={"events": [{"kind": "sensor", "time": 1.0, **values}]})


def test_sensors_remember_for_as_long_as_a_fault_looks_back() -> None:
    depths = []
    for events in ([], [{"kind": "sensor", "time": 1.0, "late": 0.1}]):
        (takeoff,) = take_off("paper", ("hybrid",), set={**HOLD, "events": events})
        depths.append(len(takeoff.initial_tick_state[0].history))
    assert depths[1] == depths[0] + 20


def test_what_it_is_called() -> None:
    fault = SensorFault(1.0, capture="lost", late=0.05, stamp=-0.3, joint="joint1", offset=0.1)
    words = "capture lost, capture 50 ms later, stamps -0.3 s older, encoder of joint1 0.1 rad off"
    assert fault.words == words
    stuck = SensorFault(1.0, rates=0.5, joint="joint1", stuck="encoder", imu="lost")
    assert stuck.words == "rates 0.5 times the true ones, encoder of joint1 stuck, IMU lost"
