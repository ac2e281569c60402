"""The message layer under bad messages: no exception gets out, no command leaves its limits."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections import deque
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import pytest

import skylimb
from skylimb.control.estimation.records import Imu, Measurement
from skylimb.control.missions.reference import zero_reference
from skylimb.flight.realtime.compiled_controller import CompiledController
from skylimb.flight.realtime.guard import GuardedController
from skylimb.flight.realtime.link import ANOTHER, MOST, Datagram, RemoteVehicle
from skylimb.flight.realtime.messages import (
    LONGEST,
    CommandMessage,
    Names,
    RefusedMessageError,
    StateMessage,
    decode,
    encode,
)
from skylimb.robots.model import Robot

Make = Callable[..., Measurement]
DT = 0.005


class Wire:
    """A link whose other end is in the test's hands."""

    def __init__(self) -> None:
        self.coming: deque[Datagram] = deque()
        self.sent: list[bytes] = []

    def receive(self, most: int) -> tuple[list[Datagram], int]:
        dropped = max(0, len(self.coming) - most)
        found = list(self.coming)[dropped:]
        self.coming.clear()
        return found, dropped

    def send(self, data: bytes) -> None:
        self.sent.append(data)

    def put(self, data: bytes, sender: str = "robot") -> None:
        self.coming.append(Datagram(data, sender))


class Vehicle:
    """A linked vehicle with its wire and its clock."""

    def __init__(self, robot: Robot) -> None:
        self.wire, self.time, self.told = Wire(), 0.0, list[float]()
        self.names = Names(robot)
        self.vehicle = RemoteVehicle(robot, self.wire, lambda: self.time, self.told.append)

    def state(self, measurement: Measurement, seq: int, stamp: float | None = None) -> StateMessage:
        return self.names.state_message(seq, seq * DT if stamp is None else stamp, measurement)


@pytest.fixture
def linked(robot: Robot) -> Vehicle:
    return Vehicle(robot)


def test_a_message_goes_there_and_back(robot: Robot, hovering: Make) -> None:
    names, sent = Names(robot), hovering(velocity=np.array([1.0, 2.0, 1e-300]))
    message = decode(encode(names.state_message(7, 0.1, sent)), StateMessage)
    assert (message.seq, message.stamp) == (7, 0.1)
    assert names.measurement(message).imu is None
    for one, two in zip(sent.entries, names.measurement(message).entries, strict=True):
        np.testing.assert_array_equal(one, two)


def test_an_imu_and_the_age_of_the_frame_travel_too(robot: Robot, hovering: Make) -> None:
    names, imu = Names(robot), Imu(np.array([0.1, 0.2, 0.3]), np.array([0.0, -0.1, 9.8]))
    sent = hovering()._replace(capture_age=0.015, imu=imu)
    message = decode(encode(names.state_message(0, 0.0, sent)), StateMessage)
    for one, two in zip(sent.entries, names.measurement(message).entries, strict=True):
        np.testing.assert_array_equal(one, two)
    wire = Wire()
    blind, seeing = (RemoteVehicle(robot, wire, lambda: 0.25, imu=imu) for imu in (False, True))
    for vehicle in (blind, seeing):
        wire.put(encode(message))
        measured = vehicle.measure()
        assert measured.capture_age == pytest.approx(0.015)
        assert (measured.imu is None) == (vehicle is blind)
    assert seeing.layout.size == blind.layout.size + 6
    wire.put(encode(names.state_message(1, 0.1, hovering())))
    seeing.measure()
    assert dict(seeing.counts) == {"no imu": 1}


def test_a_frame_that_is_seen_again_is_older(linked: Vehicle, hovering: Make) -> None:
    linked.wire.put(encode(linked.state(hovering()._replace(capture_age=0.01), 0)))
    assert linked.vehicle.measure().capture_age == pytest.approx(0.01)
    linked.time = 0.3
    assert linked.vehicle.measure().capture_age == pytest.approx(0.31)


@pytest.mark.parametrize(
    ("said", "counted"),
    [
        ([None] * 5, 0.0),
        ([0.04] * 5, 0.04),
        ([0.2, 0.3, 0.03, 0.4, 0.2], 0.03),  # one that is in time shows that the loop is fast
        ([math.nan, -1.0, math.inf, 0.05, 0.06], 0.05),
    ],
)
def test_the_least_that_a_robot_said_lately_is_how_slow_the_loop_is(
    linked: Vehicle, hovering: Make, said: list[float | None], counted: float
) -> None:
    for seq, delay in enumerate(said):
        linked.time = 0.1 * seq
        state = linked.state(hovering(), seq, linked.time)
        linked.wire.put(encode(dataclasses.replace(state, loop_delay=delay)))
        linked.vehicle.measure()
    assert linked.vehicle.loop_delay == counted
    linked.time += 0.6
    linked.vehicle.measure()
    assert linked.vehicle.loop_delay == 0.0  # who is silent says nothing


