"""A user's controller is reloaded on save, and its mistakes end nothing."""

import os

import numpy as np
import pytest

from failing_controller import save_failing_controller
from of_kind import of_kind
from skylimb.apps.studio.watching import Watcher
from skylimb.flight.events import Push
from told_session import Session


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "still.py"
    save_failing_controller(path, 20)
    return path


@pytest.fixture
def session(file, short, tmp_path):
    return Session("free_flight", (str(file), "pid"), out=tmp_path / "out")


def events(session, *kinds):
    return [event for event in session.events() if event["event"] in kinds]


def test_an_exception_in_flight_is_told_with_its_line_and_the_other_flight_goes_on(session, file):
    session.advance(60)
    (error,) = events(session, "error")
    assert error["flight"] == 0
    assert error["file"] == str(file)
    assert "too late" in error["text"]
    assert "raise ZeroDivisionError" in file.read_text().splitlines()[error["line"] - 1]
    assert session.live.flights[0].over
    assert session.live.flights[1].ticks == 61
    assert "too late" in session.live.verdict[0]
    assert not session.live.over


def test_an_edited_file_is_flown_from_take_off(session, file):
    session.advance(40)
    save_failing_controller(file, 1000)
    session.poll()
    told = events(session, "restarted", "scene")
    assert "still.py was edited" in told[0]["why"]
    session.advance(40)
    assert session.live.flights[0].ticks == 41
    session.poll()
    assert events(session, "restarted") == []


def test_a_file_with_a_mistake_leaves_the_flights_as_they_are(session, file):
    session.advance(10)
    flights = session.live.flights
    file.write_text("def controller(robot:\n")
    session.poll()
    (error,) = events(session, "error")
    assert (error["file"], error["line"]) == (str(file), 1)
    assert error["flying"].startswith("What flies is still.py as it was at ")
    assert session.live.flights == flights
    assert session.advance(5) == 5
    session.poll()
    assert events(session, "error") == []
    save_failing_controller(file, 1000)
    session.poll()
    assert events(session, "error", "restarted")[0]["event"] == "restarted"


def test_a_flight_in_python_is_poked_and_rewound(session, file):
    save_failing_controller(file, 10**6)
    session.poll()
    session.advance(20)
    session.poke("link1", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    session.advance(20)
    there = session.live.flights[0].recent.copy()
    session.advance(10)
    session.rewind(session.live.time - 0.05)
    assert session.live.flights[0].ticks == 41
    assert np.array_equal(session.live.flights[0].recent, there, equal_nan=True)
    (push,) = of_kind(session.live.flights[0].experiment, Push)
    assert push.duration == pytest.approx(0.1)


def test_a_file_that_is_touched_or_gone_is_not_edited(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text("one")
    watcher = Watcher([path])
    assert watcher.changed() == []
    os.utime(path, ns=(1, 1))
    assert watcher.changed() == []
    path.unlink()
    assert watcher.changed() == []
    path.write_text("two")
    assert watcher.changed() == [path]
    assert watcher.changed() == []
