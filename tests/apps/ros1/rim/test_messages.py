"""Every hostile message, by real bytes through inbox and pilot: counted, not raised, not commanded."""

from __future__ import annotations

import io
import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from skylimb.analysis.exchange.frames import lab_link
from skylimb.apps.ros1 import topics
from skylimb.apps.ros1.both import Both
from skylimb.apps.ros1.messages import (
    Desire,
    Diagnosis,
    FourAxes,
    Imu,
    Joints,
    Motor,
    MotorInfo,
    Nav,
    Odometry,
    Path,
    Pose,
    PoseControl,
    ServoAngles,
    Transform,
    Transforms,
    UavInfo,
    Wrench,
)
from skylimb.apps.ros1.rim.definitions import Definitions
from skylimb.apps.ros1.rim.inbox import LONGEST, MOST, Inbox, Raw
from skylimb.apps.ros1.rim.reading import plain
from skylimb.apps.ros1.rim.writing import message_of
from skylimb.apps.ros1.states import FlightState
from skylimb.apps.ros1.topics import Topic, spoken
from skylimb.control.thrusts import thrust_limits
from skylimb.flight.realtime.pacer import Pacer
from steered import ready

LEVEL = (1.0, 0.0, 0.0, 0.0)


def raw_of(message: Any, sender: str = "/client") -> Raw:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return Raw(buffer.getvalue(), message._md5sum, message._type, sender, 0.0)


class Wired:
    """The profile `both` behind an inbox that the test fills; its clock stands still but for ticks."""

    def __init__(self, definitions: Definitions) -> None:
        self.definitions = definitions
        self.takes: dict[str, Callable[[Raw], None]] = {}
        self.time, self.k = 0, 0
        self.inbox = Inbox(
            spoken("both").listens, definitions, "hydrus_xi", lambda: 1e-9 * self.time, self._subscribe
        )
        takeoff, controller = ready("hybrid")
        self.pacer = Pacer(takeoff.period, lambda: self.time, self._sleep, spin=0.0)
        missions = {"paper": takeoff.mission}
        self.both = Both(takeoff, controller, missions, lab_link(takeoff.robot), self.pacer)
        self.limits = (thrust_limits(takeoff.robot), takeoff.robot.joint_limits())
        self.said: list[str] = []
        self.pacer.start()

    def _subscribe(self, name: str, take: Callable[[Raw], None]) -> None:
        self.takes[name] = take

    def _sleep(self, seconds: float) -> None:
        self.time += round(seconds * 1e9)

    def make(self, topic: Topic, value: Any = None) -> Any:
        if value is not None:
            return message_of(topic, value, self.definitions.find)
        cls: Any = self.definitions.find(topic.type)
        return cls()

    def send(self, topic: Topic, raw: Raw) -> None:
        self.takes[topic.full("hydrus_xi")](raw)

    def tick(self) -> Any:
        self.pacer.wait(self.k)
        self.both.tick(self.inbox.take(), 1e9 + self.pacer.time())
        self.k += 1
        tick = self.both.last
        assert tick is not None
        self.said += tick.said
        for part, (low, high) in zip(tick.command, self.limits, strict=False):
            assert np.isfinite(part).all()
            assert np.all(part <= high + 1e-6)
            assert np.all(part >= low - 1e-6) or not tick.motors
        return tick

    def until(self, state: FlightState) -> None:
        for _ in range(3000):
            if self.tick().flying.state == state:
                return
        raise AssertionError(f"no {state.name}: {self.said}")

    def hover(self) -> None:
        self.tick()
        self.send(topics.ORDERS[0], raw_of(self.make(topics.ORDERS[0])))
        self.until(FlightState.ARM_ON)
        self.send(topics.ORDERS[1], raw_of(self.make(topics.ORDERS[1])))
        self.until(FlightState.HOVER)


@pytest.fixture(scope="module")
def hovering(definitions: Definitions) -> Wired:
    wired = Wired(definitions)
    wired.hover()
    return wired


