"""A link over UDP: loopback unless one says otherwise."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Iterable
from typing import Any

from skylimb.base.errors import ConfigError
from skylimb.flight.realtime.link import Datagram
from skylimb.flight.realtime.messages import LONGEST

_FLOOD = 10_000
"""Datagrams that are thrown away at a tick at most, so that a flood cannot hold the tick up for ever."""


def address_of(text: str, anywhere: bool = False, peer: bool = False) -> tuple[str, int]:
    """Host and port of "127.0.0.1:9870".

    Args:
        text: the address.
        anywhere: whether it may be another than this machine's own.
        peer: whether somebody else listens there, who has a port; port 0 is any that is free.

    Raises:
        ConfigError: when it is none, or another machine's without `anywhere`.
    """
    host, _, port = text.rpartition(":")
    try:
        number, address = int(port), ipaddress.ip_address("127.0.0.1" if host == "localhost" else host)
    except ValueError:
        raise ConfigError(f"'{text}' is no address, for example 127.0.0.1:9870") from None
    if not peer <= number < 2**16:
        raise ConfigError(f"port {number} of '{text}' is outside of {int(peer)} .. 65535")
    if not address.is_loopback and not anywhere:
        raise ConfigError(
            f"{address} is not this machine, and whoever reaches the port commands the robot; "
            "--anywhere allows it, in Python anywhere=True"
        )
    return str(address), number


class UdpLink:
    """Datagrams to and from one peer.

    Args:
        own: host and port to listen on; port 0 for any that is free.
        peer: where to send to, and whose address alone is believed; None for whoever is answered (`answer`).
    """

    def __init__(self, own: tuple[str, int], peer: tuple[str, int] | None = None) -> None:
        family = socket.AF_INET6 if ":" in own[0] else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.bind(own)
        except OSError as error:
            self._socket.close()
            raise ConfigError(f"cannot listen on {own[0]}:{own[1]}: {error.strerror or error}") from error
        self._socket.setblocking(False)
        self._peer = peer
        self._named = None if peer is None else peer[0]

    @property
    def address(self) -> tuple[str, int]:
        """Where it listens."""
        host, port = self._socket.getsockname()[:2]
        return str(host), int(port)

    def receive(self, most: int) -> tuple[Iterable[Datagram], int]:
        """The newest datagrams that have come; older ones beyond `most` are thrown away."""
        found: list[Datagram] = []
        dropped = 0
        for _ in range(_FLOOD):
            try:
                data, sender = self._socket.recvfrom(LONGEST + 1)
            except OSError:  # nothing there, or the peer's port is closed: both mean silence
                break
            found.append(Datagram(data, sender, self._named not in (None, sender[0])))
            if len(found) > most:
                del found[0]
                dropped += 1
        return found, dropped

    def answer(self, sender: Any) -> None:
        """Send to whoever sent something from now on."""
        self._peer = sender

    def send(self, data: bytes) -> None:
        """Send one datagram; lost while nobody is known or there is no way."""
        if self._peer is not None:
            try:
                self._socket.sendto(data, self._peer)
            except OSError:
                return

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()
