"""What people may do to live flights."""

import json

import numpy as np
import pytest

from of_kind import of_kind
from skylimb.analysis.exchange.convert import read_log
from skylimb.analysis.exchange.recorder import FULL, FlightRecorder
from skylimb.analysis.scores.user_scores import scored
from skylimb.apps.studio.keeping import so_far
from skylimb.apps.studio.key_edits import value_now
from skylimb.apps.studio.live_flight import SETTLED
from skylimb.base.errors import ConfigError, SkylimbError, UnknownNameError
from skylimb.flight.events import GainChange, Push, SurfaceChange
from told_session import Session


@pytest.fixture
def session(short, tmp_path):
    return Session("paper", ("hybrid", "pid"), set=short, out=tmp_path / "studio")


def poses(session, scene, flight=0):
    begin, end = scene["layout"]["flights"][flight]["poses"]
    return session.live.frame(0.0, False)[begin:end].reshape(-1, 7)


def test_a_frame_has_what_the_scene_says(session):
    scene, frame = session.live.scene(), session.live.frame(0.0, False)
    json.dumps(scene, allow_nan=False)
    assert frame.dtype == np.float32
    assert len(frame) == scene["layout"]["size"]
    places = [place for flight in scene["layout"]["flights"] for place in flight.values()]
    assert [begin for begin, _ in places] == [3, *[end for _, end in places[:-1]]]
    for flight, place in zip(scene["flights"], scene["layout"]["flights"], strict=True):
        begin, end = place["curves"]
        assert sum(len(panel["curves"]) for panel in flight["panels"]) == end - begin
        assert place["poses"][1] - place["poses"][0] == 7 * flight["bodies"]


def test_a_frame_shows_where_the_robot_is(session):
    scene = session.live.scene()
    session.advance(80)
    flight = session.live.flights[0]
    place = scene["layout"]["flights"][0]
    frame = session.live.frame(0.0, False)
    root = flight.recent[-1, flight.slices["configuration"]][:7]
    body = scene["flights"][0]["body_names"].index(flight.takeoff.robot.description.root)
    assert poses(session, scene)[body] == pytest.approx(root, abs=1e-6)
    assert frame[0] == pytest.approx(session.live.time)
    thrusts = slice(*place["thrusts"])
    assert frame[thrusts] == pytest.approx(flight.recent[-1, flight.slices["thrusts"]], rel=1e-6)


def test_all_flights_fly_in_lockstep_until_all_are_over(session):
    assert session.advance(10) == 10
    assert [flight.ticks for flight in session.live.flights] == [11, 11]
    while session.advance(200):
        pass
    assert session.live.over
    assert session.live.verdict == ["came to its end", "came to its end"]
    assert [event["event"] for event in session.events()] == ["over"]
    assert session.advance(1) == 0
    assert session.events() == []


def test_a_poke_pushes_all_flights_until_it_is_released(session):
    session.advance(150)  # until the bias of the estimated force has been taken off
    session.poke("link4", [0.1, 0.0, 0.0], [0.0, 2.0, 0.0])
    session.advance(60)
    for flight in session.live.flights:
        assert 1.0 < flight.recent[-1, flight.slices["external_force_estimate"]][1] < 3.0
    session.poke("link4", [0.1, 0.0, 0.0], [0.0, 0.0, 1.0])
    session.advance(20)
    session.release()
    session.release()
    for flight in session.live.flights:
        first, second = of_kind(flight.experiment, Push)
        assert (first.time, first.duration) == (0.755, 0.3)
        assert (second.time, second.duration) == (1.055, 0.1)


def test_a_poke_of_the_wrong_shape_or_size_is_refused(session):
    for link, point, force in (
        ("leg", [0, 0, 0], [1, 0, 0]),
        ("link1", [0, 0], [1, 0, 0]),
        ("link1", [0, 0, 0], [1e3, 0, 0]),
    ):
        with pytest.raises(SkylimbError):
            session.poke(link, point, force)
    assert of_kind(session.live.flights[0].experiment, Push) == []


