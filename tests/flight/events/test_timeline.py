"""What all events of a flight do together, and what is refused by name before anything flies."""

import math
import time
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.analysis.scores.signals import events_of
from skylimb.apps.cli import main
from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError
from skylimb.flight.events import (
    ALL_KINDS,
    CONTROLLER_KINDS,
    EVENTS,
    PLANT_KINDS,
    GainChange,
    Push,
    SurfaceChange,
    event_tables,
    events_from_mapping,
    require_applied,
)
from skylimb.flight.experiments.experiment import experiment_tables
from skylimb.flight.loading import plan_flights
from skylimb.flight.takeoff import take_off

KEY = "translation.force"
GAIN = {"kind": "gain", "time": 1.0, "key": KEY, "value": 2.0}
PUSH = {"kind": "push", "time": 1.0, "duration": 0.2, "force": [0.0, 1.0, 0.0]}
SURFACE = {"kind": "surface", "time": 1.0, "friction": 0.2}
ROTOR = {"kind": "rotor", "time": 1.0, "rotor": "rotor2", "effectiveness": 0.5}
LOST = {"kind": "body", "time": 1.0, "mass": -0.6, "point": [0.3, 0.0, 0.0]}
JOINT = {"kind": "joint", "time": 1.0, "joint": "joint2", "strength": 0.0}
WIND = {"kind": "wind", "time": 1.0, "duration": 0.5, "velocity": [0.0, 5.0, 0.0]}
ENCODER = {"kind": "sensor", "time": 1.0, "joint": "joint1", "offset": 0.1}
SECONDS = 2.0
"""Longest that a refusal may take, of the processor."""


