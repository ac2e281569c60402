"""Every hostile message, by real bytes through inbox and pilot: counted, not raised, not commanded."""

from __future__ import annotations

import random
from collections.abc import Callable
from copy import deepcopy
from dataclasses import is_dataclass
from typing import Any

import numpy as np
import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.codec import message_of
from skylimb.analysis.exchange.frames import lab_link
from skylimb.analysis.exchange.lab_messages import pose_errors
from skylimb.analysis.exchange.lab_ticks import Names
from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.analysis.exchange.message_types import Definitions
from skylimb.analysis.exchange.messages import Joints, Path, Pose
from skylimb.apps.ros.both import Both
from skylimb.apps.ros.inbox import LONGEST, MOST, Inbox, Raw
from skylimb.apps.ros.piloted import Flyer
from skylimb.apps.ros.profile import profile_topics
from skylimb.apps.ros.states import FlightState
from skylimb.flight.realtime.pacer import Pacer
from steered import Steered, ready

LEVEL = (1.0, 0.0, 0.0, 0.0)


class Wired:
    """The profile `both` behind an inbox that the test fills; its clock stands still but for ticks."""

    def __init__(self, definitions: Definitions) -> None:
        self.definitions = definitions
        self.takes: dict[str, Callable[[Raw], None]] = {}
        self.time, self.k = 0, 0
        heard = profile_topics("both").subscribed
        self.inbox = Inbox(heard, definitions, "hydrus_xi", lambda: 1e-9 * self.time, self._subscribe)
        takeoff, controller = ready("hybrid")
        self.pacer = Pacer(takeoff.period, lambda: self.time, self._sleep, spin=0.0)
        missions = {"paper": takeoff.mission}
        link = lab_link(takeoff.robot)
        self.both = Both(takeoff, Flyer(takeoff, controller, missions, link, self.pacer))
        self.limits = (takeoff.robot.thrust_limits(), takeoff.robot.joint_limits())
        self.said: list[str] = []
        self.pacer.start()

    def _subscribe(self, name: str, take: Callable[[Raw], None]) -> None:
        self.takes[name] = take

    def _sleep(self, seconds: float) -> None:
        self.time += round(seconds * 1e9)

    def make(self, topic: Topic, value: Any = None) -> Any:
        return message_of(self.definitions.types, topic.type, {} if value is None else value)

    def raw_of(self, message: Any, sender: str = "/client") -> Raw:
        kind = message.__msgtype__
        name, digest, _ = self.definitions.described(kind)
        return Raw(bytes(self.definitions.types.serialize_ros1(message, kind)), digest, name, sender, 0.0)

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
        self.send(topics.ORDERS[0], self.raw_of(self.make(topics.ORDERS[0])))
        self.until(FlightState.ARM_ON)
        self.send(topics.ORDERS[1], self.raw_of(self.make(topics.ORDERS[1])))
        self.until(FlightState.HOVER)


@pytest.fixture(scope="module")
def hovering(definitions: Definitions) -> Wired:
    wired = Wired(definitions)
    wired.hover()
    return wired


def test_a_wrong_digest_is_counted_and_not_read(hovering: Wired) -> None:
    pose = hovering.raw_of(hovering.make(topics.TARGET_POSE, Pose(0.0, (0.0, 0.0, 1.0), LEVEL)))
    hovering.send(topics.TARGET_POSE, pose._replace(md5="0" * 32))
    hovering.tick()
    assert hovering.inbox.counts["wrong md5 of target_pose"] == 1
    flight = hovering.both.pilot.flight
    assert flight is not None
    assert not flight.targets.legs


def test_a_flood_costs_no_more_than_its_newest(hovering: Wired) -> None:
    message = hovering.make(topics.TARGET_POSE, Pose(0.0, (0.0, 0.0, 1.0), LEVEL))
    raw = hovering.raw_of(message)
    for _ in range(10_000):
        hovering.send(topics.TARGET_POSE, raw)
    hovering.tick()
    assert hovering.inbox.counts["flood of target_pose"] == 10_000 - MOST
    assert hovering.both.faults["requests thrown away"] > 0
    assert hovering.inbox.take() == []


def test_bytes_that_are_no_message(hovering: Wired) -> None:
    good = hovering.raw_of(hovering.make(topics.JOINTS_CTRL, Joints(0.0, ("joint1",), (0.9,))))
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
        hovering.send(topics.BATTERY, hovering.raw_of(message, sender))
    tick = hovering.tick()
    assert tick.flying.state == FlightState.HOVER
    assert hovering.both.faults["second publisher of battery_voltage_status"] == 1
    assert hovering.both.faults["battery voltage is none of 6 cells"] == 1


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
            raw = hovering.raw_of(message)
            if rng.random() < 0.5:
                data = bytearray(raw.data)
                for _ in range(rng.randint(1, 4)):
                    if data:
                        data[rng.randrange(len(data))] = rng.randrange(256)
                raw = raw._replace(
                    data=bytes(data[: rng.randint(0, len(data))] if rng.random() < 0.2 else data)
                )
            else:
                raw = _with_field(hovering, raw, message, rng, odd)
            hovering.send(topic, raw)
            done += 1
        tick = hovering.tick()
        if tick.flying.state not in (FlightState.HOVER, FlightState.TAKEOFF):
            hovering.until(FlightState.ARM_OFF)
            full = hovering.make(topics.BATTERY)
            full.data = 25.0
            hovering.send(topics.BATTERY, hovering.raw_of(full))
            hovering.hover()
    assert hovering.both.faults["request refused"] > 0


def _with_field(hovering: Wired, raw: Raw, message: Any, rng: random.Random, odd: list[float]) -> Raw:
    """One number of a fresh copy replaced by an odd one."""
    copy = deepcopy(message)
    places: list[Any] = [copy]
    for part in ("pose", "position", "orientation", "header"):
        places += [getattr(place, part) for place in list(places) if hasattr(place, part)]
    place = rng.choice([place for place in places if is_dataclass(place)])
    parts = {name: part for name, part in vars(place).items() if not name.startswith("_")}
    names = [name for name, part in parts.items() if isinstance(part, float)]
    lists = [name for name, part in parts.items() if isinstance(part, list | np.ndarray)]
    if names:
        setattr(place, rng.choice(names), rng.choice(odd))
    elif lists:
        name = rng.choice(lists)
        values = list(parts[name])
        if values and isinstance(values[0], float):
            values[rng.randrange(len(values))] = rng.choice(odd)
        values = values * rng.randint(0, 3)
        setattr(place, name, np.array(values) if isinstance(parts[name], np.ndarray) else values)
    try:
        return hovering.raw_of(copy)._replace(sender=raw.sender)
    except Exception:  # no such number fits into its field
        return raw


def test_the_terms_of_a_law_are_in_the_labs_own_message(definitions: Definitions) -> None:
    robot = Steered("pid")
    robot.hover()
    told = pose_errors(robot.tick().view(0.0, Names(robot.robot), None))
    types, kind = definitions.types, topics.PID.type
    assert definitions.knows(kind)
    data = types.serialize_ros1(message_of(types, kind, told), kind)
    came: Any = types.deserialize_ros1(bytes(data), kind)
    for axis in (came.x, came.y, came.roll, came.pitch, came.yaw):
        terms = [float(term[0]) for term in (axis.p_term, axis.i_term, axis.d_term)]
        assert terms[0] != 0.0
        assert terms[2] != 0.0
        # In hover nothing is fed forward.
        assert float(axis.total[0]) == pytest.approx(sum(terms), abs=0.02)
    assert came.x.i_term[0] != 0.0
