"""Objects between two processes: whole, in order, without waiting, and bounded."""

from __future__ import annotations

import socket

import numpy as np
import pytest

from skylimb.apps.ros import pipe as pipes
from skylimb.apps.ros.pipe import Pipe


def pair() -> tuple[Pipe, Pipe]:
    a, b = socket.socketpair()
    return Pipe(a), Pipe(b)


def test_large_and_small_come_in_order_and_whole() -> None:
    near, far = pair()
    values = [1, "two", {"three": np.arange(300_000)}, b"four" * 100_000]
    for value in values:
        near.send(value)
    found: list[object] = []
    for _ in range(100):
        found += far.receive()
        near.flush()
    assert found[:2] == values[:2]
    np.testing.assert_array_equal(found[2]["three"], values[2]["three"])  # type: ignore[index]
    assert found[3] == values[3]
    assert len(found) == 4


def test_nobody_waits_for_a_reader(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipes, "MOST", 500_000)
    near, far = pair()
    for _ in range(100):
        near.send(bytes(50_000))
    assert near.lost > 50
    assert len(far.receive()) >= 1


def test_a_reader_that_is_gone_is_noticed() -> None:
    near, far = pair()
    far.close()
    near.send(1)
    near.receive()
    assert near.closed
    near.send(2)
    assert near.lost == 1
