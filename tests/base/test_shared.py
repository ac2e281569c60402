"""A context that several are in at once is entered once, and left by the last one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from skylimb.base.shared import shared


def test_the_first_enters_and_the_last_leaves() -> None:
    happened: list[str] = []

    @shared
    @contextmanager
    def setting() -> Iterator[None]:
        happened.append("set")
        yield
        happened.append("put back")

    for _ in range(2):
        first, second = setting(), setting()
        with first:
            second.__enter__()
            assert happened == ["set"]
        assert happened == ["set"]
        second.__exit__(None, None, None)
        assert happened == ["set", "put back"]
        happened.clear()


def test_what_cannot_be_entered_holds_nobody() -> None:
    fails = [True]

    @shared
    @contextmanager
    def setting() -> Iterator[None]:
        if fails.pop():
            raise OSError("not now")
        fails.append(False)
        yield

    with pytest.raises(OSError, match="not now"), setting():
        pass
    fails.append(False)
    with setting():
        assert fails == [False]