@pytest.mark.parametrize(
    ("events", "words"),
    [
        ([GAIN, {**PUSH, "kind": "pusch"}], ["kind of events.1", "'pusch'", "did you mean 'push'"]),
        ([{**PUSH, "kind": ["push"]}], ["kind of events.0"]),
        ([{**PUSH, "kind": 3}], ["kind of events.0", "'3'"]),
        ([{"time": 1.0, "duration": 0.2}], ["'events.0.kind' is missing", "body, gain, joint, push, rotor"]),
        ([3], ["events.0 = 3", "a table"]),
        ({"kind": "push"}, ["events = ", "a list of tables"]),
        ([{**PUSH, "time": 99.0}], ["events.0.time = 99 s", "push at 99 s", "after the flight's end at"]),
        ([{**PUSH, "tme": 1.0}], ["'events.0.tme'", "did you mean 'events.0.time'"]),
        ([{"kind": "push", "time": 1.0}], ["'events.0.duration' is missing"]),
        ([{"kind": "gain", "time": 1.0, "key": KEY}], ["'events.0.value' is missing"]),
        ([{**GAIN, "key": "translation.forse"}], ["'translation.forse'", f"did you mean '{KEY}'"]),
        ([{**GAIN, "key": "force"}], ["'force'", "gain of controller following"]),
        ([{**PUSH, "link": "link9"}], ["link of a push 'link9'", "did you mean 'link"]),
        ([{**PUSH, "point": [0.1, 0.0, 0.0]}], ["events.0.point", "needs a link"]),
        ([GAIN, {**GAIN, "value": 3.0}], ["gain at 1 s", "contradict", f"{KEY} to 3 and to 2"]),
        (
            [SURFACE, {**SURFACE, "friction": 0.3, "slope": 0.1}],
            ["surface at 1 s", "contradict", "friction to 0.3 and to 0.2"],
        ),
        ([{"kind": "surface", "time": 1.0}], ["events.0", "changes nothing", "friction"]),
        ([{**PUSH, "duration": -0.2}], ["events.0.duration = -0.2 s"]),
        ([{**PUSH, "duration": 0.0}], ["events.0.duration = 0 s"]),
        ([{**GAIN, "duration": -1.0}], ["events.0.duration = -1 s"]),
        ([{**SURFACE, "duration": -1.0}], ["events.0.duration = -1 s"]),
        ([{**PUSH, "time": -1.0}], ["events.0.time = -1 s"]),
        ([{**PUSH, "time": math.nan}], ["events.0.time = nan"]),
        ([{**PUSH, "duration": math.inf}], ["events.0.duration = inf"]),
        ([{**PUSH, "force": [0.0, math.nan, 0.0]}], ["events.0.force", "nan"]),
        ([{**GAIN, "value": math.nan}], ["events.0.value", "nan"]),
        ([{**SURFACE, "position": [1.5, 0.0, math.nan]}], ["events.0.position", "nan"]),
        ([{**SURFACE, "stiffness": 9e5}], ["surface at 1 s", "too stiff"]),
        ([{**PUSH, "latest": 0.5}], ["events.0.latest = 0.5 s", "before time = 1 s"]),
        ([{**PUSH, "latest": 99.0}], ["events.0.latest = 99 s", "push at 1 s", "after the flight's end at"]),
        ([{**ROTOR, "rotor": "rotor5"}], ["rotor of an event 'rotor5'", "did you mean 'rotor"]),
        ([{**ROTOR, "effectiveness": -0.1}], ["events.0.effectiveness = -0.1"]),
        (
            [ROTOR, {**ROTOR, "effectiveness": 0.3}],
            ["rotor at 1 s", "rotor2 to 0.3 and to 0.5"],
        ),
        ([{**JOINT, "joint": "joint9"}], ["joint of an event 'joint9'", "did you mean 'joint"]),
        ([{**JOINT, "strength": None}], ["events.0.joint", "fails in no way"]),
        (
            [JOINT, {**JOINT, "strength": 1.0}],
            ["joint at 1 s", "joint2 strength to 1 and to 0"],
        ),
        ([{"kind": "tick", "time": 1.0, "duration": 0.0}], ["events.0.duration = 0 s"]),
        (
            [{"kind": "push", "time": 1.0, "duration": 0.002, "force": [20.0, 0.0, 0.0]}],
            ["events.0.duration = 0.002 s", "push at 1 s", "a control period of 0.005 s"],
        ),
        ([{**WIND, "drag_area": 0.0}], ["events.0.drag_area = 0 m^2"]),
        (
            [{**WIND, "velocity": [60.0, 0.0, 0.0], "drag_area": 1.0}],
            ["events.0.velocity", "2.2e+03 N, at most 100 N"],
        ),
        ([{**WIND, "profile": "storm"}], ["events.0.profile", "gust"]),
        ([{"kind": "sensor", "time": 1.0}], ["events.0.time", "changes nothing", "capture, late"]),
        ([{"kind": "sensor", "time": 1.0, "joint": "joint1"}], ["events.0.joint", "needs an offset"]),
        ([{**ENCODER, "joint": "joint9"}], ["encoder of an event 'joint9'", "did you mean 'joint"]),
        ([{**ENCODER, "late": 0.195}], ["events.0.late = 0.195 s"]),
        ([{**ENCODER, "late": 0.19, "capture": "disordered"}], ["sensor at 1 s", "0.22 s old", "0.2 s"]),
        ([{**ENCODER, "imu": "lost"}], ["sensor at 1 s", "no IMU", "sensors.imu.on"]),
        ([{**ENCODER, "capture": "gone"}], ["events.0.capture", "'lost'"]),
        ([{"kind": "body", "time": 1.0}], ["events.0.mass", "changes nothing"]),
        ([{"kind": "body", "time": 1.0, "mass": -1.5}], ["body at 1 s", "mass = -1.5 kg leaves -"]),
        (
            [{**LOST, "time": 1.2}, LOST],
            ["body at 1.2 s", "mass = -0.6 kg leaves -"],
        ),
        (
            [{"kind": "body", "time": 1.0, "link": "link1", "mass": -0.1}],
            [
                "body at 1 s",
                "mass = -0.1 kg at [0.0, 0.0, 0.0] m is more than the link has there",
                "no body has",
            ],
        ),
        ([{"kind": "body", "time": 1.0, "pen": 0.7}], ["body at 1 s", "pen = 0.7 m is more than link4"]),
        (
            [{"kind": "body", "time": 1.0, "pen": 0.4}, {"kind": "body", "time": 1.2, "pen": 0.4}],
            ["body at 1.2 s", "pen = 0.4 m, after 0.4 m before, is more than link4"],
        ),
    ],
)
def test_what_cannot_be_is_refused_by_name_soon_and_nothing_is_written(
    events: Any, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, out = tmp_path / "mine.toml", tmp_path / "out"
    tables = {key: value for key, value in experiment_tables("paper").items() if key != "events"}
    file.write_text(write_toml({**tables, "events": events}), encoding="utf-8")
    begun = time.process_time()
    settings = [f"{key}={value}" for key, value in HOLD.items()]
    code = main(["run", str(file), "--controller", "following", "--set", *settings, "--out", str(out)])
    taken = time.process_time() - begun
    said = capsys.readouterr().err
    assert code == 2
    assert said.startswith("skylimb: error: ")
    assert said.count("\n") == 1
    for word in words:
        assert word in said
    assert not out.exists()
    assert {path.name for path in tmp_path.iterdir()} == {"mine.toml"}
    assert taken < SECONDS


@pytest.mark.parametrize(
    "events",
    [
        [GAIN, GAIN],
        [GAIN, {**GAIN, "key": "attitude.damping_ratio", "value": [1.0, 1.0, 1.0]}],
        [GAIN, {**GAIN, "time": 1.005, "value": 3.0}],
        [SURFACE, SURFACE],
        [SURFACE, {**SURFACE, "slope": 0.1}],
        [PUSH, {**PUSH, "force": [1.0, 0.0, 0.0]}],  # pushes add up
    ],
)
def test_events_of_one_time_that_do_not_contradict_may_be(events: list[dict[str, Any]]) -> None:
    (takeoff,) = take_off("paper", ("following",), set={**HOLD, "events": events})
    assert takeoff.experiment.events == events_from_mapping(events, "here")


def test_a_timeline_is_what_each_kind_does() -> None:
    (takeoff,) = take_off("paper", ("following",), set={**HOLD, "events": [SURFACE, PUSH, GAIN]})
    found, times = takeoff.timeline(takeoff.times), takeoff.times
    assert found.gains is not None
    assert found.model is not None
    gain = np.interp(times, [1.0, 1.5], [takeoff.controller.gains().translation.force, 2.0])
    np.testing.assert_allclose(found.gains.values[:, 0], gain, atol=1e-12)
    friction = next(place.column for place in found.model.places if place.field == "pair_friction")
    assert found.model.values[0, friction] == takeoff.experiment.surface.friction
    assert found.model.values[-1, friction] == 0.2
    assert {(push.begin, push.end) for push in found.wrenches} == {(200, 240)}


def test_without_a_plant_only_the_controllers_events_are_there() -> None:
    (plan,) = plan_flights("paper", ("following",), set={**HOLD, "events": [SURFACE, PUSH, GAIN]})
    found = plan.timeline(plan.times)
    assert found.gains is not None
    assert found.model is None
    assert found.wrenches == ()


def test_a_flight_without_events_has_an_empty_timeline() -> None:
    (takeoff,) = take_off("paper", ("hybrid",), set=HOLD)
    found = takeoff.timeline(takeoff.times)
    assert (found.gains, found.model, found.wrenches) == (None, None, ())


def test_who_cannot_apply_an_event_says_what_it_can() -> None:
    assert {"gain"} == CONTROLLER_KINDS
    assert {"push", "surface", "rotor", "joint", "tick", "wind", "body", "sensor"} == PLANT_KINDS
    assert EVENTS.keys() == ALL_KINDS
    events = (GainChange(1.0, KEY, 2.0), Push(1.5, duration=0.2), SurfaceChange(2.0, slope=0.1))
    require_applied(events, ALL_KINDS, "this")
    require_applied(events[:1], CONTROLLER_KINDS, "a robot")
    words = r"events\.1: a robot cannot apply 'push' \(push at 1\.5 s\); it applies events of kind gain"
    with pytest.raises(ConfigError, match=words):
        require_applied(events, CONTROLLER_KINDS, "a robot")
    with pytest.raises(ConfigError, match=r"events\.0: nobody cannot apply 'gain'.*; it applies none"):
        require_applied(events, (), "nobody")


def test_a_seed_draws_when_an_event_begins_and_the_run_says_when() -> None:
    settings = {**HOLD, "events": [{**PUSH, "time": 0.5, "latest": 1.5}, {**ROTOR, "latest": 2.0}]}
    pairs = []
    for seed in (1, 1, 2):
        (takeoff,) = take_off("paper", ("following",), seed, settings)
        pairs.append(tuple(event.time for event in takeoff.experiment.events))
    assert pairs[0] == pairs[1]
    assert all(one != other for one, other in zip(pairs[0], pairs[2], strict=True))
    assert all(0.5 <= push <= 1.5 and 1.0 <= rotor <= 2.0 for push, rotor in pairs)
    run = skylimb.run("paper", "following", seed=1, set={**settings, "stop_at": 2.5})
    assert [one.time for one in events_of(run.log)] == list(pairs[0])
    again = events_from_mapping(tomllib.loads(run.config)["events"], "the run")
    assert [(event.time, event.latest) for event in again] == [(time, None) for time in pairs[0]]


def test_events_survive_the_way_through_their_tables() -> None:
    events = (
        GainChange(1.0, KEY, 2.0, duration=0.3),
        Push(1.5, duration=0.2, torque=(0.0, 0.1, 0.0), link="link2", point=(0.1, 0.0, 0.0)),
        SurfaceChange(2.0, slope=0.1, present=True),
    )
    tables = event_tables(events)
    assert [table["kind"] for table in tables] == ["gain", "push", "surface"]
    assert "position" not in tables[2]
    assert events_from_mapping(tables, "a file") == events
    assert events_from_mapping(events, "at hand") == events