def test_what_is_written_is_read_again(definitions: Definitions) -> None:
    pairs = [
        (topics.MOCAP, Pose(12.25, (1.0, 2.0, 3.0), (0.5, 0.5, -0.5, 0.5))),
        (topics.IMU, Imu(12.25, (0.5, 0.5, -0.5, 0.5), (1.0, 2.0, 3.0), (4.0, 5.0, 6.0))),
        (topics.JOINT_STATES, Joints(12.25, ("joint1", "gimbal1"), (0.5, -0.25))),
        (topics.FOUR_AXES, FourAxes((0.0, 0.5, 1.0), (1.0, 2.0, 3.0, 4.0))),
        (topics.SERVO_STATES, ServoAngles(12.25, {0: 2047, 6: -326})),
        (topics.SERVO_TARGETS, ServoAngles(0.0, {0: 2047, 200: -326})),
        (
            topics.MOTOR_INFO,
            MotorInfo(0.5, 0.75, 1.0, 7.0, 0, (Motor(25.0, 33.0, (0.5, -5.25, 0.125, 0.0, 0.0)),)),
        ),
        (topics.UAV_INFO, UavInfo(4, 17)),
        (topics.DESIRE, Desire(0.5, 0.25, -0.5)),
        (topics.CONFIG, 2),
        (topics.STATE, 17),
    ]
    for topic, value in pairs:
        message = message_of(topic, value, definitions.find)
        again = type(message)()
        again.deserialize(raw_of(message).data)
        found = plain(topic.name, again) if topic != topics.STATE else again.data
        assert found == value


def test_every_topic_that_is_said_can_be_written(definitions: Definitions) -> None:
    one = (1.0, 2.0, 3.0)
    values = {
        topics.TF.type: Transforms((Transform(1.0, "world", "hydrus_xi/root", one, LEVEL),)),
        topics.COG.type: Odometry(1.0, "cog", one, LEVEL, one, one),
        topics.PID.type: PoseControl(1.0, (None,) * 6),  # type: ignore[arg-type]
        topics.WRENCH.type: Wrench(1.0, one, one),
        topics.ROW.type: np.array([0.5, np.nan]),
        topics.RECORD.type: ("log.nc", b"abc"),
        topics.MOCAP.type: Pose(1.0, one, LEVEL),
        topics.IMU.type: Imu(1.0, LEVEL, one),
        topics.JOINT_STATES.type: Joints(1.0, ("a",), (1.0,)),
        topics.FOUR_AXES.type: FourAxes(one, (1.0,)),
        topics.CONFIG.type: 1,
        topics.STATE.type: 5,
    }
    values.pop(topics.PID.type)
    for topic in spoken("both").says:
        if topic.type in values:
            raw_of(message_of(topic, values[topic.type], definitions.find))
    assert Diagnosis(0, "well").values == {}


def test_a_wrong_digest_is_counted_and_not_read(hovering: Wired) -> None:
    pose = raw_of(hovering.make(topics.TARGET_POSE, Pose(0.0, (0.0, 0.0, 1.0), LEVEL)))
    hovering.send(topics.TARGET_POSE, pose._replace(md5="0" * 32))
    hovering.tick()
    assert hovering.inbox.counts["wrong md5 of target_pose"] == 1
    flight = hovering.both.pilot.flight
    assert flight is not None
    assert not flight.targets.legs


def test_a_flood_costs_no_more_than_its_newest(hovering: Wired) -> None:
    message = hovering.make(topics.TARGET_POSE, Pose(0.0, (0.0, 0.0, 1.0), LEVEL))
    raw = raw_of(message)
    for _ in range(10_000):
        hovering.send(topics.TARGET_POSE, raw)
    hovering.tick()
    assert hovering.inbox.counts["flood of target_pose"] == 10_000 - MOST
    assert hovering.both.faults["wishes thrown away"] > 0
    assert hovering.inbox.take() == []


def test_bytes_that_are_no_message(hovering: Wired) -> None:
    good = raw_of(hovering.make(topics.JOINTS_CTRL, Joints(0.0, ("joint1",), (0.9,))))
    for data in (b"", b"\xff" * 40, good.data[:-3], bytes(LONGEST + 1)):
        hovering.send(topics.JOINTS_CTRL, good._replace(data=data))
    hovering.tick()
    counts = hovering.inbox.counts
    assert counts["unreadable message on joints_ctrl"] == 3
    assert counts["message too long on joints_ctrl"] == 1