def test_a_gain_changes_in_flight_and_is_kept_by_a_restart(session):
    key = "controller.translation.damping_ratio"
    session.advance(20)
    assert session.set_key(key, [1.5, 1.5, 1.5], 0) == "in flight"
    assert value_now(session.live, key, 0) == (1.5, 1.5, 1.5)
    assert (session.live.known[key]["flights"], session.live.known[key]["acts"]) == ([0], "in flight")
    session.advance(40)
    session.restart()
    assert session.live.time == session.live.period
    assert of_kind(session.live.flights[0].experiment, GainChange) == []
    (control,) = [one for one in session.live.controls() if one["key"] == key]
    assert control["values"] == [[1.5, 1.5, 1.5]]


def test_a_key_restarts_and_a_wrong_one_changes_nothing(session):
    session.advance(20)
    for key, value in (
        ("sensors.latency", -1.0),
        ("sensors.latenc", 0.0),
        ("trajectory.file", "/etc/passwd"),
    ):
        with pytest.raises(SkylimbError):
            session.set_key(key, value)
    with pytest.raises(ConfigError):
        session.set_key("controller.translation.law", "evil.py", 0)
    assert session.live.time == pytest.approx(0.105)
    assert session.set_key("sensors.latency", 0.01) == "restarted"
    assert session.live.flights[1].experiment.sensors.latency == 0.01
    assert [event["event"] for event in session.events()] == ["restarted", "scene"]
    assert session.set_key("controller.shape.law", "fixed", 0) == "restarted"


def test_a_gain_that_nobody_has_is_named(session):
    with pytest.raises(UnknownNameError, match=r"did you mean 'controller\.translation\.damping_ratio'"):
        session.set_key("controller.translation.damping_rati", 1.0, 0)
    with pytest.raises(ConfigError, match="flight 1 has no gain"):
        session.set_key("controller.translation.damping_ratio", [1.0, 1.0, 1.0], 1)


def test_a_rewound_poke_is_no_longer_held(session):
    session.advance(50)
    session.poke("link4", [0.0, 0.0, 0.0], [0.0, 2.0, 0.0])
    session.advance(50)
    session.release()
    session.advance(50)
    session.rewind(session.live.time - 0.35)
    (push,) = of_kind(session.live.flights[0].experiment, Push)
    assert push.duration == pytest.approx(0.15)
    assert session.live.time == pytest.approx(0.405)
    session.advance(1)
    session.rewind(0.0)
    assert of_kind(session.live.flights[0].experiment, Push) == []


def test_scores_so_far_are_told_in_words_with_units(session):
    session.advance(300)
    assert session.live.scores() == {
        "flights": ["Hybrid", "PID"],
        "groups": [],
        "missed": {},
    }  # nothing slides yet
    session.advance(300)
    scores = session.scores()
    assert (scores["here"], scores["until"]) == (session.branches.here, session.live.time)
    rows = {row["label"]: row for group in scores["groups"] for row in group["rows"]}
    tilt = rows["largest tilt"]
    assert tilt["unit"] == "rad"
    assert all(0.0 <= float(value) < 1.0 for value in tilt["values"] if value)


def test_the_surface_is_moved_from_where_it_was_at_take_off(session):
    scene = session.live.scene()
    surface = session.live.flights[0].experiment.surface
    before = poses(session, scene)[-1]
    assert before[:3] == pytest.approx(surface.position, abs=1e-6)
    session.surface(position=[0.0, 0.05, -0.02], tilt=[0.1, 0.0])
    session.surface(friction=0.2)
    session.advance(20)
    (change,) = of_kind(session.live.flights[0].experiment, SurfaceChange)
    assert change.position == pytest.approx((1.5, 0.05, 1.18))
    assert (change.slope, change.pitch) == pytest.approx((surface.slope + 0.1, surface.pitch))
    assert 0.0 < poses(session, scene)[-1][1] < 0.05
    session.advance(30)
    after = poses(session, scene)[-1]
    assert after[:3] == pytest.approx([1.5, 0.05, 1.18], abs=1e-6)
    assert after[3:] @ before[3:] == pytest.approx(np.cos(0.05), abs=1e-6)
    begin, end = scene["layout"]["flights"][0]["surface"]
    assert session.live.frame(0.0, False)[begin:end] == pytest.approx(after)
    session.surface(present=False)
    session.advance(1)
    assert poses(session, scene)[-1][2] < -900.0
    assert not session.live.frame(0.0, False)[scene["layout"]["flights"][0]["present"][0]]
    session.rewind(0.0)
    session.advance(1)
    assert poses(session, scene)[-1] == pytest.approx(before)


