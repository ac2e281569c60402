"""One gesture is one mark, however many events it is."""

import pytest

from skylimb.apps.studio.gestures import marks_of
from told_session import Session

GAIN = "controller.attitude.damping_ratio"


@pytest.fixture
def session(short, tmp_path):
    return Session("paper", ("hybrid", "hybrid"), set=short, out=tmp_path)


def told(session):
    marks = marks_of(session.live.flights, session.pushed)
    return [(one["kind"], one["time"], round(one["duration"], 6), one["words"]) for one in marks]


def push(session, newtons):
    session.poke("link3", [0.0, 0.0, 0.0], [0.0, newtons, 0.0])
    session.advance(20)


def test_a_push_that_changes_is_one_mark_until_it_is_let_go(session):
    session.advance(19)
    for newtons in (0.5, 2.0, 1.0):
        push(session, newtons)
    assert told(session) == [("push", 0.1, 0.2, "up to 2 N on link3")]  # it is held, and goes nowhere yet
    session.release()
    assert told(session) == [("push", 0.1, 0.3, "up to 2 N on link3")]
    session.advance(10)
    push(session, 0.5)
    assert [mark[1] for mark in told(session)] == [0.1, 0.45]
    assert told(session)[1][2:] == (0.0, "0.5 N on link3")


def test_a_slider_and_a_drag_of_the_surface_are_one_mark_each(session):
    session.advance(19)
    for step in range(4):
        session.set_key(GAIN, 0.5 + 0.1 * step, None, 0)
        session.surface(position=[0.0, 0.001 * step, None])
        session.advance(20)
    (gain, surface) = told(session)
    assert gain[:3] == ("gain", 0.1, 0.4)
    assert "[0.8," in gain[3]
    assert surface[:3] == ("surface", 0.1, 0.5)
    session.advance(250)
    session.set_key(GAIN, 0.5, None, 0)
    assert len(told(session)) == 3
