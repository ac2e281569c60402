"""What all events of a flight do together, and what is refused by name before anything flies."""

import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from short_flights import HOLD
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
SECONDS = 2.0
"""Longest that a refusal may take, of the processor."""


@pytest.mark.parametrize(
    ("events", "words"),
    [
        ([GAIN, {**PUSH, "kind": "pusch"}], ["kind of events.1", "'pusch'", "did you mean 'push'"]),
        ([{**PUSH, "kind": ["push"]}], ["kind of events.0"]),
        ([{**PUSH, "kind": 3}], ["kind of events.0", "'3'"]),
        ([{"time": 1.0, "duration": 0.2}], ["'events.0.kind' is missing", "gain, push, surface"]),
        ([3], ["events.0 = 3", "a table"]),
        ({"kind": "push"}, ["events = ", "a list of tables"]),
        ([{**PUSH, "time": 99.0}], ["events.0", "push at 99 s", "after the flight's end at"]),
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
    (push,) = found.wrenches
    assert (push.begin, push.end) == (200, 240)


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
    assert {"push", "surface"} == PLANT_KINDS
    assert EVENTS.keys() == ALL_KINDS
    events = (GainChange(1.0, KEY, 2.0), Push(1.5, duration=0.2), SurfaceChange(2.0, slope=0.1))
    require_applied(events, ALL_KINDS, "this")
    require_applied(events[:1], CONTROLLER_KINDS, "a robot")
    words = r"events\.1: a robot cannot apply 'push' \(push at 1\.5 s\); it applies events of kind gain"
    with pytest.raises(ConfigError, match=words):
        require_applied(events, CONTROLLER_KINDS, "a robot")
    with pytest.raises(ConfigError, match=r"events\.0: nobody cannot apply 'gain'.*; it applies none"):
        require_applied(events, (), "nobody")


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