def test_a_key_of_the_surface_acts_in_flight_and_is_kept_by_a_restart(session):
    session.advance(10)
    assert session.set_key("surface.friction", 0.25) == "in flight"
    assert value_now(session.live, "surface.friction") == 0.25
    session.restart()
    assert session.live.flights[0].experiment.surface.friction == 0.25
    assert of_kind(session.live.flights[0].experiment, SurfaceChange) == []
    with pytest.raises(SkylimbError):
        session.surface(friction=-1.0)
    with pytest.raises(SkylimbError):
        session.surface(position=[1.0])


def test_what_people_do_is_on_the_disk_as_it_is_flown(short, tmp_path):
    recorder = FlightRecorder(tmp_path)
    session = Session("paper", ("hybrid", "pid"), set=short, out=tmp_path / "studio")
    session.record(recorder)
    session.advance(60)
    session.poke("link1", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    session.advance(60)
    session.release()
    session.rewind(0.4)
    session.advance(round((0.2 + SETTLED) / session.live.period))
    recorder.close()
    for number, flight in enumerate(session.live.flights, 1):
        read = read_log(tmp_path / str(number) / "01-flight.mcap")
        assert read.notes == ()
        thrusts = flight.recent[:, flight.slices["thrusts_command"]]
        np.testing.assert_array_equal(read.run.log.thrusts_command, thrusts)
        assert '"push"' in read.run.config
    session.restart()
    assert (tmp_path / "2" / "02-flight.mcap").is_file()


def test_a_disk_that_is_full_is_told_once_and_the_flights_go_on(short, tmp_path):
    recorder = FlightRecorder(tmp_path)
    session = Session("paper", ("hybrid",), set=short, out=tmp_path / "studio")
    session.record(recorder)
    recorder.beside("1")._give_up()
    for _ in range(2):
        session.poll()
    told = session.events()
    assert [one["text"] for one in told if one["event"] == "trouble"] == [FULL]
    assert not [one for one in told if one["event"] == "error"]  # no controller has failed
    assert session.advance(5) == 5


def test_at_most_two_controllers_fly_beside_each_other(session, tmp_path):
    controllers = ("hybrid", "pid", "following")
    with pytest.raises(ConfigError, match="at most 2"):
        Session("paper", controllers, out=tmp_path)
    with pytest.raises(ConfigError, match="at most 2"):
        session.set_controllers(controllers)
    assert session.flown == ["hybrid", "pid"]


def test_what_is_done_to_a_flight_that_is_over_is_refused_and_no_act(session):
    while session.advance(200):
        pass
    before = session.branches
    for act in (
        lambda: session.poke("link4", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        lambda: session.surface(friction=0.9),
        lambda: session.surface(present=False),
    ):
        with pytest.raises(ConfigError, match=r"the flight is over; take off again \(R\)"):
            act()
    session.release()
    assert session.branches == before


def test_what_a_flight_missed_is_told_once_it_is_over(short, tmp_path):
    tight = {**short, "tolerances.contact": 1.0, "tolerances.path": 1e-6}
    session = Session("paper", ("hybrid",), set=tight, out=tmp_path)
    session.advance(600)
    assert (session.scores()["missed"], session.scores()["over"]) == ({}, False)
    while session.advance(200):
        pass
    told = session.scores()
    run = scored(so_far(session.live.flights[0]), ())
    assert run.missed
    assert (told["missed"], told["over"]) == ({"Hybrid": run.missed}, True)


def test_a_branch_takes_changes_along_from_its_beginning(session):
    gain = "controller.translation.damping_ratio"
    session.advance(100)
    session.rewind(0.3, [(gain, 1.5, 0, 1), (gain, 1.6, 0, 2)])
    (change,) = of_kind(session.live.flights[0].experiment, GainChange)
    assert change.time == pytest.approx(0.3)
    assert list(np.ravel(change.value)[1:]) == [1.5, 1.6]
    session.advance(10)
    with pytest.raises(SkylimbError):
        session.rewind(0.2, [(gain, -1.0, 0, 0)])
    assert session.live.time == pytest.approx(0.35)
    assert value_now(session.live, gain, 0)[1:] == (1.5, 1.6)
