"""Datagrams over sockets of this machine: who is believed, and who is answered."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import closing

import numpy as np
import pytest

from skylimb.control.estimation.records import Measurement
from skylimb.control.records import Command
from skylimb.flight.realtime.link import RemoteVehicle
from skylimb.flight.realtime.messages import Names, encode
from skylimb.flight.realtime.udp import UdpLink
from skylimb.robots.model import Robot

Make = Callable[..., Measurement]


def bound(host: str) -> socket.socket:
    found = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    found.bind((host, 0))
    found.settimeout(2.0)
    return found


@pytest.fixture
def two() -> Iterator[tuple[socket.socket, socket.socket]]:
    """The robot that is named, and another one on the net."""
    with closing(bound("127.0.0.2")) as named, closing(bound("127.0.0.3")) as other:
        yield named, other


def test_a_state_from_another_address_is_none_of_the_robot_that_was_named(
    robot: Robot, hovering: Make, two: tuple[socket.socket, socket.socket]
) -> None:
    named, other = two
    names = Names(robot)
    with closing(UdpLink(("127.0.0.1", 0), named.getsockname())) as link:
        vehicle = RemoteVehicle(robot, link, time.monotonic)
        for k in range(3):
            for sender, x in ((other, 77.0), (named, 0.0)):
                state = names.state_message(k, 0.1 * k, hovering(position=np.array([x, 0.0, 1.0])))
                sender.sendto(encode(state), link.address)
            deadline = time.monotonic() + 2.0
            while vehicle.counts["not from the robot that was named"] <= k and time.monotonic() < deadline:
                vehicle.measure()
        assert vehicle.measure().position[0] == 0.0
        assert vehicle.counts["not from the robot that was named"] == 3
        vehicle.apply(Command(np.ones(robot.n_rotors), np.zeros(robot.n_joints), np.zeros(robot.n_vectoring)))
        assert named.recvfrom(4096)[1] == link.address


def test_who_names_nobody_answers_only_whom_it_chooses(two: tuple[socket.socket, socket.socket]) -> None:
    first, second = two
    with closing(UdpLink(("127.0.0.1", 0))) as link:
        link.send(b"lost")
        for one in two:
            one.sendto(b"hello", link.address)
        deadline, heard = time.monotonic() + 2.0, list[bool]()
        while len(heard) < 2 and time.monotonic() < deadline:
            heard += [one.stranger for one in link.receive(8)[0]]
        assert heard == [False, False]
        link.answer(second.getsockname())
        link.send(b"you")
        assert second.recvfrom(100)[0] == b"you"
        first.settimeout(0.05)
        with pytest.raises(TimeoutError):
            first.recvfrom(100)
