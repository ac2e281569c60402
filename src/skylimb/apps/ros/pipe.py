"""Objects between the flight's process and that of ROS: nothing waits, not even for a slow reader."""

from __future__ import annotations

import pickle
import socket
import struct
from typing import Any

MOST = 64_000_000
"""Bytes that may wait for a reader; what comes on top is lost and counted."""

_HEADER = struct.Struct("<I")
_READ = 1 << 20


class Pipe:
    """One end of a pair of sockets.

    Args:
        end: connected; it is set not to wait.

    Attributes:
        lost: objects that could not be kept for the other end.
        closed: whether the other end is gone.
    """

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._socket, self._leaving, self._coming = end, bytearray(), bytearray()
        self.lost, self.closed = 0, False

    def fileno(self) -> int:
        """For `select`."""
        return self._socket.fileno()

    def send(self, value: Any) -> None:
        """Send an object as soon as the other end takes it."""
        if len(self._leaving) > MOST or self.closed:
            self.lost += 1
        else:
            data = pickle.dumps(value, protocol=5)
            self._leaving += _HEADER.pack(len(data)) + data
        self.flush()

    def flush(self) -> None:
        """Send what waits, as far as it is taken."""
        try:
            while self._leaving:
                del self._leaving[: self._socket.send(self._leaving)]
        except BlockingIOError:
            return
        except OSError:
            self.closed = True

    def receive(self) -> list[Any]:
        """All objects that have come whole."""
        try:
            while data := self._socket.recv(_READ):
                self._coming += data
            self.closed = True
        except BlockingIOError:
            pass
        except OSError:
            self.closed = True
        found = []
        while len(self._coming) >= _HEADER.size:
            (size,) = _HEADER.unpack_from(self._coming)
            if len(self._coming) < _HEADER.size + size:
                break
            found.append(pickle.loads(self._coming[_HEADER.size : _HEADER.size + size]))
            del self._coming[: _HEADER.size + size]
        return found

    def close(self) -> None:
        """Hang up."""
        self.closed = True
        self._socket.close()
