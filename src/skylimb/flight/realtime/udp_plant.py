"""A simulator in a program of its own, in lock-step over UDP: a plant that is stepped by messages.

Each message is a msgpack map in one datagram. What is asked again, as an answer was lost, has the same
number: whoever is asked gives the same answer again and does not step twice.
"""

from __future__ import annotations

import socket
import time
import weakref
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from skylimb.base.errors import ConfigError, UserCodeError
from skylimb.flight.realtime.udp import address_of
from skylimb.simulation.user_plant import Beginning, Drive

_LONGEST = 65507
"""Bytes of a datagram."""
_AGAIN = 0.2
"""After so long without an answer it is asked again, s."""


class UdpPlant:
    """Follows `UserPlant` for a simulator behind a socket, which may be slower or faster than time.

    Args:
        address: where it listens, "127.0.0.1:9871".
        anywhere: whether that may be another machine.
        patience: after so long without an answer it has failed, s.

    Its socket closes when nobody holds it any more.

    Raises:
        ConfigError: when the address is none, or another machine's without `anywhere`; when the patience is
            no time.
    """

    name = "udp"

    def __init__(self, address: str, anywhere: bool = False, patience: float = 10.0) -> None:
        if not (isinstance(patience, int | float) and patience > 0.0):
            raise ConfigError(f"patience = {patience!r} is no number of seconds above 0")
        self._peer, self._patience = address_of(address, anywhere, peer=True), patience
        family = socket.AF_INET6 if ":" in self._peer[0] else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.settimeout(_AGAIN)
        weakref.finalize(self, self._socket.close)
        # Of another flight's answers none has a number of this one.
        self._seq = time.monotonic_ns() // 1000
        self._strange: tuple[Any] | None = None  # the number of an answer to something else

    def start(self, beginning: Beginning) -> Mapping[str, Any]:
        """Send where the flight begins; the truth there."""
        robot, surface = beginning.robot, beginning.surface
        told = {
            "step": beginning.step,
            "names": [*robot.shape_joints, *robot.vectoring_joints],
            "rotors": [{"name": one.name, "drag": one.drag_torque_coefficient} for one in robot.rotors],
            "thrusts": beginning.thrusts,
            "truth": beginning.truth,
            "surface": {
                "position": surface.position,
                "normal": -surface.R_WS[:, 0],
                "tip_radius": robot.tip.radius,
                "stiffness": surface.contact.stiffness,
                "damping": beginning.touch.damping,
                "friction": surface.friction,
            },
            "scene": beginning.scene,
        }
        return self._answer("start", told)

    def step(self, drive: Drive) -> Mapping[str, Any]:
        """Send what drives a step; the truth at its end."""
        return self._answer("drive", drive._asdict())

    def _answer(self, what: str, told: Mapping[str, Any]) -> Mapping[str, Any]:
        self._seq += 1
        data = msgspec.msgpack.encode({"seq": self._seq, what: told}, enc_hook=_plain)
        if len(data) > _LONGEST:
            raise UserCodeError(f"plant 'udp': the {what} has {len(data)} bytes; a datagram has {_LONGEST}")
        self._strange, end = None, time.monotonic() + self._patience
        while time.monotonic() < end:
            self._socket.sendto(data, self._peer)
            answer = self._heard(end)
            if answer is not None:
                return answer
        within = f"from {self._peer[0]}:{self._peer[1]} within {self._patience:g} s"
        if self._strange is None:
            raise UserCodeError(f"plant 'udp': no answer {within}")
        told, wanted = self._strange[0], self._seq
        raise UserCodeError(
            f"plant 'udp': no answer with seq {wanted} {within}; the last one has seq {told!r}"
        )

    def _heard(self, end: float) -> Mapping[str, Any] | None:
        """The truth of the answer to what was asked last; None where it did not come soon."""
        while time.monotonic() < end:
            try:
                data, sender = self._socket.recvfrom(_LONGEST)
            except OSError:  # silence, or nobody listens there yet
                return None
            if sender[:2] != self._peer:
                continue
            try:
                found = msgspec.msgpack.decode(data)
            except msgspec.MsgspecError:
                found = None
            if not isinstance(found, dict):
                raise UserCodeError("plant 'udp': an answer is no msgpack map")
            if found.get("seq") != self._seq:  # asked twice, answered twice
                self._strange = (found.get("seq"),)
                continue
            if "error" in found:
                raise UserCodeError(f"plant 'udp' says: {found['error']}")
            truth = found.get("truth")
            if not isinstance(truth, dict):
                raise UserCodeError("plant 'udp': an answer has no map 'truth'")
            return truth
        return None


def _plain(value: Any) -> Any:
    """Arrays as lists."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} goes over no socket")
