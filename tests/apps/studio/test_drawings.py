"""What people draw on the surface is flown where they drew it."""

import numpy as np
import pytest

from hostile_files import FILES
from skylimb.base.errors import ConfigError, OutputError
from skylimb.control.planning import svg_lines
from skylimb.control.planning.trajectories import drawing_strokes
from told_session import Session

STROKES = [[[0.05, 0.02], [0.15, 0.02], [0.15, 0.12]], [[-0.02, 0.0], [0.0, 0.1]]]


@pytest.fixture
def session(short, tmp_path):
    path = {key: value for key, value in short.items() if not key.startswith("trajectory.")}
    return Session("paper", ("following",), set=path, out=tmp_path / "out")


def test_strokes_are_drawn_where_they_were_made(session):
    path = session.draw(STROKES)
    assert path.parent == session.out / "drawings"
    assert [event["event"] for event in session.events()] == ["restarted", "scene"]
    takeoff = session.live.flights[0].takeoff
    surface, frame = takeoff.experiment.surface, takeoff.mission.frame
    found = drawing_strokes(takeoff.experiment.trajectory).lines
    for line, stroke in zip(found, STROKES, strict=True):
        points = np.array(stroke) @ surface.R_WS[:, 1:].T
        seen = np.stack([points @ frame.sliding_u, points @ frame.sliding_v], axis=1)
        assert line[[0, -1]] == pytest.approx(seen[[0, -1]], abs=2e-4)
    slide = takeoff.mission.tip_path[takeoff.mission.in_phase("slide")] - np.array(surface.position)
    assert slide[0] @ frame.sliding_u == pytest.approx(found[0][0, 0], abs=1e-3)
    assert session.advance(5) == 5


def test_an_svg_is_drawn_in_the_size_of_the_path(session):
    session.draw('<svg xmlns="http://www.w3.org/2000/svg"><path d="M 0 0 L 30 10" stroke="black"/></svg>')
    (line,) = drawing_strokes(session.live.flights[0].experiment.trajectory).lines
    assert np.ptp(line[:, 0]) == pytest.approx(session.live.flights[0].experiment.trajectory.width)


@pytest.mark.parametrize(
    "drawing", ["no svg", [], [[[0.0, 0.0]]], [[[0.0, "a"]]], [[[0.0, 0.0], [9.0, 0.0]]]]
)
def test_what_cannot_be_drawn_changes_nothing(session, drawing):
    flights = session.live.flights
    with pytest.raises(ConfigError):
        session.draw(drawing)
    assert session.live.flights == flights
    assert not list(session.out.glob("drawings/*"))


@pytest.mark.parametrize("name", ["use_bomb.svg", "groups.svg", "entities.svg"])
def test_a_hostile_svg_is_refused_in_a_line(session, name, monkeypatch):
    monkeypatch.setattr(svg_lines, "SECONDS", 1)
    flights = session.live.flights
    with pytest.raises(ConfigError) as refused:
        session.draw(FILES[name]())
    assert "\n" not in str(refused.value)
    assert session.live.flights == flights
    assert not list(session.out.glob("drawings/*"))


SQUARE = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M 0 0 L 30 0 L 30 30 Z" stroke="black"/></svg>'


def path_of(session):
    return session.live.flights[0].experiment.trajectory


def test_words_and_a_file_take_each_others_place(session):
    session.draw(STROKES)
    session.write("Dr.Who", "scripts")
    assert (path_of(session).text, path_of(session).font, path_of(session).file) == ("Dr.Who", "scripts", "")
    session.draw(SQUARE)
    assert (path_of(session).text, path_of(session).shape) == ("", "drawing")
    session.set_key("trajectory.text", "and/or")
    assert (path_of(session).text, path_of(session).file) == ("and/or", "")
    with pytest.raises(ConfigError, match="font"):
        session.write("hi", "comic")
    assert path_of(session).text == "and/or"


def test_back_to_the_preset_takes_the_file_along(session):
    first = path_of(session)
    session.draw(STROKES)
    session.back(True)
    assert path_of(session) == first
    session.write("hi")
    assert path_of(session).text == "hi"


def test_a_file_after_a_drawing_by_hand_is_as_large_as_usual(session):
    usual = path_of(session)
    session.draw(STROKES)
    assert path_of(session).width < 0.5 * usual.width
    session.draw(SQUARE)
    assert (path_of(session).width, path_of(session).center) == (usual.width, usual.center)
    session.set_key("trajectory.width", 0.3)
    session.write("hi")  # what was asked for stays
    assert path_of(session).width == 0.3


def test_an_error_names_the_file_that_was_given(session):
    with pytest.raises(ConfigError, match=r"^SVG file 'empty\.svg' has nothing to draw"):
        session.draw('<svg xmlns="http://www.w3.org/2000/svg"/>', "empty.svg")


def test_a_drawing_that_cannot_be_written_is_refused_in_a_line_and_the_flights_go_on(session):
    session.out.mkdir(parents=True)
    (session.out / "drawings").write_text("in the way of the folder", encoding="utf-8")
    flights = session.live.flights
    with pytest.raises(OutputError, match=r"cannot write '.*drawings'"):
        session.draw(STROKES)
    assert session.live.flights == flights
    assert session.advance(5) == 5
