"""Every act is undone and done again, and every way can be come back to, with the bits that were flown."""

import numpy as np
import pytest

from skylimb.apps.studio.key_edits import value_now
from skylimb.base.errors import ConfigError
from told_session import Session

KEY = "controller.attitude.damping_ratio"


@pytest.fixture
def session(short, tmp_path):
    return Session("paper", ("hybrid",), set=short, out=tmp_path / "studio")


def flown(session):
    return session.live.flights[0].recent.copy()


def test_an_act_is_undone_and_done_again_to_the_bit(session):
    session.advance(49)
    before = value_now(session.live, KEY, 0)
    session.set_key(KEY, 0.5, entry=0)
    session.advance(30)
    session.poke("link4", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    session.advance(20)
    there = flown(session)
    session.undo()
    assert session.live.time == pytest.approx(0.4)
    session.undo()
    assert session.live.time == pytest.approx(0.25)
    assert value_now(session.live, KEY, 0) == before
    session.redo()
    session.redo()
    assert np.array_equal(flown(session), there, equal_nan=True)
    with pytest.raises(ConfigError, match="nothing to do again"):
        session.redo()


def test_what_follows_at_once_is_one_act(session):
    session.advance(49)
    for value in (0.5, 0.6, 0.7):
        session.set_key(KEY, value, entry=1)
        session.advance(10)
    session.undo()
    assert session.live.time == pytest.approx(0.25)
    with pytest.raises(ConfigError, match="nothing to undo"):
        session.undo()


def test_an_act_of_a_flight_that_waits_is_undone(session):
    session.advance(49)
    session.set_key(KEY, 0.5, entry=0)
    session.surface(friction=0.1)
    session.undo()
    assert value_now(session.live, KEY, 0)[0] == 0.5
    assert value_now(session.live, "surface.friction") != 0.1


def test_a_branch_is_come_back_to_also_over_a_new_take_off(session):
    session.advance(99)
    session.surface(position=[0.0, 0.02, None])
    session.advance(50)
    first = flown(session)
    session.rewind(0.3)
    session.set_key(KEY, 1.1, entry=2)
    session.advance(30)
    second = flown(session)
    session.restart()
    session.advance(20)
    told = session.branches.sent()["branches"]
    assert [(way["number"], way["parent"], way["since"], way["until"]) for way in told] == [
        (0, 0, 0.0, 0.75),
        (1, 0, 0.3, 0.45),
        (2, 2, 0.0, None),
    ]
    session.jump(0)
    assert np.array_equal(flown(session), first, equal_nan=True)
    session.jump(1)
    assert np.array_equal(flown(session), second, equal_nan=True)
    assert value_now(session.live, KEY, 0)[2] == 1.1
    session.advance(10)
    assert session.branches.here == 1  # it goes on where it was left
    with pytest.raises(ConfigError, match="branch 7 is not there"):
        session.jump(7)
    session.undo()  # the last jump
    assert np.array_equal(flown(session), first, equal_nan=True)


def test_rewinding_before_a_change_flies_without_it_to_the_bit(session, short, tmp_path):
    session.advance(99)
    session.set_key(KEY, 1.2, entry=0)
    session.surface(position=[0.0, 0.02, None])
    session.advance(50)
    session.rewind(0.2)
    session.advance(200)
    untouched = Session("paper", ("hybrid",), set=short, out=tmp_path / "other")
    untouched.advance(session.live.flights[0].ticks - 1)
    assert np.array_equal(flown(session), flown(untouched), equal_nan=True)
