"""Who drives, and what of the past is kept."""

from __future__ import annotations

import numpy as np
import pytest

from skylimb.apps.studio.server_access import Access, checked_token
from skylimb.apps.studio.server_pages import History, Page, Seats
from skylimb.base.errors import ConfigError


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time, s, as the only entry."""
    now = [100.0]
    monkeypatch.setattr("skylimb.apps.studio.server_pages.time.monotonic", lambda: now[0])
    return now


def test_the_seat_is_kept_for_a_while(clock: list[float]) -> None:
    seats, first, second = Seats(), Page("first"), Page("second")
    seats.enter(first)
    seats.enter(second)
    assert seats.drives(first)
    assert not seats.drives(second)
    assert seats.leave(first)
    clock[0] += 9.0
    assert not seats.give_free_seat()
    again = Page("first")
    seats.enter(again)
    assert seats.drives(again)
    seats.leave(again)
    clock[0] += 11.0
    assert seats.give_free_seat()
    assert seats.drives(second)


def test_a_page_has_few_frames_outstanding(clock: list[float]) -> None:
    page = Page("one")
    page.sent, page.got, page.sent_at = 5, 2, clock[0]
    assert not page.may_be_sent(6)
    page.got = 3
    assert page.may_be_sent(6)
    assert not page.may_be_sent(5)
    page.got = 2
    clock[0] += 1.5  # the confirmation is lost
    assert page.may_be_sent(6)


def test_the_past_is_thinned_and_forgets_what_was_rewound() -> None:
    history = History(period=0.05, most=100)
    for number in range(1, 101):
        history.add(number, np.array([number * 0.01], dtype="<f4"))
    kept = np.frombuffer(history.after(0), dtype="<f4")
    assert len(kept) == 20
    assert np.all(np.diff(kept) > 0.049)
    assert len(np.frombuffer(history.after(50), dtype="<f4")) == 10
    history.add(101, np.array([0.5], dtype="<f4"))
    assert np.frombuffer(history.after(0), dtype="<f4")[-1] <= 0.5


@pytest.mark.parametrize(
    ("host", "token", "said"),
    [
        ("0.0.0.0", "none", "not with --token none"),
        ("0.0.0.0", "", "can be reached by others"),
        ("127.0.0.1", "short", "at least 8"),
        ("::1", "with space 123", "letters"),
    ],
)
def test_a_token_that_protects_nothing_is_refused(host: str, token: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        checked_token(host, token)


def test_a_new_token_is_long_and_another_each_time() -> None:
    tokens = {checked_token("0.0.0.0", "new") for _ in range(5)}
    assert len(tokens) == 5
    assert min(map(len, tokens)) >= 16


@pytest.mark.parametrize(
    ("listens", "host", "known"),
    [
        ("127.0.0.1", "localhost:80", False),
        ("127.0.0.1", "localhost:8000", True),
        ("127.0.0.1", "[::1]:8000", True),
        ("127.0.0.1", "192.168.0.2:8000", False),
        ("0.0.0.0", "192.168.0.2:8000", True),
        ("0.0.0.0", "rebound.example:8000", False),
        ("lab.example", "lab.example:8000", True),
        ("lab.example", "localhost:8000", False),
        ("127.0.0.1", "localhost:x", False),
        ("127.0.0.1", None, False),
    ],
)
def test_a_host_is_known_by_its_names(listens: str, host: str | None, known: bool) -> None:
    assert Access(listens, 8000, "").knows_host(host) is known