def test_joints_are_found_by_name(robot: Robot, hovering: Make) -> None:
    names, sent = Names(robot), hovering(joint_angles=np.array([0.1, 0.2, 0.3]))
    message = names.state_message(0, 0.0, sent)
    shuffled = dataclasses.replace(message, names=message.names[::-1], angles=message.angles[::-1])
    np.testing.assert_array_equal(names.measurement(shuffled).joint_angles, [0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"names": ("joint1",) * 7}, "wrong joint names"),
        ({"names": ("a", "b", "c", "d", "e", "f", "g")}, "wrong joint names"),
        ({"angles": (0.0,) * 6}, "wrong size"),
        ({"stamp": float("nan")}, "stamp is no number"),
        ({"position": (0.0, 0.0)}, "no message of ours"),
        ({"position": "here"}, "no message of ours"),
        ({"seq": 1.5}, "no message of ours"),
        ({"angles": (0.0,) * 2000}, "message too long"),
    ],
)
def test_what_is_wrong_with_a_message_is_counted(
    linked: Vehicle, hovering: Make, change: dict[str, Any], fault: str
) -> None:
    fields = msgspec.to_builtins(linked.state(hovering(), 0))
    linked.wire.put(msgspec.msgpack.encode({**fields, **change}))
    measured = linked.vehicle.measure()
    assert dict(linked.vehicle.counts) == {fault: 1}
    assert not linked.vehicle.heard
    assert np.isnan(measured.position).all()


def test_the_newest_measurement_counts_and_its_age_is_told(linked: Vehicle, hovering: Make) -> None:
    for seq in range(3):
        linked.wire.put(encode(linked.state(hovering(position=np.full(3, float(seq))), seq, 50.0 + seq * DT)))
    linked.time = 1.0
    assert linked.vehicle.measure().position[0] == 2.0
    assert linked.told[-1] == pytest.approx(1.0)
    linked.time = 1.2
    assert linked.vehicle.measure().position[0] == 2.0
    assert linked.told[-1] == pytest.approx(1.0)  # it gets no younger


def test_order_senders_and_floods(linked: Vehicle, hovering: Make) -> None:
    linked.wire.put(encode(linked.state(hovering(), 5)))
    linked.vehicle.measure()
    for seq, sender in ((5, "robot"), (4, "robot"), (6, "other")):
        linked.time += DT
        linked.wire.put(encode(linked.state(hovering(position=np.ones(3)), seq)), sender)
    linked.wire.put(encode(linked.state(hovering(position=np.ones(3)), 7, stamp=1e9)))
    assert linked.vehicle.measure().position[2] == 1.0
    assert dict(linked.vehicle.counts) == {
        "stamp repeated or out of order": 2, "second sender": 1, "stamp from the future": 1,
    }  # fmt: skip
    linked.time += DT
    for seq in range(8, 8 + 100):
        linked.wire.put(encode(linked.state(hovering(), seq, 8 * DT + seq * 1e-6)))
    linked.vehicle.measure()
    assert linked.vehicle.counts["flood"] == 100 - MOST


def test_a_robot_that_is_started_anew_is_listened_to_once_the_first_is_silent(
    linked: Vehicle, hovering: Make
) -> None:
    """From another port, with a clock and numbers that begin anew."""
    heights = list[float]()
    for k in range(200):
        linked.time = 10.0 + DT * k
        if k < 50:
            linked.wire.put(encode(linked.state(hovering(), k)))
        if k >= 30:
            other = hovering(position=np.array([0.0, 0.0, 2.0]))
            linked.wire.put(encode(linked.state(other, k - 30)), "anew")
        heights.append(float(linked.vehicle.measure().position[2]))
    changed = heights.index(2.0)
    assert changed == pytest.approx(49 + 0.2 / DT, abs=2)
    assert linked.told[-1] == pytest.approx(linked.time)
    assert heights[changed:] == [2.0] * (200 - changed)
    assert linked.vehicle.counts[ANOTHER] == 1
    assert linked.vehicle.counts["second sender"] == pytest.approx(20 + 0.2 / DT, abs=3)


def test_a_command_names_its_joints(linked: Vehicle, robot: Robot, hovering: Make) -> None:
    linked.wire.put(encode(linked.state(hovering(), 3, 0.25)))
    linked.vehicle.measure()
    command = skylimb.Command(np.arange(4.0), np.arange(3.0), np.arange(4.0))
    linked.vehicle.apply(command)
    message = decode(linked.wire.sent[0], CommandMessage)
    assert (message.seq, message.stamp) == (0, 0.25)
    for one, two in zip(linked.names.command(message), command, strict=True):
        np.testing.assert_array_equal(one, two)
    assert linked.vehicle.record(hovering(), command).shape == (linked.vehicle.layout.size,)
    assert linked.vehicle.fault() == ""
    linked.vehicle.greet()
    with pytest.raises(RefusedMessageError):
        decode(linked.wire.sent[-1], CommandMessage)