def test_the_battery_has_one_voice_and_nan_does_not_land(hovering: Wired) -> None:
    for sender, volts in (("/spinal", 25.0), ("/other", 1.0), ("/spinal", float("nan"))):
        message = hovering.make(topics.BATTERY)
        message.data = volts
        hovering.send(topics.BATTERY, raw_of(message, sender))
    tick = hovering.tick()
    assert tick.flying.state == FlightState.HOVER
    assert hovering.both.faults["second publisher of battery_voltage_status"] == 1
    assert hovering.both.faults["battery voltage is no number"] == 1


def test_ten_thousand_mutations_raise_nothing_and_command_nothing_out_of_limits(hovering: Wired) -> None:
    rng = random.Random(1)
    odd = [float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 1e-308, 0.0, -0.0, 1e9, 3.0, -7.0]
    poses = Path(tuple(Pose(0.0, (0.1 * k, 0.0, 1.0), LEVEL) for k in range(3)))
    seeds = [
        (topics.TARGET_POSE, hovering.make(topics.TARGET_POSE, poses.poses[0])),
        (
            topics.JOINTS_CTRL,
            hovering.make(topics.JOINTS_CTRL, Joints(0.0, ("joint1", "joint2"), (1.0, 1.1))),
        ),
        (topics.NAV, hovering.make(topics.NAV)),
        (topics.BATTERY, hovering.make(topics.BATTERY)),
        (topics.MISSION, hovering.make(topics.MISSION)),
        (topics.TARGET_PATH, hovering.make(topics.TARGET_PATH)),
    ]
    seeds[3][1].data = 25.0
    done = 0
    while done < 10_000:
        for _ in range(25):
            topic, message = rng.choice(seeds)
            raw = raw_of(message)
            if rng.random() < 0.5:
                data = bytearray(raw.data)
                for _ in range(rng.randint(1, 4)):
                    if data:
                        data[rng.randrange(len(data))] = rng.randrange(256)
                raw = raw._replace(
                    data=bytes(data[: rng.randint(0, len(data))] if rng.random() < 0.2 else data)
                )
            else:
                raw = _with_field(raw, message, rng, odd)
            hovering.send(topic, raw)
            done += 1
        tick = hovering.tick()
        if tick.flying.state not in (FlightState.HOVER, FlightState.TAKEOFF):
            hovering.until(FlightState.ARM_OFF)
            full = hovering.make(topics.BATTERY)
            full.data = 25.0
            hovering.send(topics.BATTERY, raw_of(full))
            hovering.hover()
    assert hovering.both.faults["wish refused"] > 0


def _with_field(raw: Raw, message: Any, rng: random.Random, odd: list[float]) -> Raw:
    """One number of a fresh copy replaced by an odd one."""
    copy = type(message)()
    copy.deserialize(raw.data)
    places: list[Any] = [copy]
    for part in ("pose", "position", "orientation", "header"):
        places += [getattr(place, part) for place in list(places) if hasattr(place, part)]
    place = rng.choice(places)
    names = [name for name in getattr(place, "__slots__", []) if isinstance(getattr(place, name), float)]
    lists = [
        name for name in getattr(place, "__slots__", []) if isinstance(getattr(place, name), (list, tuple))
    ]
    if names:
        setattr(place, rng.choice(names), rng.choice(odd))
    elif lists:
        name = rng.choice(lists)
        values = list(getattr(place, name))
        if values and isinstance(values[0], float):
            values[rng.randrange(len(values))] = rng.choice(odd)
        setattr(place, name, values * rng.randint(0, 3))
    try:
        return raw_of(copy)._replace(sender=raw.sender)
    except Exception:  # no such number fits into its field
        return raw


def test_nav_is_a_wish(hovering: Wired) -> None:
    message = hovering.make(topics.NAV)
    message.pos_xy_nav_mode, message.target_vel_x = 1, 0.1
    found = plain(topics.NAV.name, message)
    assert found == Nav(1, 0, 0, (0.0, 0.0, 0.0), (0.1, 0.0, 0.0))