ODD: tuple[Any, ...] = (
    None, True, -1, 0, 2**63, 1e308, -1e308, float("nan"), float("inf"), 5e-324, "", "joint1", b"\x00\xff",
    [], [[]], {}, [float("nan")] * 3, [0.0] * 4, [1e9] * 3, ["joint1"] * 7, list(range(50)), {"a": 1},
)  # fmt: skip


def spoiled(rng: np.random.Generator, fields: dict[str, Any]) -> bytes:
    """A message with one to three random changes of its fields, or of its bytes."""
    fields = {name: list(value) if isinstance(value, tuple) else value for name, value in fields.items()}
    for _ in range(rng.integers(1, 4)):
        key = list(fields)[rng.integers(len(fields))] if fields else "seq"
        odd = copy.deepcopy(ODD[rng.integers(len(ODD))])
        value, kind = fields.get(key), rng.integers(6)
        if kind == 0:
            fields.pop(key, None)
        elif kind == 1:
            fields[key] = odd
        elif kind == 2 and isinstance(value, list) and value:
            value[rng.integers(len(value))] = odd
        elif kind == 3 and isinstance(value, list):
            fields[key] = value[: rng.integers(len(value) + 1)] * int(rng.integers(1, 3))
        elif kind == 4 and isinstance(value, list):
            fields[key] = [
                one + float(rng.normal(scale=10.0 ** rng.integers(-3, 3))) if isinstance(one, float) else one
                for one in value
            ]
        elif isinstance(value, float | int):
            fields[key] = value + float(rng.normal(scale=10.0 ** rng.integers(-4, 9)))
    data = bytearray(msgspec.msgpack.encode(fields))
    for _ in range(rng.integers(0, 3) if rng.random() < 0.3 else 0):
        data[rng.integers(len(data))] = rng.integers(256)
    return bytes(data[: rng.integers(len(data) + 1)] if rng.random() < 0.05 else data)


def test_two_thousand_spoiled_messages(robot: Robot, hovering: Make) -> None:
    """The real controller flies on them: every command is finite and within limits, and nothing is raised."""
    rng, linked, time = np.random.default_rng(3), Vehicle(robot), 0.0
    controller: Any = skylimb.load_controller("following", robot)
    guard = GuardedController(CompiledController(controller, DT), robot)
    linked.vehicle = RemoteVehicle(robot, linked.wire, lambda: linked.time, guard.taken)
    reference = zero_reference(3, 4)._replace(
        position=np.array([0.0, 0.0, 1.0]), reach=1.0, contact_axis=np.array([1.0, 0.0, 0.0]),
        sliding_axis=np.array([0.0, 1.0, 0.0]), joint_angles=hovering().joint_angles,
        vectoring_angles=hovering().vectoring_angles, touch=1.0, adapt=1.0,
    )  # fmt: skip
    low, high = robot.thrust_limits()
    bottom, top = robot.joint_limits()
    state, flown = guard.initial_state(), 0
    for k in range(2_000):
        time = linked.time = k * DT
        fields = msgspec.to_builtins(linked.state(hovering(), k))
        linked.wire.put(spoiled(rng, fields), "robot" if rng.random() < 0.95 else "other")
        if k % 20 == 0:
            linked.wire.put(encode(linked.state(hovering(), k, time + 1e-4)))
        measured = linked.vehicle.measure()
        state, command, own = guard.step(guard.gains(), state, measured, reference, DT)
        flown += own["tick_held"] == 0.0
        assert np.all((command.thrusts >= low) & (command.thrusts <= high)), k
        assert np.all((command.joint_angles >= bottom) & (command.joint_angles <= top)), k
        assert np.isfinite(command.vectoring_angles).all(), k
        linked.vehicle.apply(command)
        decode(linked.wire.sent.pop(), CommandMessage)
    assert np.isfinite(state).all()
    assert flown > 20
    assert len(linked.vehicle.counts) >= 5
    assert set(guard.counts) >= {"not finite", "no attitude", "jump", "angle out of range", "too fast"}


def test_bytes_that_are_nothing_are_refused() -> None:
    rng = np.random.default_rng(0)
    for length in (0, 1, 3, 100, LONGEST, LONGEST + 1):
        with pytest.raises(RefusedMessageError):
            decode(rng.bytes(length), StateMessage)
    with pytest.raises(RefusedMessageError):
        decode(b"\xdf\xff\xff\xff\xff", CommandMessage)
